// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Answers what the page asks about a world. What writes or runs is a POST, and is refused without
// `--watch`.
//
//   GET  api/live                             objects, uniforms, fablets, diagnostics
//   GET  api/source?fablet=N                  {"text", "stamp"}
//   GET  api/places?fablet=N                  where a hand has put nodes (graph_places.h)
//   GET  api/texture?name=…&volume=0          a small PNG of a texture (texture_look.h)
//   POST api/check   {"fablet", "text"}       {"diagnostics"}, of a text that is not saved
//   POST api/graph   {"fablet", "text"}       the graph of a text (compiler/graph/service.h)
//   POST api/edit    {"fablet", "text", "action"}   {"text", "graph"}, after an action; nothing is saved
//   POST api/palette {"fablet", "text"}       what can be added to a graph
//   POST api/picture {"fablet", "text", "action"}   what a function of the palette looks like
//   POST api/look    {"fablet", "text", "action"}   what nodes are at voxels (node_look.h)
//   POST api/assist  {"fablet", "text", "action"}   what somebody who types wants to know (compiler/graph/assist.h)
//   POST api/source  {"fablet", "text", "stamp"}   saves it; {"stamp"}
//   POST api/places  {"fablet", "places"}     keeps them
//   POST api/set     {"object", "uniform", "value"}
//   POST api/draft   {"draft"}   0: as fine as the part needs
//   POST api/part    {"edits"}   of the world, by the panel "Part" (part_edit.h)
//   POST api/unpart, api/repart   {}   takes back the last of these, or does it again
//   POST api/show    {"full"}    1: the last whole print is in view, 0: the draft
//   POST api/revert, api/write   {}
//   POST api/upload?name=…&at=N   the next bytes of a file that was dropped
//   POST api/use     {"name", "object"}   makes it part of the world; {"name", "mesh", "notes"}
//   POST api/print, api/stop   {}   the whole print, to a file beside the world
//   POST api/template   {"name"}   of a world that `openfab view --new` made

#include <optional>

#include "tools/viewer/http_server.h"
#include "tools/viewer/live.h"

namespace openfab::viewer {

/// Answers a request, or nothing where the path is none of these.
std::optional<Answer> answer_on_world(Live* live, const Request& request);

}  // namespace openfab::viewer

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The graph in the language server: methods of our own, for pages and editors that draw it. Each is about a text, which
// need not be open or saved.
//
//   openfl/graph    {path, text}           the graph
//   openfl/edit     {path, text, action}   {"text", "graph"} after an action (edit.h); an error says why it is refused
//   openfl/palette  {path, text}           what can be added
//   openfl/picture  {action: {signature, module}}   what one of these looks like (picture.h); {} if nothing is known
//   openfl/look     {path, text, action: {tab, nodes, …}}   the text with prints of values (look.h)
//   openfl/assist   {path, text, action: {ask, line, character}}   completions, help, signatures, layout (assist.h)
//
// `path` is the file that the text is to be, for the modules beside it.

#include <optional>
#include <string_view>

#include "base/json.h"
#include "base/json_text.h"
#include "base/result.h"

namespace openfab::graph {

/// Answers a request into `out`; nothing if the method is none of these.
std::optional<Result<void>> answer(std::string_view method, const JsonValue& params, JsonText* out);

}  // namespace openfab::graph

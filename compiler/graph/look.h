// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What nodes are at voxels: the document with a `printf` for each value of a stage or function, to be compiled with
// prints and run on its world. A line's text begins with `=`, the number of the node, and the value's numbers; one that
// begins with `@` says where on the tray the voxel of the point is: the part's number in the build, x, y and z in mm.

#include <string>
#include <vector>

#include "base/json.h"
#include "base/json_text.h"
#include "base/result.h"
#include "compiler/graph/graph.h"

namespace openfab::graph {

struct LookedAt {
    int node = -1;
    std::string type;
    int numbers = 1;  ///< of a mixture, an amount for each of `materials`
};

struct Looks {
    std::string text;
    bool has_places = false;  ///< there are lines with `@`
    std::vector<LookedAt> values;
    std::vector<std::string> materials;  ///< uniforms of the fablet
};

/// Returns the document with prints of the nodes of a tab; of all that have numbers where none is named. A user error
/// where a stage cannot print.
Result<Looks> looks_of(const server::Analysis& analysis, const Graph& graph, int tab,
                       const std::vector<int>& nodes);

/// Writes {"text", "places", "values": [{"node", "type", "numbers"}], "materials"}.
void write_looks(const Looks& looks, JsonText* out);

}  // namespace openfab::graph

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What nodes are at voxels: the document with a `printf` for each value of a stage or function, to be compiled with
// prints and run on its world. A line's text begins with `=`, the number of the node, and the value's numbers; one that
// begins with `@` says where on the tray the voxel of the point is: the part's number in the build, x, y and z in mm.

#include <array>
#include <optional>
#include <string>
#include <utility>
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
    bool is_surface = false;  ///< values are those of points of the surface
    std::vector<LookedAt> values;
    std::vector<std::string> materials;  ///< uniforms of the fablet
};

/// Which voxels of @Volume print: all, but for what is given.
struct LookedWhere {
    double shell_mm = 0;  ///< above 0: those that are at most so deep
    /// Those whose centres on the tray are from the first on and below the second, along x, y and z.
    std::array<std::optional<std::pair<double, double>>, 3> within_mm;
};

/// Reads {"shell_mm": …, "within_mm": [[…, …] or null, …]}, neither of which must be there.
LookedWhere looked_where(const JsonValue& action);

/// Returns the document with prints of the nodes of a tab; of all that have numbers where none is named. A user error
/// where a stage cannot print.
Result<Looks> looks_of(const server::Analysis& analysis, const Graph& graph, int tab,
                       const std::vector<int>& nodes, const LookedWhere& where = {});

/// Writes {"text", "places", "surface", "values": [{"node", "type", "numbers"}], "materials"}.
void write_looks(const Looks& looks, JsonText* out);

}  // namespace openfab::graph

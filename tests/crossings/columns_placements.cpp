// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Columns of worlds: where things are placed, and how they meet.

#include "tests/crossings/columns.h"

namespace openfab::testing {

std::vector<Column> placement_columns() {
    std::vector<Column> all;
    const auto add = [&](const char* id, const char* what, Change change,
                         std::vector<std::string> shows = {}) {
        all.push_back({id, what, std::move(change), nullptr, std::move(shows)});
    };
    add("plain", "printed as it is", {.options = {"--dither", "majority"}, .anchor = false},
        {"print", "npy", "--output", "--format"});
    add("bed", "put on the bed", {.placement = R"("translate_mm": [3.1, 4.2])"});
    add("bed alone", "put on the bed, alone",
        {.placement = R"("translate_mm": [3.1, 4.2])",
         .options = {"--dither", "majority"},
         .anchor = false});
    add("steps", "a grid of copies, by steps",
        {.placement = R"("grid": {"count": [2, 2], "step_mm": 6.1})"});
    add("gaps", "a grid of copies, by gaps",
        {.placement = R"("translate_mm": [0, 0], "grid": {"count": [2, 2], "spacing_mm": 0.7})"});
    add("rows", "`arrange` of a world",
        {.world = R"(, "arrange": {"columns": 2, "spacing_mm": 0.8})",
         .build = R"({ALL}, {ALL, "rotate_deg": [0, 0, 40]}, {ALL, "scale": 0.8})",
         .options = {"--dither", "majority"},
         .anchor = false});
    add("scale", "scaled", {.placement = R"("scale": 1.35)"});
    add("stretch", "stretched", {.placement = R"("scale": [1.4, 1, 0.8])"});
    add("mirror", "mirrored", {.placement = R"("scale": [-1, 1, 1])"});
    add("turn", "turned about x, y and z", {.placement = R"("rotate_deg": [25, -40, 70])"});
    add("matrix", "placed by a matrix that shears",
        {.placement = R"("matrix": [1, 0.3, 0, 1, 0, 1, 0, 2, 0, 0, 1, 0])"});
    add("tray", "on a tray",
        {.placement = R"("translate_mm": [8.3, 9.1])",
         .world = R"(, "tray": "corner")",
         .options = {"--crop", "tray"},
         .anchor = false},
        {"--crop"});
    add("beyond", "beyond a tray",
        {.placement = R"("translate_mm": [-3.3, 9.1])",
         .world = R"(, "tray": "corner")",
         .anchor = false});
    add("over", "over a body of lower priority",
        {.items = R"(, {"object": "low", "translate_mm": [-1, -1, 1]})"});
    add("under", "under a body of higher priority",
        {.items = R"(, {"object": "high", "translate_mm": [-1, -1, 1]})"});
    add("support", "support", {.options = {"--support", "right"}}, {"--support"});
    return all;
}

}  // namespace openfab::testing

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads beams as text, one thing a line (world/WORLDS.md, "Beams"):
//
//   attribute NAME float|float2|float3|float4|int
//   node X Y Z RADIUS [a value for each component of float attributes]
//   strut A B [R R] [a value for each int attribute]
//   ball A [a value for each int attribute]
//   ends ball|flat|dome [flat|dome]
//
// Nodes count from 0. A strut is the hull of the balls at its ends, of the nodes' radii or of two of its
// own; behind a line `ends` struts are cones cut across, with half a ball on an end that is a dome. Blanks
// or commas separate, # begins a comment.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "mesh/model/beams.h"

namespace openfab::mesh {

/// Beams as a file has them, in its unit.
struct ReadBeams {
    Beams beams;
    double unit_mm = 1;
    std::vector<std::string> warnings;
};

/// Parses the text of a file. Errors name the line: a malformed number, another count, a node that does
/// not exist, beams without an inside, more memory than `memory_bytes`.
Result<ReadBeams> parse_beams(std::string_view bytes, const std::filesystem::path& file,
                              int64_t memory_bytes);

}  // namespace openfab::mesh

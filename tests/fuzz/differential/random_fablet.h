// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Writes random well-typed fablets as OpenFL text. A fablet holds several programs, one function
// each, whose results are the weights of its materials: compiling has a fixed cost, so programs
// share it. Equal seeds give equal text everywhere.

#include <cstdint>
#include <string>
#include <vector>

namespace openfab::testing {

/// Programs in one fablet; the material of program k is `m<k>`.
constexpr int kProgramsPerFablet = 10;

/// `@nearest float4 f, int2 i`, `distance(attr.voxelCenter)`, `attr.voxelCenter`, and the uniforms
/// `float scale`, `int3 counts`, `float table[5]` are the inputs of the programs.
std::string random_fablet(uint64_t seed);

}  // namespace openfab::testing

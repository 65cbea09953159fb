// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Random well-typed volume stages, from a seed.

#include <cstdint>
#include <random>

#include "compiler/ir/ir.h"

namespace openfab::testing {

/// Inputs of every random stage: @nearest float 0 (3 components) and int 1 (2 components), the
/// distance, voxel coordinates, a float and an int uniform.
constexpr int32_t kRandomFloats = 3;
constexpr int32_t kRandomInts = 2;
constexpr int32_t kFloatUniform = 0;
constexpr int32_t kIntUniform = 1;

/// `operations` instructions after the inputs and some constants; the last values of each type are
/// outputs.
ir::Stage random_stage(uint32_t seed, int32_t operations);
/// Same, including functions (compiler/functions).
ir::Stage random_stage_with_functions(uint32_t seed, int32_t operations);

/// Same, including (nested) loops, queries and printfs.
ir::Stage random_looping_stage(uint32_t seed, int32_t operations);

/// A float such as a fablet may encounter: mostly of ordinary size, sometimes 0, an integer, huge
/// or tiny; finite.
float random_float(std::mt19937* random);
int32_t random_int(std::mt19937* random);

}  // namespace openfab::testing

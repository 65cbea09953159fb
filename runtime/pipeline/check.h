// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "runtime/pipeline/print_input.h"
#include "runtime/pipeline/print_options.h"
#include "runtime/solid/solid.h"

namespace openfab::pipeline {

/// Rejects input that the pipeline cannot run: an unknown dither, too many materials, a pitch or
/// memory budget out of range, and (our bug) a fablet whose kernels take arguments that do not
/// belong to their stage.
Result<void> check_input(const PrintInput& input, const PrintOptions& options);

/// Returns a warning for each surface whose micropolygons are crowded (surface/crowding.h), of the
/// first few. `owners` is from volume::solid_owners.
std::vector<std::string> crowded_warnings(const std::vector<part::Part>& parts,
                                          const std::vector<int32_t>& owners,
                                          const std::vector<std::shared_ptr<solid::Solid>>& solids);

}  // namespace openfab::pipeline

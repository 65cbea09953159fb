// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The provenance of a print: everything that determines its voxels, in short form. It is written
// beside the slices, so that an interrupted print is resumed only by an identical one.

#include <string>
#include <utility>
#include <vector>

#include "runtime/pipeline/print_input.h"
#include "runtime/pipeline/print_options.h"

namespace openfab::pipeline {

/// Returns names and values: settings in plain text, the rest as hashes of 16 digits. Excluded are
/// fields of PrintInfo (pitch, range, materials, seed) and everything that never changes a voxel:
/// threads, memory, culling, schedules, instruction sets. New inputs that change a voxel must be
/// added here. Reads all meshes and textures once.
std::vector<std::pair<std::string, std::string>> provenance(const PrintInput& input,
                                                            const PrintOptions& options);

}  // namespace openfab::pipeline

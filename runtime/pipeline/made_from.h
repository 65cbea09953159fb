// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What decides the voxels of a print, in a few words: written beside the slices, so that a print
// that was cut short is gone on with by the same one only.

#include <string>
#include <utility>
#include <vector>

#include "runtime/pipeline/print.h"

namespace openfab::slab {

/// Names and values: settings as they are, the rest as hashes of 16 digits. Not in it is what
/// PrintInfo tells (pitch, range, materials, seed), and what never decides a voxel: threads,
/// memory, culling, schedules, instruction sets. Whatever is added to parts or options that does
/// decide one belongs in here too. Reads all meshes and textures once.
std::vector<std::pair<std::string, std::string>> made_from(const PrintInput& input,
                                                           const PrintOptions& options);

}  // namespace openfab::slab

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads a print, an .ofr file or a folder of slices, into a volume that fits the memory.

#include <cstdint>
#include <string>
#include <vector>

#include "runtime/pipeline/slice_sink.h"
#include "tools/render/volume.h"

namespace openfab::render {

struct ReadPrint {
    pipeline::PrintInfo info;
    Volume volume;
    Vec3i cell{1, 1, 1};  ///< voxels of the print a voxel of the volume
    int32_t slices = 0;   ///< that were there
    /// The print's materials whose mixtures are the codes of a volume of larger cells.
    std::vector<uint8_t> mixed;
    std::vector<std::vector<uint8_t>> mixtures;
};

/// Reads at the print's own pitch, or at the finest that fits; support material, which is washed off,
/// is void.
Result<ReadPrint> read_print(const std::string& path, int64_t memory_bytes);

}  // namespace openfab::render

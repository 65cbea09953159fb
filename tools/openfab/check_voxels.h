// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The voxels that a check looks at: those of a print, or of a world that is printed for it.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "backends/ofr/ofr_reader.h"
#include "base/result.h"
#include "tools/openfab/check_findings.h"

namespace openfab::tools {

/// The grid of a print that is to be looked at.
struct Grid {
    Vec3i size;
    Vec3d pitch_mm;
    int32_t parts = 1;  ///< of the machine's voxels along each axis
};

Grid grid_of(const pipeline::PrintInfo& info, int32_t parts);
/// Returns about what a grid becomes with voxels of a size that is `larger` times its own.
Grid coarser(const Grid& grid, double larger);

/// Reads all voxels, with a margin of one voxel of void.
Result<CheckedPrint> read_print(ofr::OfrReader* reader, int32_t parts);

/// Executes `openfab print` with its output in `file`, and shows its progress and warnings where it takes long. Asks `takes` as soon
/// as the grid is known, and stops the print where it is not taken: returns that grid.
Result<std::optional<Grid>> print_for_check(const std::vector<std::string>& argv,
                                            const std::filesystem::path& file, int32_t parts,
                                            int64_t memory,
                                            const std::function<bool(const Grid&)>& takes);

}  // namespace openfab::tools

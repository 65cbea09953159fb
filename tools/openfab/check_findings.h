// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is wrong with the voxels of a print, by the limits of a machine.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/result.h"
#include "runtime/pipeline/slice_sink.h"
#include "tools/inspection/bits.h"
#include "world/process.h"

namespace openfab::tools {

/// The voxels of a print that is looked at.
struct CheckedPrint {
    pipeline::PrintInfo info;
    inspection::Box<uint8_t> codes;
    int32_t parts = 1;  ///< of the machine's voxels along each axis
};

enum class Fault : uint8_t { kWall, kGap, kHole, kIsland, kTrappedVoid, kTrappedSupport, kTouch };

struct Finding {
    Fault fault = Fault::kWall;
    std::string material;  ///< empty: all that is solid
    double measure = 0, limit = 0;
    inspection::Cluster where;
    std::vector<Vec3i> voxels;
};

/// Returns a fault's name, and the unit of what is measured.
const char* name_of(Fault fault);
const char* unit_of(Fault fault);

/// Bytes a voxel that find_faults takes, the codes included.
constexpr int64_t kCheckBytesPerVoxel = 8;
/// Bytes that find_faults takes for a print of so many voxels, each `parts` ones of the machine's: gaps and holes are looked at
/// in a box that is larger by their limits.
int64_t check_bytes(const Vec3i& size, const Vec3d& pitch_mm, int32_t parts,
                    const world::Checks& limits);

/// Finds them, the worst of each kind first. Names that no material has go to `notes`.
/// `begins` is called with what is looked for, and which of how many looks it is.
Result<std::vector<Finding>> find_faults(const CheckedPrint& print, const world::Checks& limits,
                                         std::vector<std::string>* notes,
                                         const std::function<void(const char*, int, int)>& begins);

/// Encodes a PNG of the print from the front, the right and above, with the findings in colour; empty where
/// memory ran out.
std::vector<uint8_t> picture_of(const CheckedPrint& print, const std::vector<Finding>& findings);

}  // namespace openfab::tools

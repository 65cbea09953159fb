// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads the solids of a STEP file as triangles. The one file behind it is the only one that uses OpenCASCADE.

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/vec.h"

namespace openfab::tools {

struct StepSolid {
    std::string name;  ///< of the part, or of the assembly that holds it; may be empty
    std::optional<std::array<double, 3>> color;     ///< linear light
    std::vector<Vec3d> vertices;                    ///< mm; each once
    std::vector<std::array<int32_t, 3>> triangles;  ///< outward
};

struct StepFile {
    std::vector<StepSolid> solids;   ///< each in its place in the assembly
    std::vector<std::string> notes;  ///< what was left out
};

/// Reads a file. Triangles are at most `tolerance_mm` from the surfaces, and turn by at most 0.5 radians along
/// them. Errors: no STEP file, no solid in it, a solid that cannot be divided.
Result<StepFile> read_step(const std::filesystem::path& file, double tolerance_mm);

}  // namespace openfab::tools

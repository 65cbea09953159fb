// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Loads beams from a file, by its extension, in millimetres.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "mesh/model/beams.h"
#include "mesh/model/look.h"

namespace openfab::mesh {

struct BeamOptions {
    std::optional<double> unit_mm;  ///< without it that of the file, which is mm in text
    std::string body;               ///< the lattice of a 3MF file of this name; empty: all
    int64_t memory_bytes = kDefaultReadingBytes;
};

struct LoadedBeams {
    Beams beams;
    std::vector<std::string> warnings;
};

/// A lattice of a 3MF file.
struct LatticeInfo {
    std::string name;               ///< BeamOptions::body
    std::vector<std::string> sets;  ///< of beams, from number 1 of the int attribute `set`
    Box3d box_mm;
    int64_t beams = 0;  ///< and balls
};

struct LoadedLattices {
    std::vector<LatticeInfo> lattices;  ///< empty where the file is no 3MF, or has none
    bool has_meshes = true;             ///< whether the file's build places meshes, too
    double unit_mm = 1;
    std::vector<LeftOut> left_out;
};

/// Finds the beam lattices that a file places beside its meshes.
Result<LoadedLattices> load_lattices(const std::filesystem::path& file, const BeamOptions& options);

/// Reads beams. Errors name the file, and the line in text.
Result<LoadedBeams> load_beams(const std::filesystem::path& file, const BeamOptions& options);

}  // namespace openfab::mesh

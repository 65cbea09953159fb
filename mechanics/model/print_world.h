// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Has worlds printed as arrays of mixtures or codes, by `openfab print` beside this program. What is asked
// about a world that is not in its file is asked by options of the print: no world is written.

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"

namespace openfab::mechanics {

constexpr size_t kMostWorldBytes = 256'000'000;  ///< as a print takes them

/// A texture of the world that is another volume.
struct FieldTexture {
    std::string name;
    std::filesystem::path file;
    std::array<double, 3> origin_mm{}, spacing_mm{};
};

struct PrintRequest {
    std::filesystem::path world;
    std::filesystem::path programs;
    std::array<double, 3> pitch_mm{};  ///< 0: the printer's own
    /// An element is the mean over so many parts along each axis; 0: over the printer's voxels.
    int supersample = 0;
    bool codes = false;
    std::string dither;  ///< of codes
    std::vector<std::string> settings, allow;
    std::optional<FieldTexture> field;
    int threads = 1;
    int64_t memory_bytes = 0;
    /// Elements begin at a whole number of these, next to the part; 0: at a whole number of pitches.
    std::array<double, 3> lattice_mm{};
};

/// Writes `folder`/NAME.npy, of the part that comes out of the machine, and returns its path.
Result<std::filesystem::path> print_voxels(const PrintRequest& request,
                                           const std::filesystem::path& folder,
                                           const std::string& name);

/// The same of the lowest slices alone, or of all where `slices` is 0, as codes without a dither.
Result<std::filesystem::path> print_lowest(const PrintRequest& request, int slices,
                                           const std::filesystem::path& folder);

/// Writes where an object of the world is, where the build has it, else where its mesh lies: all of it
/// that is in the grid of the build and `around` voxels about it is of the first material.
Result<std::filesystem::path> print_object(const PrintRequest& request, const std::string& object,
                                           int around, const std::filesystem::path& folder);

/// A box of the fablet of an object, in place of what the world builds, and where it is moved.
struct CellBox {
    std::string object;
    std::array<double, 3> size_mm{}, at_mm{};
};
Result<std::filesystem::path> print_cell(const PrintRequest& request, const CellBox& box,
                                         const std::filesystem::path& folder);

struct BuildSize {
    static constexpr double kPitch_mm = 0.5;   ///< it is known up to one at each end
    std::array<double, 3> mm{};                ///< of what is built
    std::array<double, 3> printer_pitch_mm{};  ///< 0: not known
};
Result<BuildSize> build_size(const PrintRequest& request, const std::filesystem::path& folder);

/// A world, and an object of it whose fablet fills a cell.
struct CellWorld {
    std::filesystem::path world;
    std::string object;
    bool own_printer = false;                  ///< the world says what it is printed on
    std::vector<std::filesystem::path> allow;  ///< folders that it may read besides its own
};
/// `input`: a fablet (.fl), whose materials are named as its uniforms are, or a world, of which `object` or
/// the first object is taken.
Result<CellWorld> cell_world(const std::filesystem::path& input, const std::string& object,
                             const std::filesystem::path& programs,
                             const std::filesystem::path& scratch);

}  // namespace openfab::mechanics

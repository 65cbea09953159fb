// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fixture of the end-to-end tests: the programs under test, one print binary of the postcard,
// prints read back as voxels.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "base/vec.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"

namespace openfab::testing {

inline std::filesystem::path gallery_postcard() {
    return source_dir() / "gallery" / "magic_postcard";
}

/// A whole print in memory, one code a voxel, x fastest.
struct Voxels {
    Vec3i size;
    Vec3d pitch_mm, origin_mm;
    int32_t slice_begin = 0, slice_end = 0;
    std::vector<std::string> materials;
    std::vector<uint8_t> codes;  ///< slices slice_begin … slice_end

    uint8_t at(int32_t x, int32_t y, int32_t z) const {
        return codes[(static_cast<size_t>(z - slice_begin) * static_cast<size_t>(size.y) +
                      static_cast<size_t>(y)) *
                         static_cast<size_t>(size.x) +
                     static_cast<size_t>(x)];
    }
};

/// Reads a complete `.ofr`; fails the test where it is not complete.
Voxels read_ofr(const std::filesystem::path& file);

/// Reads a number of a statistics file, like `queries/asked`; fails the test where it is missing.
double statistic(const std::filesystem::path& file, const std::string& name);

/// Returns the budget in a memory error, MB; fails the test if there is none.
int64_t least_memory_mb(const Outcome& refused);

/// A print program made by the build (tests/scenes/CMakeLists.txt).
inline std::filesystem::path print_program(const std::string& name) {
    return build_dir() / "print_programs" / name;
}

/// The postcard's print program, and a scratch folder that tests share.
class PostcardScene : public ::testing::Test {
  protected:
    static void SetUpTestSuite();
    static void TearDownTestSuite();

    /// Runs the print binary on the gallery's world with `arguments`.
    static Outcome print(const std::vector<std::string>& arguments);
    static std::filesystem::path binary();
    static const ScratchFolder& scratch() { return *scratch_; }
    static RunOptions environment();

  private:
    static ScratchFolder* scratch_;
};

}  // namespace openfab::testing

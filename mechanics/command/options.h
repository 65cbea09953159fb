// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the commands of `openfab mechanics` have in common.

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "mechanics/model/materials.h"
#include "mechanics/model/print_world.h"
#include "mechanics/model/voxels.h"
#include "mechanics/solver/conjugate_gradients.h"

namespace openfab::mechanics {

struct CommonOptions {
    std::string input;
    std::string materials;             ///< a file; empty: beside the input
    std::string law;                   ///< empty: the file's
    Conditions conditions;             ///< at which moduli are
    std::array<double, 3> voxel_mm{};  ///< 0: chosen
    int supersample = 0;  ///< parts of an element along each axis; 0: the printer's voxels
    bool codes = false;
    std::string dither;
    std::vector<std::string> settings, allow;
    double tolerance = 1e-6;
    int most_iterations = 400;
    int threads = 1;
    int64_t memory_bytes = 0;
    bool quiet = false;
    std::filesystem::path programs;  ///< folder of `openfab`
};

/// Reads the file of materials that was given, or that lies beside the input.
Result<Properties> properties_of(const CommonOptions& common);

/// One length, or three, as 5mm, 5mmx5mmx3mm or 42x85x27um.
Result<std::array<double, 3>> parse_sizes(const std::string& text);

/// Of `--supersample` where it is not given: 0, the printer's own voxels, if these are known and not larger
/// than elements, else 2.
int parts_of_elements(const CommonOptions& common, const std::array<double, 3>& pitch_mm,
                      const std::array<double, 3>& printer_pitch_mm);

/// Notes that dithered elements of a pitch that was asked for are not the printer's voxels.
void note_other_codes(const CommonOptions& common, const std::array<double, 3>& printer_pitch_mm);

/// Refuses what is no world, nor, where those are taken, a fablet: a print says what it is.
Result<void> check_is_world(const std::string& input, bool fablets);

/// `1mm`, or `1 x 1 x 0.5 mm`.
std::string sides_text(const std::array<double, 3>& mm);

/// Says now and then how far a solution is; knows how long is left.
class SolveProgress {
  public:
    SolveProgress(bool quiet, int cases, double tolerance);
    /// Returns false where a person has pressed Ctrl-C.
    bool update(int which, int iteration, double residual);

  private:
    bool quiet_;
    int cases_;
    double tolerance_, start_, said_;
};

/// Tolerance and limit of a solution of one case, and who is told how far it is.
SolveOptions solve_options(const CommonOptions& common, SolveProgress* progress);

/// Refuses a solution that was given up or is none.
Result<void> check_solved(const SolveReport& report, const CommonOptions& common);

/// The errors of those.
Error interrupted_error();
Error not_converged_error(double residual, double tolerance, int iterations);

/// Refuses a grid whose solution does not fit.
Result<void> check_memory(int64_t needed, int64_t allowed, const std::array<int32_t, 3>& elements);

}  // namespace openfab::mechanics

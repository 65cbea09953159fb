// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the commands of `openfab mechanics` have in common.

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "mechanics/model/voxels.h"
#include "mechanics/solver/conjugate_gradients.h"

namespace openfab::mechanics {

struct CommonOptions {
    std::string input;
    std::string materials;  ///< a file; empty: beside the input
    std::string law;        ///< empty: the file's
    double voxel_mm = 0;    ///< 0: chosen
    int supersample = 2;
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

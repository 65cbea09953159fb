// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a fablet made of a voxel before the dither: `openfab print --probe` evaluates it again, at the
// print's own pitch.

#include <filesystem>
#include <mutex>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::viewer {

/// The world of a print, or its mesh and that one's fablet, and what it was printed with.
struct ProbedWorld {
    std::string file, fablet;
    std::vector<std::string> allow, settings;  ///< as of `openfab print`
};

/// Thread-safe: one voxel at a time.
class Prober {
  public:
    /// `programs`: the folder of openfab; `scratch`: one that exists, for its output.
    Prober(std::filesystem::path programs, std::filesystem::path scratch)
        : programs_(std::move(programs)), scratch_(std::move(scratch)) {}

    /// Returns the fraction of each of the print's materials. Fails where the world cannot be
    /// printed, and where the print was made of something else.
    Result<std::vector<double>> fractions(const ProbedWorld& world, const pipeline::PrintInfo& info,
                                          const Vec3d& point_mm);

  private:
    std::filesystem::path programs_, scratch_;
    std::mutex mutex_;
};

}  // namespace openfab::viewer

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Numbers of a world's mechanics at any values of its uniforms: `openfab mechanics` is started for each, a program of its
// own, which has the solver and prints the elements. That takes as long as it does by hand; what it compiles is kept.

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "base/json.h"
#include "base/own_folder.h"
#include "base/result.h"
#include "base/vec.h"
#include "program/options.h"
#include "tools/fit/goals.h"

namespace openfab::fit {

class MechanicsValues {
  public:
    /// Of which elements.
    enum class Elements {
        kAsked,    ///< mixtures, of the size that the goal names or the mechanics choose
        kHalf,     ///< likewise, at half of that
        kPrinted,  ///< the printer's voxels, dithered
    };

    static Result<std::unique_ptr<MechanicsValues>> create(const program::Options& print,
                                                           const Vec3d& printer_pitch_mm);

    /// Returns the number of a goal. One solution has all that its words tell. What went wrong was said, or is the
    /// message; with kPrinted nothing is said.
    Result<double> value(const Goal& goal, const std::vector<std::string>& settings,
                         Elements elements);

  private:
    MechanicsValues(const program::Options& print, const Vec3d& pitch,
                    std::unique_ptr<TemporaryFolder> folder, std::filesystem::path programs)
        : print_(print),
          printer_pitch_mm_(pitch),
          folder_(std::move(folder)),
          programs_(std::move(programs)) {}
    Result<const JsonValue*> solve(const Goal& goal, const std::vector<std::string>& settings,
                                   Elements elements);

    const program::Options print_;
    const Vec3d printer_pitch_mm_;
    const std::unique_ptr<TemporaryFolder> folder_;
    const std::filesystem::path programs_;
    std::map<std::vector<std::string>, JsonValue> solved_;  ///< by words
};

}  // namespace openfab::fit

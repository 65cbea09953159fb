// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/vec.h"

namespace openfab::tools {

struct CheckArguments {
    std::string file, printer, process, picture, report, memory;
    std::string wall, gap, hole, island, trapped;  ///< limits that replace those of the profile
    std::vector<std::string> apart, allow, settings;
    int32_t parts = 0;  ///< of each voxel along an axis; 0: as many as memory allows, at most 3
    int32_t draft = 0;  ///< 0: 1, or as memory allows
    int32_t threads = 0;
    /// Of a check before a print: its other options, and its pitch on a printer of that pitch. What is found
    /// then goes to stderr, since the print's result may go to stdout.
    std::vector<std::string> print_words;
    std::function<Vec3d(const Vec3d&)> pitch_mm;

    bool before_print() const { return pitch_mm != nullptr; }
};

/// `check`: finds what a machine will not print well: thin walls, narrow gaps and holes, loose islands,
/// trapped material, materials that touch. Fails where there is any.
Result<void> run_check(const CheckArguments& arguments);

}  // namespace openfab::tools

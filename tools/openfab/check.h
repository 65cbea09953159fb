// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"

namespace openfab::tools {

struct CheckArguments {
    std::string file, printer, process, picture, report, memory;
    std::string wall, gap, hole, island, trapped;  ///< limits that replace those of the profile
    std::vector<std::string> apart, allow;
    int32_t parts = 0;  ///< of each voxel along an axis; 0: as many as memory allows, at most 3
    int32_t draft = 1;
    int32_t threads = 0;
};

/// `check`: finds what a machine will not print well: thin walls, narrow gaps and holes, loose islands,
/// trapped material, materials that touch. Fails where there is any.
Result<void> run_check(const CheckArguments& arguments);

}  // namespace openfab::tools

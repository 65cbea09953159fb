// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// `openfab export WORLD.fab.json -o FILE.3mf`: a world as shapes, meshes and functions of 3MF (implicit
// and volumetric extensions), or as stacks of images where its fablets say more than such functions can.

#include <string>
#include <vector>

#include "base/result.h"

namespace openfab::tools {

struct FunctionsArguments {
    std::string world, output;
    std::string
        voxel;  ///< of stacks of images, as for `openfab print`; empty: 256 along the longest side
    bool composite = false;               ///< mixtures as the volumetric extension has them
    bool programs = false;                ///< that the world names may run
    std::vector<std::string> settings{};  ///< as of `openfab print`
    int64_t memory_bytes = 0;
};

Result<void> export_functions(const FunctionsArguments& arguments);

}  // namespace openfab::tools

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// `openfab arrange`: puts all that a world builds, pieces among it, on as many trays as it takes.

#include <string>
#include <vector>

#include "base/result.h"

namespace openfab::tools {

struct ArrangeArguments {
    std::vector<std::string> worlds;  ///< alike in all but what they build
    std::string fit, output, gap = "5mm", turn = "upright", memory;
    std::vector<std::string> copies;  ///< `N` of everything, `NAME=N` of an object
    std::vector<std::string> allow, settings;
};

Result<void> run_arrange(const ArrangeArguments& arguments);

}  // namespace openfab::tools

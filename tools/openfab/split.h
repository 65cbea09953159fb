// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// `openfab split`: finds the pieces of objects that are larger than a machine, and puts them on trays.

#include <string>
#include <vector>

#include "base/result.h"

namespace openfab::tools {

struct SplitArguments {
    std::string world, fit, output, object, peg = "6mm", clearance = "0.1mm", skin = "1.5mm",
                                            number = "6mm", gap = "5mm", material, seam, look,
                                            stress, memory;
    std::vector<std::string> allow, settings;
};

Result<void> run_split(const SplitArguments& arguments);

}  // namespace openfab::tools

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The commands of `openfab mechanics`.

#include <string>
#include <vector>

#include "mechanics/command/options.h"

namespace openfab::mechanics {

struct CellOptions {
    CommonOptions common;
    std::string object;  ///< of a world; empty: the first
    std::string cell;    ///< `5mm`, or `5mmx5mmx3mm`
    std::string sweep;   ///< `thickness=0.4:1.6:5`
    std::string output, polar;
    bool conductivity = false;
};
Result<void> run_cell(const CellOptions& options);

}  // namespace openfab::mechanics

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/result.h"

namespace openfab::tools {

struct CompensateArguments {
    std::string nominal, measured, output, cell, smoothness, memory;
};

/// `compensate`: makes the displacement field of a machine from what was meant and what was measured.
Result<void> run_compensate(const CompensateArguments& arguments);

}  // namespace openfab::tools

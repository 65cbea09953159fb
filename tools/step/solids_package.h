// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Writes solids as a 3MF file: an object each, with its name and a material of its colour.

#include <string>

#include "base/result.h"
#include "tools/step/step_solids.h"

namespace openfab::tools {

Result<void> write_solids(const StepFile& solids, const std::string& output);

}  // namespace openfab::tools

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// `--memory` of the commands that read prints.

#include <cstdint>
#include <string>

#include "base/result.h"

namespace openfab::tools {

/// Parses the option; empty: the default of prints.
Result<int64_t> memory_of(const std::string& text);

}  // namespace openfab::tools

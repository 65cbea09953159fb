// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// `--memory` of the commands that read prints.

#include <cstdint>
#include <string>

#include "base/result.h"

namespace openfab::tool {

/// Empty: as much as a print takes unless told.
Result<int64_t> memory_of(const std::string& text);

}  // namespace openfab::tool

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The one message about files that take more memory than they may.

#include <cstdint>

#include "base/result.h"

namespace openfab::tools {

/// Fails where `needed_bytes` exceed the memory; the error names them.
Result<void> check_memory(int64_t needed_bytes, int64_t memory_bytes);

}  // namespace openfab::tools

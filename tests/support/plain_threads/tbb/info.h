// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// See plain.h.

namespace tbb::info {

/// More than some machines have, so that races get their chance.
inline int default_concurrency() {
    return 8;
}

}  // namespace tbb::info

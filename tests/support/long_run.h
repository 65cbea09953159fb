// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>

namespace openfab::testing {

/// Whether this is a night's run (`scripts/test --long`), which repeats what others do in part;
/// docs/testing.md has the table.
inline bool long_run() {
    return std::getenv("OPENFAB_LONG") != nullptr;
}

}  // namespace openfab::testing

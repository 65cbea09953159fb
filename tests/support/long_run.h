// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>

namespace openfab::testing {

/// Returns whether this is a long run (`scripts/test --long`), which does in full what others do in
/// part; see the table in docs/testing.md.
inline bool long_run() {
    return std::getenv("OPENFAB_LONG") != nullptr;
}

}  // namespace openfab::testing

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/places/places.h"

namespace openfab::testing {

std::filesystem::path source_dir() {
    return OPENFAB_SOURCE_DIR;
}
std::filesystem::path build_dir() {
    return OPENFAB_BUILD_DIR;
}

}  // namespace openfab::testing

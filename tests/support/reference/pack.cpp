// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/reference/pack.h"

namespace openfab::reference {

std::vector<uint8_t> pack_row(std::span<const uint8_t> codes) {
    std::vector<uint8_t> row((codes.size() + 1) / 2, 0);
    for (size_t i = 0; i < codes.size(); ++i) {
        row[i / 2] = static_cast<uint8_t>(row[i / 2] | codes[i] << (i % 2 * 4));
    }
    return row;
}

}  // namespace openfab::reference

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/reference/column_scan.h"

namespace openfab::reference {

std::vector<uint8_t> add_support(std::vector<uint8_t> codes, const std::vector<uint8_t>& asks,
                                 const Vec3i& size, uint8_t support_code) {
    const size_t slice = static_cast<size_t>(size.x) * static_cast<size_t>(size.y);
    for (size_t column = 0; column < slice; ++column) {
        bool below = false;
        for (size_t z = static_cast<size_t>(size.z); z-- > 0;) {
            uint8_t& code = codes[z * slice + column];
            if (asks[z * slice + column] != 0) {
                below = true;
            } else if (below && code == 0) {
                code = support_code;
            }
        }
    }
    return codes;
}

}  // namespace openfab::reference

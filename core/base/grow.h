// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace openfab {

/// Grows a reused buffer to at least `count` elements; it never shrinks.
void grow(auto* values, size_t count) {
    if (values->size() < count) values->resize(count);
}

}  // namespace openfab

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Tops of a few rows of columns, while the depth map of support is computed.

#include <algorithm>
#include <cstdint>
#include <vector>

namespace openfab::solid {

/// Columns [x0, x1) x [y0, y1) of the grid.
struct Columns {
    int32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;

    bool empty() const { return x0 >= x1 || y0 >= y1; }
    int32_t width() const { return x1 - x0; }
    size_t count() const { return static_cast<size_t>(width()) * static_cast<size_t>(y1 - y0); }
};

/// Rows of tops over the whole width of the grid.
struct TopRows {
    int32_t width = 0, y0 = 0;
    std::vector<int32_t> top;

    /// Raises the top of a column to at least `to`.
    void raise(int32_t x, int32_t y, int32_t to) {
        int32_t& t =
            top[static_cast<size_t>(y - y0) * static_cast<size_t>(width) + static_cast<size_t>(x)];
        t = std::max(t, to);
    }
};

}  // namespace openfab::solid

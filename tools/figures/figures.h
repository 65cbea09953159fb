// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Defines the gallery's figures; shape.h and polygonise.h make them.

#include <string>
#include <vector>

#include "tools/figures/shape.h"

namespace openfab::figures {

struct Figure {
    std::string name;
    Shape shape;
    Box3d box;           ///< contains the shape with a margin
    double cell_mm = 1;  ///< of the polygoniser
};

/// Returns rhino, bunny, bear, beetle, fish, amber, table, ring, in this order.
std::vector<Figure> all_figures();

}  // namespace openfab::figures

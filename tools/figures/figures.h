// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The gallery's figures: who they are, not how they are made.

#include <string>
#include <vector>

#include "tools/figures/shape.h"

namespace openfab::figures {

struct Figure {
    std::string name;
    Shape shape;
    Box3d box;           ///< holds the shape with room to spare
    double cell_mm = 1;  ///< of the polygoniser
};

/// rhino, bunny, bear, beetle, fish, amber, table, ring, in this order.
std::vector<Figure> all_figures();

}  // namespace openfab::figures

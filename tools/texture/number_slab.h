// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A part of an array whose numbers are read one after the other: what lies between is passed over.

#include <memory>

#include "texture/xdmf_grid.h"
#include "tools/texture/array_numbers.h"

namespace openfab::tools {

/// Returns the numbers of the slab, whose sides are within those of the array; the last index varies
/// fastest in both. `whole` reads the array.
std::unique_ptr<ArrayNumbers> take_slab(std::unique_ptr<ArrayNumbers> whole,
                                        const texture::XdmfSlab& slab);

}  // namespace openfab::tools

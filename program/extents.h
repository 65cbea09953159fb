// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// `--extents FILE`: where a world's placements are, and how far they reach, for tools that know no
// fablets.

#include "abi/fablet_table.h"
#include "base/result.h"
#include "program/options.h"

namespace openfab::program {

/// Writes an array with an entry for each placement of the build: null where its mesh is what is placed;
/// else `{"at_mm": [x, y, z], "extent_mm": [[...], [...]], "own_mm": [[...], [...]]}`, its translation and
/// the boxes of world::Placement.
Result<void> write_extents(const Options& options, const openfab_fablet_list& fablets);

}  // namespace openfab::program

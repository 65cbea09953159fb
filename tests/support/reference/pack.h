// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace openfab::reference {

/// Packs a row of material codes at 4 bits a voxel: voxel 2n in the low half of byte n, 2n + 1 in
/// its high half.
std::vector<uint8_t> pack_row(std::span<const uint8_t> codes);

}  // namespace openfab::reference

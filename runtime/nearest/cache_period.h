// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace openfab::nearest {

class PatchCache;

/// Begins a period of use, as that of a slab, and drops the trees that were not used in the last
/// `periods`: they lie behind the print. From any thread.
void begin_period(PatchCache* cache, int64_t periods);

}  // namespace openfab::nearest

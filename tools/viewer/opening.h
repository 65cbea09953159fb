// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which slice a print opens on. The middle one is often the least to look at: a postcard's is a
// blank sheet. Of some that are spread over the print it is the one whose picture varies most.

#include <cstdint>

#include "tools/viewer/slice_store.h"

namespace openfab::viewer {

/// Returns a slice that is there, the middle one where none shows clearly more; reads up to sixteen
/// slices. Support material counts as void. Of a print without slices, its first.
int32_t opening_slice(SliceStore* store);

}  // namespace openfab::viewer

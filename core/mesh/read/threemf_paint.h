// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Triangles that were painted in a slicer.

#include <cstdint>
#include <string>

#include "base/result.h"
#include "mesh/read/threemf_model.h"

namespace openfab::mesh {

/// Divides the painted triangles of an object as their paint says, and their neighbours at the same
/// points, so that a closed mesh stays one; sets `filaments`, and `sources` if any was divided.
/// Errors begin with `place`. Decreases `*memory_bytes`.
Result<void> apply_threemf_paint(ThreemfObject* object, const std::string& place,
                                 int64_t* memory_bytes, ThreemfTold* told);

}  // namespace openfab::mesh

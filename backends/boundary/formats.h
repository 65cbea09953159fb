// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backends/common/format.h"

namespace openfab::boundary {

extern const backends::Format kThreemfFormat;   ///< an object of a 3MF file for each material
extern const backends::Format kApartFormat;     ///< same, with touching voxels moved apart
extern const backends::Format kFilamentFormat;  ///< a 3MF file with painted triangles
extern const backends::Format kMixedFormat;     ///< same, without paint, and mixtures of filaments
extern const backends::Format kStlFormat;       ///< an STL file for each material

}  // namespace openfab::boundary

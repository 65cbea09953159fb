// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "mesh/model/mesh_source.h"

namespace openfab::mesh {

/// Reads AMF (ISO/ASTM 52915), plain or zipped: each volume of each object is a body, as often as its
/// constellations have it, turned about x, then y, then z, and moved; objects that no constellation has
/// are placed once. Materials are looks, composites of fixed shares mixtures of them; colours, sRGB, of
/// triangles go before those of vertices, volumes, objects and materials. Of PrusaSlicer extruders,
/// negative volumes and modifiers are read. Pictures, curved triangles and formulas of colours and shares
/// are told and left out. Errors name the line.
Result<MeshSource> parse_amf(std::string_view bytes, const std::string& file,
                             int64_t memory_bytes = kDefaultReadingBytes);

}  // namespace openfab::mesh

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The pieces of a binary STL file.

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "base/vec.h"

namespace openfab::boundary {

constexpr size_t kStlTitleBytes = 80;
constexpr size_t kStlHeaderBytes = kStlTitleBytes + 4;  ///< and the number of triangles
constexpr size_t kStlFacetBytes = 50;                   ///< normal, three corners, two bytes

/// Returns the header; `title` must not begin with "solid", as text files do, and is truncated.
std::array<uint8_t, kStlHeaderBytes> stl_header(const std::string& title, uint32_t triangles);

/// Puts a digest of the facets' bytes (base/hash.h) at the end of the title, as text.
void put_stl_digest(uint64_t digest, std::array<uint8_t, kStlHeaderBytes>* header);
/// Returns it; none in the files of others.
std::optional<uint64_t> stl_digest(const std::array<uint8_t, kStlHeaderBytes>& header);

/// Writes a triangle, counter-clockwise seen from outside, to kStlFacetBytes at `out`.
void put_stl_facet(const std::array<Vec3f, 3>& corners, uint8_t* out);

}  // namespace openfab::boundary

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

struct StlMarks {
    uint64_t digest = 0;  ///< of the facets' bytes (base/hash.h)
    uint64_t print = 0;   ///< the same in all files of a print
};

/// Puts them at the end of the title, as text.
void put_stl_marks(const StlMarks& marks, std::array<uint8_t, kStlHeaderBytes>* header);
/// Returns them; none in the files of others.
std::optional<StlMarks> stl_marks(const std::array<uint8_t, kStlHeaderBytes>& header);

/// How much of a title is left in front of them.
constexpr size_t kStlOwnTitleBytes = kStlTitleBytes - 2 * 16 - 6 - 7;  // of their words

/// Letters, digits, `-` and `.` of a material's name, all others as `_`: safe in every file system and on every command
/// line.
std::string safe_file_name(const std::string& name);

/// Writes a triangle, counter-clockwise seen from outside, to kStlFacetBytes at `out`.
void put_stl_facet(const std::array<Vec3f, 3>& corners, uint8_t* out);

}  // namespace openfab::boundary

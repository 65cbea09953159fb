// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a part of an OBJ text says by itself: elements, and faces with the elements that they refer
// to. Polygons and groups depend on what was read before, and are left to parse_obj.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "mesh/read/obj_lines.h"

namespace openfab::mesh {

constexpr size_t kMaxObjElements = 200'000'000;

/// Indices of one corner of a face, from 0; -1 where it has none.
struct ObjCorner {
    int32_t v = -1, vt = -1, vn = -1;
};

/// A statement between triangles: a polygon of four corners or more, or one that sets groups or the
/// material.
struct ObjCut {
    size_t triangles = 0;  ///< of the piece before it
    size_t corners = 0;    ///< of a polygon; 0: groups or a material
    size_t start = 0;      ///< of its line in the text
    int32_t line = 0;
};

struct ObjPiece {
    double unit_mm = 0;  ///< of the first comment that states one; else 0
    std::vector<Vec3d> positions;
    std::vector<float> uv, normals, colors;
    std::vector<std::array<int32_t, 3>> triangles, uv_corners, normal_corners;
    std::vector<int32_t> lines;      ///< by triangle
    std::vector<ObjCut> cuts;        ///< in order
    std::vector<ObjCorner> corners;  ///< of the cuts' polygons in turn
    std::optional<Error> error;      ///< of the statement behind all these
};

/// Reads a part of a text up to its end or its first error. `file` stands for the file in messages.
ObjPiece read_obj_piece(std::string_view text, const ObjPart& part, const std::string& file);

}  // namespace openfab::mesh

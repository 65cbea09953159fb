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

/// A statement between triangles: a polygon of four corners or more, or one that sets groups, the
/// object or the material, or names a library of materials.
struct ObjCut {
    size_t triangles = 0;  ///< of the piece before it
    size_t corners = 0;    ///< of a polygon; 0: names
    size_t start = 0;      ///< of its line in the text
    int32_t line = 0;
};

/// What is left out of an OBJ text.
enum class ObjLeftOut {
    kNormals,     ///< corners that name one which is not there
    kUv,          ///< the same of texture coordinates
    kPoints,      ///< `p`
    kLines,       ///< `l`
    kSurfaces,    ///< `curv`, `curv2`, `surf`
    kParameters,  ///< `vp`
    kWeights,     ///< of vertices
    kMaps,        ///< `usemap`, `maplib`
    kCalls,       ///< `call`, `csh`
    kPolypaint,   ///< `#MRGB`
    kCount
};

/// How often something was found, and the line of the first.
struct ObjFound {
    int64_t count = 0;
    int32_t line = 0;
};
using ObjFindings = std::array<ObjFound, static_cast<size_t>(ObjLeftOut::kCount)>;

struct ObjPiece {
    double unit_mm = 0;  ///< of the first comment that states one; else 0
    std::vector<Vec3d> positions;
    std::vector<float> uv, normals;
    /// Three a vertex up to the last one that has any, as written; those without are not numbers.
    std::vector<float> colors;
    std::vector<std::array<int32_t, 3>> triangles, uv_corners, normal_corners;
    std::vector<int32_t> lines;      ///< by triangle
    std::vector<ObjCut> cuts;        ///< in order
    std::vector<ObjCorner> corners;  ///< of the cuts' polygons in turn
    ObjFindings left_out;
    std::optional<Error> error;  ///< of the statement behind all these
};

/// Reads a part of a text up to its end or its first error. `file` stands for the file in messages.
ObjPiece read_obj_piece(std::string_view text, const ObjPart& part, const std::string& file);

}  // namespace openfab::mesh

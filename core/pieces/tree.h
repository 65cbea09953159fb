// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// How a part is cut into pieces: a tree of planes (a BSP), with connectors and numbers on the cuts, in
// mm of mesh space. It becomes one region for each piece.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "pieces/region.h"

namespace openfab::pieces {

/// The half-length of a dovetail that runs through the part.
constexpr double kThrough_mm = 1e6;

struct Connector {
    enum class Kind : uint8_t { kPeg, kDowel, kDovetail, kMagnet };
    Kind kind = Kind::kPeg;
    Vec3d at_mm;              ///< moved onto the cut
    bool from_front = false;  ///< a peg or dovetail is of the piece in front
    double diameter_mm = 0;   ///< or the width of a dovetail at the cut
    double length_mm = 0;  ///< into the other piece; of a dowel all of it; of a magnet one's height
    double clearance_mm = 0;
    double skin_mm = 0;
    std::string material;             ///< empty: what the part is made of there
    Vec3d along{0, 0, 0};             ///< of a dovetail
    double run_mm = 2 * kThrough_mm;  ///< of a dovetail, its length along that
    double angle_deg = 15;            ///< of a dovetail's sides
    SourceLocation location;
};

/// The name of a piece, engraved in its face.
struct Number {
    Vec3d at_mm;  ///< its centre, moved onto the cut
    double height_mm = 0, depth_mm = 0;
    std::optional<Vec3d> up;
    std::optional<bool> front;  ///< only in the piece in front, or behind; else in both
    SourceLocation location;
};

struct Cut {
    Vec3d normal{0, 0, 1};  ///< of length 1
    double offset_mm = 0;
    int32_t front = -1, back = -1;  ///< a cut, or ~ of a piece's number
    std::vector<Connector> connectors;
    std::vector<Number> numbers;
    SourceLocation location;
};

struct Tree {
    std::vector<Cut> cuts;            ///< the first is the root
    std::vector<std::string> pieces;  ///< names
};

/// Returns the name of the piece that a point is in.
const std::string& piece_at(const Tree& tree, const Vec3d& p);
/// Returns a region for each piece, then one for each dowel, `dowel 1`, … in the order of the tree.
std::vector<Region> regions(const Tree& tree);
/// Returns a vector of length 1 in the plane of a normal, as near as possible to upright.
Vec3d upright(const Vec3d& normal);

/// Returns the strokes of a text of digits, capital letters, `.` and `-`, centred, of that height;
/// other characters become `-`. `*thickness` is that of a stroke.
std::vector<std::array<double, 4>> strokes_of(const std::string& text, double height,
                                              double* thickness);

}  // namespace openfab::pieces

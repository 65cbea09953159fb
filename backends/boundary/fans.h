// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The topology of the surface of one material at a lattice point, a corner of up to 8 voxels.
//
// Voxels of a material that touch only along an edge or in a corner are never joined by it: along
// such an edge the surface is two sheets, each around its own voxel. The unit faces of a material
// around a point then form closed fans, from face to face over the edges they share. A mesh that
// has one vertex for each fan is 2-manifold at its vertices, whatever the voxels are.

#include <array>
#include <bit>
#include <cstdint>

namespace openfab::boundary {

/// The fans at a point. Bits of an octant's number: 0 is set on the side of +x, 1 of +y, 2 of +z. A
/// mask has a bit for each octant that is of the material.
struct Fans {
    int32_t count = 0;  ///< at most 4
    /// By octant of the material and by axis: the fan of the face between this octant and its
    /// neighbour across the axis; -1 where there is none.
    std::array<std::array<int8_t, 3>, 8> of{};
    /// By fan, where there are several: the direction from the point away from the other fans, -1
    /// or 1 along each axis that the fan has faces across, else 0. It points into the voxels of the
    /// fan; or out of them, into a single voxel of others, where two such voxels meet at their
    /// corners inside the material. All fans of a point differ, and none of several has faces both
    /// ways along an axis.
    std::array<std::array<int8_t, 3>, 4> apart{};
};

namespace fans_detail {

struct Face {
    int32_t octant = 0, axis = 0;
};

/// Returns the next face of the surface across the edge along axis `edge`.
constexpr Face next_face(uint32_t mask, Face face, int32_t edge) {
    const int32_t third = 3 - face.axis - edge;
    const int32_t beside = face.octant ^ (1 << third);
    if ((mask >> beside & 1) == 0) return {face.octant, third};
    const int32_t across = beside ^ (1 << face.axis);
    if ((mask >> across & 1) == 0) return {beside, face.axis};
    return {across, third};
}

constexpr Fans make_fans(uint32_t mask) {
    Fans fans;
    for (auto& octant : fans.of)
        octant.fill(-1);
    for (int32_t octant = 0; octant < 8; ++octant) {
        for (int32_t axis = 0; axis < 3; ++axis) {
            const bool face =
                (mask >> octant & 1) != 0 && (mask >> (octant ^ (1 << axis)) & 1) == 0;
            if (!face || fans.of[octant][axis] >= 0) continue;
            Face at{octant, axis};
            int32_t edge = (axis + 1) % 3;
            while (fans.of[at.octant][at.axis] < 0) {
                fans.of[at.octant][at.axis] = static_cast<int8_t>(fans.count);
                const Face next = next_face(mask, at, edge);
                edge = 3 - next.axis - edge;
                at = next;
            }
            ++fans.count;
        }
    }
    if (fans.count == 1) return fans;
    // Only a material that has all octants but two opposite ones lies between its fans.
    const bool between = std::popcount(mask) == 6;
    for (int32_t octant = 0; octant < 8; ++octant) {
        for (int32_t axis = 0; axis < 3; ++axis) {
            const int8_t fan = fans.of[octant][axis];
            if (fan < 0) continue;
            const bool high = (octant >> axis & 1) != 0;
            fans.apart[fan][axis] = high != between ? 1 : -1;
        }
    }
    return fans;
}

constexpr std::array<Fans, 256> make_all_fans() {
    std::array<Fans, 256> all{};
    for (uint32_t mask = 0; mask < 256; ++mask)
        all[mask] = make_fans(mask);
    return all;
}

}  // namespace fans_detail

inline constexpr std::array<Fans, 256> kFans = fans_detail::make_all_fans();

/// Returns the mask of octants that have `code`.
inline uint32_t mask_of(const std::array<uint8_t, 8>& codes, uint8_t code) {
    uint32_t mask = 0;
    for (uint32_t octant = 0; octant < 8; ++octant)
        mask |= static_cast<uint32_t>(codes[octant] == code) << octant;
    return mask;
}

}  // namespace openfab::boundary

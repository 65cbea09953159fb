// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The part as elements, and the faces of its surface. An element of half material or more is solid; the
// surface is between solid elements and others. One of less is a rim where it touches a solid one: it is
// as stiff as its share, so that walls keep their volume, but no load acts on it and no stress is read.

#include <compare>
#include <span>
#include <vector>

#include "mechanics/model/voxels.h"
#include "mechanics/part/load_case.h"

namespace openfab::mechanics {

enum ElementKind : uint8_t { kNothing, kRim, kSolid };

/// Of each element; shares that are neither are set to nothing in `voxels`.
struct PartElements {
    std::vector<uint8_t> kind;
    int64_t solid = 0;
    double volume = 0;  ///< of all material, in elements
};
PartElements classify(const Grid& grid, Voxels* voxels);

/// A face of a solid element that looks along -x +x -y +y -z +z (0 ... 5).
struct Face {
    int64_t element;
    uint8_t direction;
    auto operator<=>(const Face&) const = default;
};
std::vector<Face> surface_of(const Grid& grid, std::span<const uint8_t> kind);

std::array<int32_t, 3> place_of(const Grid& grid, int64_t element);
/// The four nodes of a face, numbered [z][y][x].
std::array<int64_t, 4> nodes_of(const Grid& grid, const Face& face);

/// Returns whether chosen faces, which all look the same way, are the tip of what is round or pointed: the next two steps of
/// its staircase have about as many as they, or more. How large such a tip is depends on the pitch.
bool is_tip(const Grid& grid, std::span<const Face> surface, std::span<const Face> chosen);

/// A face with its area that has material, mm2.
struct LoadedFace {
    Face face;
    double area = 0;
};
/// Returns what chosen faces hold of material: where a wall ends within an element, its end has that share
/// of the face, and what is less than half an element thick beside a face, its rim, has a face, too. So a
/// force on the end of a wall acts in its middle.
std::vector<LoadedFace> loaded_faces(const Grid& grid, const Voxels& voxels,
                                     std::span<const uint8_t> kind, std::span<const Face> chosen);

/// Where an object of the world is: voxels of a print of it alone, of the same pitch.
struct ObjectVoxels {
    std::string name;
    std::array<int32_t, 3> size{};
    Vec3 origin_mm{};
    std::vector<uint8_t> inside;

    bool has(const Vec3& p_mm, const Vec3& pitch_mm) const;
};

/// Finds faces that a case chooses.
class FaceChooser {
  public:
    FaceChooser(const Grid& grid, const Vec3& origin_mm, std::span<const Face> surface,
                std::span<const ObjectVoxels> objects);

    /// An error where there are none.
    Result<std::vector<Face>> choose(const FaceChoice& choice) const;
    Vec3 centre_mm(const Face& face) const;

  private:
    bool is_chosen(const FaceChoice& choice, const ObjectVoxels* object, const Face& face) const;

    const Grid& grid_;
    Vec3 origin_;
    std::span<const Face> surface_;
    std::span<const ObjectVoxels> objects_;
    std::array<std::array<int32_t, 2>, 3> range_;  ///< of elements with faces, along each axis
};

}  // namespace openfab::mechanics

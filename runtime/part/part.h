// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A part: one placed object with its fablet, uniforms, textures and materials resolved; the input
// of the pipeline.
//
// Spaces (rule 13): mesh space -S-> part space -R,t-> build space -> voxel space.
// A placement's matrix M is split as M = R S, S = sqrt(M^T M). Part-local space is part space
// relative to `center_part_mm`.

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "abi/fablet_table.h"
#include "base/result.h"
#include "base/vec.h"
#include "mesh/model/beams.h"
#include "pieces/region.h"
#include "runtime/part/geometry.h"
#include "texture/pyramid.h"

namespace openfab::part {

/// One surface input of the fablet (or mesh attribute that a @nearest reads), resolved on a mesh.
/// float: `components` values for each of 3 corners of each triangle; int/uint/bool: `components`
/// values a triangle, as 32-bit patterns.
struct PartAttribute {
    openfab_scalar_type scalar = OPENFAB_FLOAT;
    int32_t components = 1;
    std::vector<float> corner_values;   ///< [triangle][corner][component]
    std::vector<uint32_t> face_values;  ///< [triangle][component]
};

/// A mesh in part-local space, shared by placements with the same mesh, fablet and S.
struct PartMesh {
    std::vector<Vec3d> positions;  ///< part-local, mm; double, from which floats are rounded once
    std::vector<std::array<int32_t, 3>> triangles;
    Vec3d center_part_mm;                           ///< part space = part-local + this
    std::vector<PartAttribute> inputs;              ///< one per surface input of the fablet
    std::vector<PartAttribute> nearest_attributes;  ///< one per @nearest input; empty vectors where
                                                    ///< a surface output feeds it
    std::vector<Vec3f>
        corner_normals;  ///< [triangle*3 + corner], unit, smoothed where the mesh has normals
    std::vector<float> corner_uv;  ///< [triangle][corner][2]; empty without uv
};

/// Beams as a part's geometry, shared by placements with the same ones, fablet and scale. Part-local
/// points are `scale` times those of the beams, less the centre of Part::mesh.
struct PartBeams {
    std::shared_ptr<const mesh::Beams> beams;
    double scale = 1;
    Vec3d center_part_mm;
    std::vector<int32_t> attributes;  ///< of each @nearest input: of the beams; -1: its default
};

/// What of a part is printed, if it is cut into pieces.
struct Piece {
    pieces::Region region;              ///< part-local mm
    std::vector<uint8_t> filled_codes;  ///< print materials of region.filled
};

struct Stretched;

struct Part {
    std::string name;
    const openfab_fablet* fablet = nullptr;
    std::shared_ptr<const PartMesh> mesh;
    std::vector<uint32_t> uniform_values;  ///< bit patterns, see BoundUniforms::values
    std::vector<std::shared_ptr<const texture::Pyramid>> textures;  ///< by texture index
    std::vector<uint8_t>
        slot_material;  ///< slot -> print material: 0 void, 1.. the code of the material
    Geometry geometry;
    SourceLocation location;  ///< of a stage: where the world names it
    /// For each Object uniform of the fablet: the placements of that object, as ascending indices
    /// in the build list; at least one.
    std::vector<std::vector<int32_t>> objects;
    /// Part-local mm -> build mm: R and t. m is orthogonal; where the placement mirrors, det m =
    /// -1, and triangles that are counter-clockwise from outside in part space are clockwise in
    /// build and voxel space.
    Affine3d local_to_build;
    float max_displacement_mm = std::numeric_limits<float>::infinity();
    int32_t priority = 0;
    int32_t instance = 0;                ///< index in the world's build list
    bool support = true;                 ///< support is generated below it, in prints with support
    std::shared_ptr<const Piece> piece;  ///< null: all of it
    /// What the geometry is stretched from, if its kind knows no stretch; null: nothing is.
    std::shared_ptr<const Stretched> stretched;
};

/// A part in the mm of its source, part-local, of which the points are multiplied by a matrix, symmetric
/// and positive definite, to be those of the stretched part.
struct Stretched {
    Part source;
    std::array<double, 9> by;
};

inline bool is_mesh(const Part& part) {
    return std::holds_alternative<MeshGeometry>(part.geometry);
}
/// Returns the address that parts of one geometry share.
const void* shared_geometry(const Part& part);

/// The voxel grid of a print. Voxel (i, j, k) has its centre at origin + (i + 0.5, j + 0.5, k +
/// 0.5) * pitch.
struct Grid {
    Vec3d origin_mm;
    Vec3d pitch_mm;
    Vec3i size;  ///< voxels along x, y, z
};

/// Returns the map from part-local mm to continuous voxel coordinates of the grid (a centre is at i
/// + 0.5), in double.
Affine3d local_to_voxel(const Part& part, const Grid& grid);

/// Returns the map from part-local mm of one part to part-local mm of another, both as placed.
/// Rigid, so that distances are the same; in double, and mapped points are rounded to float once.
Affine3d local_to_local(const Part& from, const Part& to);

/// Returns the part-relative index origin, the voxel that holds the part's centre: frame values and
/// block indices of kernels count from it, so that float coordinates stay small anywhere on a tray.
Vec3i part_base_voxel(const Part& part, const Grid& grid);

/// Returns the frame values (openfab_frame_value) of a part in a grid, rounded once from double.
std::array<float, OPENFAB_FRAME_COUNT> make_frame(const Part& part, const Grid& grid);

}  // namespace openfab::part

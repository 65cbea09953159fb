// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Meshes made in memory for tests, and parts made of them without a world or a compiled print. Link
// openfab_test_meshes. Cards, spheres and cylinders are the primitives of
// mesh/model/primitives.h.

#include <memory>
#include <vector>

#include "abi/fablet_table.h"
#include "base/vec.h"
#include "mesh/model/mesh.h"
#include "mesh/model/primitives.h"
#include "runtime/part/part.h"

namespace openfab::testing {

/// A box with lowest corner at the origin: 12 triangles, attributes uv, n, face
/// as in mesh::make_box.
mesh::Mesh cube(double side_mm);
/// The postcard's base: width x height x thickness, centered in x and y on z = 0; face 0 front, 1
/// back.
mesh::Mesh card(double width_mm, double height_mm, double thickness_mm);
/// Longitude and latitude, around the origin; smooth normals, uv, face 0. around >= 3, stacks >= 2.
mesh::Mesh sphere(double radius_mm, int32_t around = 32, int32_t stacks = 16);
/// Around the z axis and the origin; smooth normals, uv with seams, face 0.
mesh::Mesh torus(double major_radius_mm, double minor_radius_mm, int32_t around = 32,
                 int32_t across = 16);
/// Returns the mesh without the attribute.
mesh::Mesh without(mesh::Mesh mesh, const std::string& attribute);
/// Returns the signed volume in mm^3:
/// positive for a closed mesh that is counter-clockwise from outside.
double signed_volume(const mesh::Mesh& mesh);

struct PartOptions {
    Affine3d transform;                    ///< mesh mm to build mm
    std::vector<uint32_t> uniform_values;  ///< empty: the fablet's defaults, 0 where there is none
    std::vector<std::shared_ptr<const texture::Pyramid>> textures;
    std::vector<uint8_t> slot_material;  ///< empty: slots in order get codes 1, 2, …, VOID's slot 0
    double max_displacement_mm = std::numeric_limits<double>::infinity();
    int32_t priority = 0;
    int32_t instance = 0;
    std::vector<std::vector<int32_t>> objects;  ///< as in part::Part::objects
};

/// Makes a part like part::bind. Prints the reason and aborts if the mesh lacks an attribute or
/// the transform is singular. `fablet` must outlive the part.
part::Part make_part(const openfab_fablet& fablet, const mesh::Mesh& mesh,
                     const PartOptions& options = {});

/// A fablet without kernels, stages or uniforms, for tests of geometry alone.
const openfab_fablet& empty_fablet();

/// Returns the smallest grid that holds
/// the part's base mesh (grown by `margin_mm`), cut to whole multiples
/// of the pitch from the build origin.
part::Grid grid_around(const part::Part& part, const Vec3d& pitch_mm, double margin_mm = 0);

}  // namespace openfab::testing

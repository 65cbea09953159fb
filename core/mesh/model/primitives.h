// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The primitives of a world, in mm, centered in x and y and standing on z = 0. All are closed and
// carry "uv" (2 floats), "n" (3 floats) and "face" (int).

#include "mesh/model/mesh.h"

namespace openfab::mesh {

/// Makes a box of 12 triangles.
/// face: 0 front (+z), 1 back (-z), 2 -y, 3 +x, 4 +y, 5 -x. Front and back have the
/// same uv at the same (x, y): u along +x, v along +y, so that a point of the back has the uv of
/// the front point opposite. Sides: v along +z, u to the right as seen from
/// outside.
Mesh make_box(const Vec3d& size_mm);

/// Makes a sphere of 128 x 64 facets of longitude and latitude:
/// smooth normals (the facets stay within 0.04 % of the
/// radius). u runs with longitude from -y over +x, v from the lowest point to the highest. face 0
/// everywhere.
Mesh make_sphere(double diameter_mm);

/// Makes a cylinder of 128 facets around.
/// face: 0 top, 1 bottom, 2 side. Caps have the uv of their bounding square in x
/// and y; on the side u runs around and v along +z.
Mesh make_cylinder(double diameter_mm, double height_mm);

/// Makes a sheet without thickness at z = 0, closed by its own back:
/// face 0 front (+z), 1 back (-z), uv
/// as for the box. Without a displacement it holds no volume and prints nothing.
Mesh make_plane(double x_mm, double y_mm);

}  // namespace openfab::mesh

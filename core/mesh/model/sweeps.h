// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Primitives of a world that are swept from an outline, in mm. All are closed and carry "uv" (2
// floats), "n" (3 floats; smooth where the outline turns by less than 30 degrees) and "face" (int):
// 0 faces straight up, 1 straight down, 2 is all else. Turned ones have 128 facets around, and their
// u runs with longitude from -y over +x, v along the outline from its first corner.

#include <vector>

#include "mesh/model/mesh.h"
#include "mesh/model/outline.h"

namespace openfab::mesh {

/// Makes what an area sweeps from z = 0 up to `height_mm`. Top and bottom have the uv of the area's
/// bounding rectangle; around each outline u runs along it, and v along +z. The outlines have passed
/// check_outlines.
Mesh make_extrusion(std::vector<Outline> outlines, double height_mm);

/// Makes what an area of (distance from the axis, z) sweeps around the z axis. The outline has passed
/// check_outlines, and no corner has an x below 0.
Mesh make_revolution(Outline outline);

/// Makes a cone, cut off or not; one of the diameters may be 0. Stands on z = 0, as the others do.
Mesh make_cone(double low_diameter_mm, double high_diameter_mm, double height_mm);

/// Makes a ring of round section; `diameter_mm` is that of its middle, larger than the section's.
Mesh make_torus(double diameter_mm, double section_mm);

/// Makes a cylinder with a half ball on each end; `length_mm` includes them and is at least the
/// diameter.
Mesh make_capsule(double diameter_mm, double length_mm);

}  // namespace openfab::mesh

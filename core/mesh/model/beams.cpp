// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/model/beams.h"

#include <cmath>

#include "mesh/model/primitives.h"

namespace openfab::mesh {

void add_beam_box(const Beams& beams, const Beam& beam, const Affine3d& map, Box3d* box) {
    const Vec3d at[2] = {beams.nodes[static_cast<size_t>(beam.nodes[0])],
                         beams.nodes[static_cast<size_t>(beam.nodes[1])]};
    const Vec3d along = at[1] - at[0];
    const double length2 = dot(along, along);
    for (size_t e = 0; e < 2; ++e) {
        const Vec3d p = map.apply(at[e]);
        Vec3d reach;
        for (int a = 0; a < 3; ++a) {
            const auto row = static_cast<size_t>(3 * a);
            const Vec3d m{map.m[row], map.m[row + 1], map.m[row + 2]};
            double square = dot(m, m);
            // Of a flat end the box is that of its circle.
            if (beam.ends[e] == BeamEnd::kFlat && length2 > 0)
                square = std::max(0.0, square - dot(m, along) * dot(m, along) / length2);
            reach[a] = std::sqrt(square) * static_cast<double>(beam.radii[e]);
        }
        box->add(p - reach);
        box->add(p + reach);
    }
}

Box3d box_of(const Beams& beams) {
    Box3d box;
    for (const Beam& beam : beams.beams)
        add_beam_box(beams, beam, {}, &box);
    return box;
}

int64_t beam_bytes(const Beams& beams) {
    size_t bytes =
        beams.nodes.size() * sizeof beams.nodes[0] + beams.beams.size() * sizeof beams.beams[0];
    for (const BeamAttribute& attribute : beams.attributes)
        bytes += attribute.values.size() * sizeof(float) + attribute.ints.size() * sizeof(int32_t);
    return static_cast<int64_t>(bytes);
}

Mesh box_mesh(const std::string& name, const Beams& beams) {
    const Box3d box = box_of(beams);
    const Vec3d size = box.size();
    Mesh mesh = make_box(size);
    const Vec3d shift = box.lo + Vec3d{size.x / 2, size.y / 2, 0};  // from where a box stands
    for (Vec3d& p : mesh.positions)
        p = p + shift;
    mesh.name = name;
    mesh.attributes.clear();
    for (const BeamAttribute& from : beams.attributes) {
        MeshAttribute attribute;
        attribute.name = from.name;
        attribute.components = from.components;
        attribute.is_int = from.is_int;
        const auto components = static_cast<size_t>(from.components);
        if (attribute.is_int) {
            attribute.faces.assign(mesh.triangles.size() * components, 0);
        } else {
            attribute.values.assign(components, 0.0f);
            attribute.corners.assign(mesh.triangles.size(), {0, 0, 0});
        }
        mesh.attributes.push_back(std::move(attribute));
    }
    return mesh;
}

}  // namespace openfab::mesh

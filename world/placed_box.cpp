// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/placed_box.h"

#include <algorithm>

#include "base/overloaded.h"
#include "pieces/extent.h"

namespace openfab::world {

GeometryFacts facts_of(const Geometry& geometry) {
    using Beams = std::shared_ptr<const mesh::Beams>;
    using Program = std::shared_ptr<const ProgramRef>;
    return std::visit(
        Overloaded{
            [](std::monostate /*itself*/) { return GeometryFacts{}; },
            [](const Beams& beams) { return GeometryFacts{.beams = beams.get()}; },
            [](const StageRef& stage) { return GeometryFacts{.stage = &stage, .is_made = true}; },
            [](const Program& program) {
                return GeometryFacts{.program = program.get(), .is_made = true};
            },
        },
        geometry);
}

Box3d placed_box(const World& world, const Object& object, int32_t piece, const Affine3d& map) {
    const mesh::Mesh& mesh = world.meshes[static_cast<size_t>(object.mesh)];
    Box3d box;
    if (piece >= 0) {
        box = pieces::piece_box({mesh.positions, mesh.triangles},
                                object.pieces->regions[static_cast<size_t>(piece)], map);
        if (box.empty()) return box;
    }
    const mesh::Beams* beams = world.beams_of(object.mesh);
    if (beams == nullptr) {
        for (size_t i = 0; piece < 0 && i < mesh.positions.size(); ++i)
            box.add(map.apply(mesh.positions[i]));
        return box;
    }
    Box3d of_beams;
    for (const mesh::Beam& beam : beams->beams)
        add_beam_box(*beams, beam, map, &of_beams);
    if (piece < 0 || of_beams.empty()) return of_beams;
    // Of a piece both are around it.
    for (int a = 0; a < 3; ++a) {
        box.lo[a] = std::max(box.lo[a], of_beams.lo[a]);
        box.hi[a] = std::min(box.hi[a], of_beams.hi[a]);
        if (box.lo[a] > box.hi[a]) return {};
    }
    return box;
}

bool asks_solid(const World& world, const Placement& placement) {
    const int32_t mesh = world.objects[static_cast<size_t>(placement.object)].mesh;
    return world.is_made(mesh) || (placement.piece >= 0 && world.boxed.contains(mesh));
}

size_t points_of(const World& world, const Object& object) {
    const mesh::Beams* beams = world.beams_of(object.mesh);
    return world.meshes[static_cast<size_t>(object.mesh)].positions.size() +
           (beams != nullptr ? 2 * beams->beams.size() : 0);
}

}  // namespace openfab::world

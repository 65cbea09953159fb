// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/part/bind_piece.h"

#include <fmt/format.h>

#include <cmath>

#include "pieces/collide.h"
#include "pieces/extent.h"
#include "runtime/part/messages.h"

namespace openfab::part {

Result<std::shared_ptr<const Piece>> bind_piece(const world::World& world,
                                                const world::Placement& placement,
                                                const PolarFactors& polar, const Part& part) {
    const world::Object& object = world.objects[placement.object];
    const pieces::Region& region = object.pieces->regions[placement.piece];
    const bool shapes = !region.added.empty() || !region.removed.empty();
    if (shapes && pieces::uniform_scale(polar.s) == 0) {
        return error_at(placement.location,
                        fmt::format(messages::kPieceUnevenScale, region.name, object.name),
                        messages::kPieceUnevenScaleHelp);
    }
    const Vec3d center = part.mesh != nullptr ? part.mesh->center_part_mm : Vec3d{};
    auto piece = std::make_shared<Piece>();
    piece->region = pieces::mapped(region, polar.s, center);
    for (const pieces::Filled& filled : region.filled) {
        size_t code = 0;
        while (world.materials[code].name != filled.material)
            ++code;
        piece->filled_codes.push_back(static_cast<uint8_t>(code + 1));
    }
    SourceLocation at;
    std::string misfit;
    if (part.mesh != nullptr && !part.mesh->triangles.empty()) {
        const bool moves = part.fablet->has_surface != 0 && std::isfinite(part.max_displacement_mm);
        misfit = pieces::misfit({part.mesh->positions, part.mesh->triangles}, piece->region,
                                moves ? double{part.max_displacement_mm} : 0, &at);
    }
    if (misfit.empty()) {
        at = object.pieces->location;
        misfit = pieces::collision(piece->region, &at);
    }
    if (misfit.empty()) return {std::move(piece)};
    return error_at(at, fmt::format(messages::kObjectBefore, object.name, misfit),
                    messages::kMisfitHelp);
}

}  // namespace openfab::part

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/kinds/kinds.h"

#include <fmt/format.h>

#include <iterator>

#include "runtime/part/shape_stage.h"
#include "runtime/solid/beams/beam_solid.h"
#include "runtime/solid/cut/cut.h"
#include "runtime/solid/grow/grow_solid.h"
#include "runtime/solid/mesh/mesh_solid.h"
#include "runtime/solid/messages.h"
#include "runtime/solid/shape/shape_solid.h"
#include "runtime/solid/stretched/stretched_solid.h"

namespace openfab::solid {

namespace {

/// In the order of part::Geometry.
constexpr const Kind* kKinds[] = {&kMeshKind, &kBeamKind, &kShapeKind, &kGrowKind};
static_assert(std::size(kKinds) == kKindCount);

/// Parts that are stretched are alike where they share what they are stretched from.
const Kind kStretchedKind{
    .refine = [](const surface::SurfaceOptions& options, const Bodies& bodies,
                 part::Part* part) -> Result<void> {
        part::Part source = part->stretched->source;
        return kind_of(source).refine(options, bodies, &source);
    },
    .bytes =
        [](const part::Part& part) {
            const part::Part& source = part.stretched->source;
            return kind_of(source).bytes(source);
        },
    .make = [](const part::Part& part, const surface::SurfaceOptions& options,
               const Bodies& bodies) -> Result<std::shared_ptr<Solid>> {
        const part::Part& source = part.stretched->source;
        Result<std::shared_ptr<Solid>> made = kind_of(source).make(source, options, bodies);
        if (!made) return made.error();
        return make_stretched_solid(part, std::move(*made));
    },
};

}  // namespace

const Kind& kind_of(const part::Part& part) {
    return part.stretched != nullptr ? kStretchedKind : *kKinds[part.geometry.index()];
}

namespace {

Result<Bodies> bodies_of(const part::Part& part, const surface::SurfaceOptions& options) {
    Bodies out;
    const part::ShapeStage* stage = part::stage_of(part);
    if (stage == nullptr) return out;
    for (const std::shared_ptr<const part::Part>& body : stage->bodies) {
        out.push_back(nullptr);
        if (body == nullptr) continue;
        Result<std::shared_ptr<Solid>> made = make_solid(*body, options);
        if (!made) return made.error();
        out.back() = std::move(*made);
    }
    return out;
}

}  // namespace

Result<std::shared_ptr<Solid>> make_solid(const part::Part& part,
                                          const surface::SurfaceOptions& options) {
    const Result<Bodies> bodies = bodies_of(part, options);
    if (!bodies) return bodies.error();
    return kind_of(part).make(part, options, *bodies);
}

bool reach_is_known(const part::Part& part) {
    return std::visit([](const auto& of) { return of.kReachIsKnown; }, part.geometry);
}

Result<Box3d> extent_in_build(const part::Part& part, openfab_isa isa) {
    if (!reach_is_known(part)) {
        return error_at(part::stage_of(part)->location,
                        fmt::format(messages::kReachNotKnown, part.name),
                        messages::kReachNotKnownHelp);
    }
    // Of what a shape asks for distances: they are within a fiftieth of this.
    constexpr double kCell_mm = 0.1;
    surface::SurfaceOptions options;
    options.micro_edge_mm = kCell_mm;
    options.isa = isa;
    const Result<std::shared_ptr<Solid>> solid = make_solid(part, options);
    if (!solid) return solid.error();
    const Box3d box = box_in_build(part, **solid);
    if (Result<void> fine = (*solid)->status(); !fine) return fine.error();
    return box;
}

Result<void> refine_source(const surface::SurfaceOptions& options, part::Part* part) {
    if (part->fablet->has_surface == 0) return kind_of(*part).refine(options, {}, part);
    const Result<Bodies> bodies = bodies_of(*part, options);
    if (!bodies) return bodies.error();
    return kind_of(*part).refine(options, *bodies, part);
}

int64_t source_bytes(const part::Part& part) {
    int64_t bytes = kind_of(part).bytes(part);
    const part::ShapeStage* stage = part::stage_of(part);
    if (stage == nullptr) return bytes;
    for (const std::shared_ptr<const part::Part>& body : stage->bodies)
        bytes += body != nullptr ? source_bytes(*body) : 0;
    return bytes;
}

}  // namespace openfab::solid

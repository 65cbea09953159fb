// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/volume/placed_part.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "abi/looks.h"
#include "runtime/part/part_mesh.h"
#include "runtime/solid/kinds/kinds.h"

namespace openfab::volume {

QueryNeeds query_needs(std::span<const openfab_arg> args) {
    QueryNeeds needs;
    for (const openfab_arg& arg : args) {
        switch (arg.kind) {
            case OPENFAB_ARG_DISTANCE:
            case OPENFAB_ARG_DISTANCE_LO:
            case OPENFAB_ARG_DISTANCE_HI:
                needs.distance = true;
                break;
            case OPENFAB_ARG_NEAREST:
            case OPENFAB_ARG_NEAREST_LO:
            case OPENFAB_ARG_NEAREST_HI:
                needs.attributes = true;
                break;
            case OPENFAB_ARG_NEAREST_GRAD:
                needs.gradients = true;
                break;
            default:
                break;
        }
    }
    return needs;
}

namespace {

std::span<const openfab_arg> arguments(const openfab_kernel& kernel) {
    return {kernel.args, static_cast<size_t>(kernel.arg_count)};
}

}  // namespace

PointNeeds point_needs(const openfab_segments& segments) {
    PointNeeds needs;
    for (int32_t i = 0; i < segments.query_count; ++i) {
        const openfab_query& query = segments.queries[i];
        const bool walks = query.stop >= 0;
        if (query.object >= 0 && !walks) continue;
        needs.any = true;
        needs.sign |= walks;
        for (int32_t k = 0; k < query.output_count; ++k) {
            const openfab_query_result kind = query.outputs[k].kind;
            needs.sign |= kind == OPENFAB_QUERY_DISTANCE;
            needs.geometry |= kind == OPENFAB_QUERY_POSITION || kind == OPENFAB_QUERY_NORMAL;
            needs.attributes |= kind == OPENFAB_QUERY_ATTRIBUTE;
        }
    }
    return needs;
}

QueryNeeds volume_needs(const openfab_fablet& fablet) {
    return query_needs({fablet.fields, static_cast<size_t>(fablet.field_count)});
}

bool asks_surface(const openfab_fablet& fablet) {
    return volume_needs(fablet).any() || query_needs(arguments(fablet.volume_bounds)).any() ||
           point_needs(fablet.volume_segments).any;
}

NearestIndex::NearestIndex(const openfab_fablet& fablet) {
    for (int32_t i = 0; i < fablet.nearest_count; ++i) {
        const openfab_varying& input = fablet.nearest[i];
        const bool is_float = input.scalar == OPENFAB_FLOAT;
        int32_t& count = is_float ? floats_ : ints_;
        is_float_.push_back(is_float);
        first_.push_back(count);
        count += input.components;
    }
}

namespace {

/// Returns the largest coordinate in a box of voxels, part-relative.
float largest_coordinate(const std::array<float, OPENFAB_FRAME_COUNT>& frame, const Box3i& box) {
    double largest = 0;
    for (uint32_t corner = 0; corner < 8; ++corner) {
        for (size_t a = 0; a < 3; ++a) {
            double at = frame[OPENFAB_FRAME_ORIGIN + a];
            for (int axis = 0; axis < 3; ++axis) {
                const size_t step = static_cast<size_t>(axis) * 3 + a;  // STEP_I, STEP_J, STEP_K
                at += frame[step] * double{(corner >> axis & 1) != 0
                                               ? static_cast<double>(box.hi[axis] + 2)
                                               : static_cast<double>(box.lo[axis] - 2)};
            }
            largest = std::max(largest, std::abs(at));
        }
    }
    return static_cast<float>(largest);
}

float voxel_diagonal(const std::array<float, OPENFAB_FRAME_COUNT>& frame) {
    double longest = 0;
    for (const double j : {1.0, -1.0}) {
        for (const double k : {1.0, -1.0}) {
            double sum = 0;
            for (size_t a = 0; a < 3; ++a) {
                const double d = frame[OPENFAB_FRAME_STEP_I + a] +
                                 j * frame[OPENFAB_FRAME_STEP_J + a] +
                                 k * frame[OPENFAB_FRAME_STEP_K + a];
                sum += d * d;
            }
            longest = std::max(longest, sum);
        }
    }
    return static_cast<float>(std::sqrt(longest));
}

}  // namespace

void PlacedPart::set_grid(const part::Grid& grid, const solid::QuerySetUp& queries,
                          size_t crossing_bytes, const PlacedPart& first) {
    owner = first.index;
    frame = part::make_frame(*part, grid);
    base = part::part_base_voxel(*part, grid);
    volume = volume_needs(*part->fablet);
    bounds = query_needs(arguments(part->fablet->volume_bounds));
    bounds_say_looks = std::ranges::any_of(arguments(part->fablet->volume_bounds), abi::is_looks);
    points = point_needs(part->fablet->volume_segments);
    if (&first == this) {
        solid->prepare({.nearest = asks_surface(*part->fablet),
                        .attributes = volume.attributes || volume.gradients || bounds.attributes ||
                                      points.attributes || points.geometry,
                        .geometry = points.geometry,
                        .sign = points.sign},
                       queries);
    }
    placed = solid->place({*part, grid, frame, crossing_bytes});
    box = placed->voxel_box();
    if (part->piece != nullptr) {
        cut = std::make_unique<const solid::Cut>(*part, grid, *solid, box);
        box = cut->box();
    }
    voxel_diagonal_mm = voxel_diagonal(frame);
    largest_coordinate_mm = largest_coordinate(frame, {box.lo - base, box.hi - base});
    for (int a = 0; a < 3; ++a) {
        box.lo[a] = std::max(box.lo[a], 0);
        box.hi[a] = std::min(box.hi[a], grid.size[a]);
    }
    channels =
        abi::Channels(std::vector<int32_t>(part->slot_material.begin(), part->slot_material.end()));
    largest_pitch_mm =
        static_cast<float>(std::max({grid.pitch_mm.x, grid.pitch_mm.y, grid.pitch_mm.z}));
    if (asks_surface(*part->fablet)) placed->begin_queries();
}

void PlacedPart::set_own_dither(uint32_t seed) {
    own_dither = part->fablet->has_dither != 0;
    for (int32_t axis = 0; axis < 3; ++axis)
        rule_inputs[static_cast<size_t>(OPENFAB_GRID_BASE + axis)] =
            static_cast<uint32_t>(base[axis]);
    rule_inputs[OPENFAB_GRID_SEED] = seed;
}

void resolve_object_queries(const std::vector<std::unique_ptr<PlacedPart>>& parts,
                            const solid::QuerySetUp& queries) {
    for (const auto& asking : parts) {
        const openfab_segments& segments = asking->part->fablet->volume_segments;
        asking->targets.resize(asking->part->objects.size());
        for (int32_t q = 0; q < segments.query_count; ++q) {
            if (segments.queries[q].object < 0) continue;
            const auto object = static_cast<size_t>(segments.queries[q].object);
            std::vector<QueryTarget>& targets = asking->targets[object];
            if (!targets.empty()) continue;  // an earlier query has the same object
            for (const int32_t target : asking->part->objects[object]) {
                const PlacedPart& placed = *parts[target];
                PlacedPart& answering = *parts[placed.owner];
                answering.solid->prepare({.nearest = true, .sign = true}, queries);
                answering.placed->begin_queries();
                targets.push_back({answering.index, answering.placed.get(),
                                   part::local_to_local(*asking->part, *placed.part)});
            }
        }
    }
}

size_t make_walk_lattices(const std::vector<std::unique_ptr<PlacedPart>>& parts, size_t bytes) {
    // Walks that end on the own surface alone are the same for all parts that share it.
    using Key = std::pair<int32_t, size_t>;
    std::map<Key, std::vector<std::shared_ptr<WalkLattice>*>> wanted;
    for (const auto& part : parts) {
        const openfab_segments& segments = part->part->fablet->volume_segments;
        part->lattices.resize(part->targets.size() + 1);
        for (int32_t q = 0; q < segments.query_count; ++q) {
            if (segments.queries[q].stop < 0) continue;
            const auto number = static_cast<size_t>(segments.queries[q].object + 1);
            wanted[{number == 0 ? part->owner : part->index, number}].push_back(
                &part->lattices[number]);
        }
    }
    for (const auto& [key, places] : wanted) {
        const auto lattice =
            std::make_shared<WalkLattice>(parts[static_cast<size_t>(key.first)]->solid->bounds(),
                                          key.second > 0, bytes / wanted.size());
        for (std::shared_ptr<WalkLattice>* place : places)
            *place = lattice;
    }
    return wanted.size();
}

namespace {

/// Returns whether two fablets see one surface, and ask the same structures over it.
bool ask_alike(const openfab_fablet& a, const openfab_fablet& b) {
    if (&a == &b) return true;
    const PointNeeds points_a = point_needs(a.volume_segments);
    const PointNeeds points_b = point_needs(b.volume_segments);
    return part::is_plain(a) && part::is_plain(b) && asks_surface(a) == asks_surface(b) &&
           points_a.sign == points_b.sign && points_a.geometry == points_b.geometry;
}

}  // namespace

std::vector<int32_t> solid_owners(const std::vector<part::Part>& parts) {
    std::vector<int32_t> owners;
    // By geometry, to avoid comparing all pairs.
    std::map<const void*, std::vector<int32_t>> known;
    for (size_t i = 0; i < parts.size(); ++i) {
        const solid::Kind& kind = solid::kind_of(parts[i]);
        std::vector<int32_t>& candidates = known[part::shared_geometry(parts[i])];
        const auto same = std::find_if(candidates.begin(), candidates.end(), [&](int32_t p) {
            return ask_alike(*parts[p].fablet, *parts[i].fablet) && kind.alike(parts[p], parts[i]);
        });
        if (same == candidates.end()) {
            owners.push_back(static_cast<int32_t>(i));
            candidates.push_back(owners.back());
        } else {
            owners.push_back(*same);
        }
    }
    return owners;
}

Result<void> refine_sources(const std::vector<int32_t>& owners,
                            const surface::SurfaceOptions& options,
                            std::vector<part::Part>* parts) {
    for (size_t i = 0; i < parts->size(); ++i) {
        part::Part& part = (*parts)[i];
        if (owners[i] != static_cast<int32_t>(i)) {
            part.mesh = (*parts)[owners[i]].mesh;
            part.geometry = (*parts)[owners[i]].geometry;
        } else if (Result<void> done = solid::refine_source(options, &part); !done) {
            return done.error();
        }
    }
    return {};
}

Result<std::vector<std::shared_ptr<solid::Solid>>> make_solids(
    const std::vector<part::Part>& parts, const std::vector<int32_t>& owners,
    const surface::SurfaceOptions& options) {
    std::vector<std::shared_ptr<solid::Solid>> solids(parts.size());
    std::vector<std::optional<Error>> errors(parts.size());
    tbb::parallel_for(size_t{0}, parts.size(), [&](size_t i) {
        if (owners[i] != static_cast<int32_t>(i)) return;
        Result<std::shared_ptr<solid::Solid>> made = solid::make_solid(parts[i], options);
        if (made) {
            solids[i] = std::move(*made);
        } else {
            errors[i] = made.error();
        }
    });
    for (size_t i = 0; i < parts.size(); ++i) {
        if (errors[i]) return *errors[i];
        if (solids[i] == nullptr) solids[i] = solids[owners[i]];
    }
    return solids;
}

}  // namespace openfab::volume

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/slab/print_part.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <map>
#include <optional>

namespace openfab::slab {

QueryNeeds query_needs(const openfab_kernel& kernel) {
    QueryNeeds needs;
    for (int32_t i = 0; i < kernel.arg_count; ++i) {
        switch (kernel.args[i].kind) {
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

QueryNeeds query_needs(const openfab_phases& phases) {
    QueryNeeds needs;
    for (int32_t i = 0; i < phases.kernel_count; ++i) {
        const QueryNeeds one = query_needs(phases.kernels[i]);
        needs.distance |= one.distance;
        needs.attributes |= one.attributes;
        needs.gradients |= one.gradients;
    }
    return needs;
}

PointNeeds point_needs(const openfab_phases& phases) {
    PointNeeds needs;
    for (int32_t i = 0; i < phases.query_count; ++i) {
        const openfab_query& query = phases.queries[i];
        if (query.object >= 0) continue;
        needs.any = true;
        for (int32_t k = 0; k < query.output_count; ++k) {
            const openfab_query_result kind = query.outputs[k].kind;
            needs.sign |= kind == OPENFAB_QUERY_DISTANCE;
            needs.geometry |= kind == OPENFAB_QUERY_POSITION || kind == OPENFAB_QUERY_NORMAL;
        }
    }
    return needs;
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

void PrintPart::place(const scene::Grid& grid, openfab_isa isa, size_t tree_bytes,
                      size_t crossing_bytes, const PrintPart& first) {
    const bool owns = &first == this;
    owner = first.index;
    frame = scene::make_frame(*part, grid);
    base = scene::part_base_voxel(*part, grid);
    patches = owns ? std::make_shared<const voxel::PatchIndex>(*surface) : first.patches;
    voxeliser = std::make_unique<voxel::Voxeliser>(*part, *surface, grid, crossing_bytes, patches);
    box = voxeliser->voxel_box();
    for (int a = 0; a < 3; ++a) {
        box.lo[a] = std::max(box.lo[a], 0);
        box.hi[a] = std::min(box.hi[a], grid.size[a]);
    }
    for (uint8_t material : part->slot_material)
        slot_material.push_back(material);
    const openfab_phases& phases = part->fablet->volume_phases;
    volume = phases.step_count == 0 ? query_needs(part->fablet->volume) : query_needs(phases);
    bounds = query_needs(part->fablet->volume_bounds);
    points = point_needs(phases);
    largest_pitch_mm =
        static_cast<float>(std::max({grid.pitch_mm.x, grid.pitch_mm.y, grid.pitch_mm.z}));
    if (!volume.any() && !bounds.any() && !points.any) return;
    trees = owns ? nearest::make_block_index(*surface, {tree_bytes, isa == OPENFAB_ISA_AVX2})
                 : first.trees;
    engine = nearest::make_block_engine(trees, frame);
    attributes = owns ? std::make_unique<nearest::AttributeReader>(*surface, frame, points.geometry)
                      : std::make_unique<nearest::AttributeReader>(*first.attributes, frame);
    if (points.sign)
        winding = owns ? std::make_shared<const nearest::Winding>(*surface) : first.winding;
}

void PrintPart::answer_points(openfab_isa isa, size_t tree_bytes) {
    if (engine == nullptr) {
        trees = nearest::make_block_index(*surface, {tree_bytes, isa == OPENFAB_ISA_AVX2});
        engine = nearest::make_block_engine(trees, frame);
    }
    if (winding == nullptr) winding = std::make_shared<const nearest::Winding>(*surface);
}

void connect_targets(const std::vector<std::unique_ptr<PrintPart>>& parts, openfab_isa isa,
                     size_t tree_bytes) {
    for (const auto& asking : parts) {
        const openfab_phases& phases = asking->part->fablet->volume_phases;
        asking->targets.resize(asking->part->objects.size());
        for (int32_t q = 0; q < phases.query_count; ++q) {
            if (phases.queries[q].object < 0) continue;
            const auto object = static_cast<size_t>(phases.queries[q].object);
            std::vector<QueryTarget>& targets = asking->targets[object];
            if (!targets.empty()) continue;  // an earlier query asks it too
            for (const int32_t place : asking->part->objects[object]) {
                const PrintPart& placed = *parts[static_cast<size_t>(place)];
                PrintPart& answering = *parts[static_cast<size_t>(placed.owner)];
                answering.answer_points(isa, tree_bytes);
                targets.push_back({answering.index, answering.engine.get(), answering.winding.get(),
                                   scene::local_to_local(*asking->part, *placed.part)});
            }
        }
    }
}

namespace {

/// Whether a kernel gets the same uniforms, textures and instance from both parts.
bool same_arguments(const openfab_kernel& kernel, const scene::Part& a, const scene::Part& b) {
    for (int32_t i = 0; i < kernel.arg_count; ++i) {
        const auto index = static_cast<size_t>(kernel.args[i].a);
        switch (kernel.args[i].kind) {
            case OPENFAB_ARG_UNIFORM:
                if (a.uniform_values[index] != b.uniform_values[index]) return false;
                break;
            case OPENFAB_ARG_TEXTURE:
                if (a.textures[index] != b.textures[index]) return false;
                break;
            case OPENFAB_ARG_INSTANCE:
                if (a.instance != b.instance) return false;
                break;
            default:
                break;
        }
    }
    return true;
}

bool share_surface(const scene::Part& a, const scene::Part& b) {
    return a.mesh == b.mesh && a.fablet == b.fablet &&
           a.max_displacement_mm == b.max_displacement_mm &&
           same_arguments(a.fablet->surface, a, b) &&
           same_arguments(a.fablet->surface_bounds, a, b);
}

}  // namespace

std::vector<int32_t> surface_owners(const std::vector<scene::Part>& parts) {
    std::vector<int32_t> owners;
    // By mesh, so that many different ones are not all compared with each other.
    std::map<const scene::PartMesh*, std::vector<int32_t>> known;
    for (size_t i = 0; i < parts.size(); ++i) {
        std::vector<int32_t>& candidates = known[parts[i].mesh.get()];
        const auto same = std::find_if(candidates.begin(), candidates.end(), [&](int32_t p) {
            return share_surface(parts[static_cast<size_t>(p)], parts[i]);
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

Result<std::vector<std::shared_ptr<const surface::Surface>>> make_surfaces(
    const std::vector<scene::Part>& parts, const std::vector<int32_t>& owners,
    const surface::SurfaceOptions& options) {
    std::vector<std::shared_ptr<const surface::Surface>> surfaces(parts.size());
    std::vector<std::optional<Error>> errors(parts.size());
    tbb::parallel_for(size_t{0}, parts.size(), [&](size_t i) {
        if (owners[i] != static_cast<int32_t>(i)) return;
        Result<std::unique_ptr<surface::Surface>> made =
            surface::Surface::create(parts[i], options);
        if (made) {
            surfaces[i] = std::move(*made);
        } else {
            errors[i] = made.error();
        }
    });
    for (size_t i = 0; i < parts.size(); ++i) {
        if (errors[i]) return *errors[i];
        if (surfaces[i] == nullptr) surfaces[i] = surfaces[static_cast<size_t>(owners[i])];
    }
    return surfaces;
}

}  // namespace openfab::slab

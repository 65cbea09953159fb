// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/volume/placed_part.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "runtime/part/part_mesh.h"
#include "runtime/surface/long_triangles.h"
#include "runtime/surface/morton_order.h"
#include "simd/isa.h"

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

/// Queries may use more than kernels do, except where a print is limited to SSE4.1.
simd::Isa widest_queries(openfab_isa isa) {
    return isa >= OPENFAB_ISA_AVX2 ? simd::Isa::kAvx512 : simd::Isa::kSse41;
}

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

void PlacedPart::set_grid(const part::Grid& grid, openfab_isa isa,
                          const std::shared_ptr<nearest::PatchCache>& trees_of_patches,
                          size_t crossing_bytes, const PlacedPart& first) {
    const bool owns = &first == this;
    owner = first.index;
    frame = part::make_frame(*part, grid);
    base = part::part_base_voxel(*part, grid);
    std::vector<uint64_t> along;
    if (owns) along = surface::morton_order(surface->patches());
    patches = owns ? std::make_shared<const voxel::PatchIndex>(*surface, along) : first.patches;
    voxeliser = std::make_unique<voxel::Voxeliser>(*part, *surface, grid, crossing_bytes, patches);
    box = voxeliser->voxel_box();
    voxel_diagonal_mm = voxel_diagonal(frame);
    largest_coordinate_mm = largest_coordinate(frame, {box.lo - base, box.hi - base});
    for (int a = 0; a < 3; ++a) {
        box.lo[a] = std::max(box.lo[a], 0);
        box.hi[a] = std::min(box.hi[a], grid.size[a]);
    }
    channels =
        abi::Channels(std::vector<int32_t>(part->slot_material.begin(), part->slot_material.end()));
    const openfab_segments& segments = part->fablet->volume_segments;
    volume = volume_needs(*part->fablet);
    bounds = query_needs(arguments(part->fablet->volume_bounds));
    points = point_needs(segments);
    largest_pitch_mm =
        static_cast<float>(std::max({grid.pitch_mm.x, grid.pitch_mm.y, grid.pitch_mm.z}));
    if (!asks_surface(*part->fablet)) return;
    trees = owns ? nearest::make_block_index(
                       *surface, {.cache = trees_of_patches, .widest = widest_queries(isa)}, along)
                 : first.trees;
    engine = nearest::make_block_engine(trees, frame);
    attributes = owns ? std::make_unique<nearest::AttributeReader>(*surface, frame, points.geometry)
                      : std::make_unique<nearest::AttributeReader>(*first.attributes, frame);
    if (points.sign)
        winding = owns ? std::make_shared<const nearest::Winding>(*surface) : first.winding;
}

void PlacedPart::set_own_dither(uint32_t seed) {
    own_dither = part->fablet->has_dither != 0;
    for (int32_t axis = 0; axis < 3; ++axis)
        rule_inputs[static_cast<size_t>(OPENFAB_GRID_BASE + axis)] =
            static_cast<uint32_t>(base[axis]);
    rule_inputs[OPENFAB_GRID_SEED] = seed;
}

void PlacedPart::build_sign_query(openfab_isa isa,
                                  const std::shared_ptr<nearest::PatchCache>& trees_of_patches) {
    if (engine == nullptr) {
        trees = nearest::make_block_index(
            *surface, {.cache = trees_of_patches, .widest = widest_queries(isa)});
        engine = nearest::make_block_engine(trees, frame);
    }
    if (winding == nullptr) winding = std::make_shared<const nearest::Winding>(*surface);
}

void resolve_object_queries(const std::vector<std::unique_ptr<PlacedPart>>& parts, openfab_isa isa,
                            const std::shared_ptr<nearest::PatchCache>& trees_of_patches) {
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
                answering.build_sign_query(isa, trees_of_patches);
                targets.push_back({answering.index, answering.engine.get(), answering.winding.get(),
                                   part::local_to_local(*asking->part, *placed.part)});
            }
        }
    }
}

namespace {

/// Returns whether a kernel gets the same uniforms, textures and instance from both parts.
bool same_arguments(const openfab_kernel& kernel, const part::Part& a, const part::Part& b) {
    for (int32_t i = 0; i < kernel.arg_count; ++i) {
        const auto index = static_cast<size_t>(kernel.args[i].a);
        switch (kernel.args[i].kind) {
            case OPENFAB_ARG_UNIFORM:
                if (a.uniform_values[index] != b.uniform_values[index]) return false;
                break;
            case OPENFAB_ARG_VALUES:
                if (a.uniform_values != b.uniform_values) return false;
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

/// Returns whether two fablets see one surface, and ask the same structures over it.
bool ask_alike(const openfab_fablet& a, const openfab_fablet& b) {
    if (&a == &b) return true;
    const PointNeeds points_a = point_needs(a.volume_segments);
    const PointNeeds points_b = point_needs(b.volume_segments);
    return part::is_plain(a) && part::is_plain(b) && asks_surface(a) == asks_surface(b) &&
           points_a.sign == points_b.sign && points_a.geometry == points_b.geometry;
}

bool share_surface(const part::Part& a, const part::Part& b) {
    return a.mesh == b.mesh && ask_alike(*a.fablet, *b.fablet) &&
           a.max_displacement_mm == b.max_displacement_mm &&
           same_arguments(a.fablet->surface, a, b) &&
           same_arguments(a.fablet->surface_bounds, a, b);
}

}  // namespace

std::vector<int32_t> surface_owners(const std::vector<part::Part>& parts) {
    std::vector<int32_t> owners;
    // By mesh, to avoid comparing all pairs.
    std::map<const part::PartMesh*, std::vector<int32_t>> known;
    for (size_t i = 0; i < parts.size(); ++i) {
        std::vector<int32_t>& candidates = known[parts[i].mesh.get()];
        const auto same = std::find_if(candidates.begin(), candidates.end(), [&](int32_t p) {
            return share_surface(parts[p], parts[i]);
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

Result<void> split_meshes(const std::vector<int32_t>& owners,
                          const surface::SurfaceOptions& options, std::vector<part::Part>* parts) {
    for (size_t i = 0; i < parts->size(); ++i) {
        part::Part& part = (*parts)[i];
        if (owners[i] != static_cast<int32_t>(i)) {
            part.mesh = (*parts)[owners[i]].mesh;
            continue;
        }
        Result<std::shared_ptr<const part::PartMesh>> mesh = surface::mesh_to_dice(part, options);
        if (!mesh) return mesh.error();
        part.mesh = std::move(*mesh);
    }
    return {};
}

Result<std::vector<std::shared_ptr<const surface::Surface>>> make_surfaces(
    const std::vector<part::Part>& parts, const std::vector<int32_t>& owners,
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
        if (surfaces[i] == nullptr) surfaces[i] = surfaces[owners[i]];
    }
    return surfaces;
}

}  // namespace openfab::volume

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/print_setup.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "abi/voxel_hash.h"
#include "base/allowance.h"
#include "base/clock.h"
#include "base/overloaded.h"
#include "runtime/pipeline/check.h"
#include "runtime/pipeline/grid.h"
#include "runtime/pipeline/memory_needs.h"
#include "runtime/pipeline/messages.h"
#include "runtime/pipeline/part_sizes.h"
#include "runtime/pipeline/provenance.h"
#include "runtime/solid/kinds/kinds.h"

namespace openfab::pipeline {

namespace {

Error interrupted_early() {
    return Error{ErrorCode::kInterrupted, messages::kInterruptedBefore};
}

/// Makes the solids; fails before allocating what cannot fit.
Result<void> set_up_solids(PrintSetup* p, const MemoryPlanner& planner,
                           const CacheBudgets& caches) {
    surface::SurfaceOptions& options = p->surface_options;
    options.micro_edge_mm =
        std::cbrt(p->input.pitch_mm.x * p->input.pitch_mm.y * p->input.pitch_mm.z);
    options.isa = p->options.isa;
    options.infer_identity = p->options.infer_identity;
    options.stop = p->options.interrupt;
    options.cache_bytes = caches.micropolygons;
    if (const Result<void> split = volume::refine_sources(p->owners, options, &p->input.parts);
        !split)
        return split;
    int64_t bytes = 0;
    for (size_t i = 0; i < p->owners.size(); ++i)
        bytes += p->owns_solid(i) ? solid::source_bytes(p->input.parts[i]) : 0;
    if (const Result<void> fits = planner.check(bytes, resident_bytes()); !fits) return fits;
    auto solids = volume::make_solids(p->input.parts, p->owners, options);
    if (!solids) return solids.error();
    p->solids = std::move(*solids);
    if (p->options.interrupted()) return interrupted_early();
    p->warnings = crowded_warnings(p->input.parts, p->owners, p->solids);
    bytes = 0;
    for (size_t i = 0; i < p->owners.size(); ++i) {
        if (const solid::Dicing* dicing = p->own_dicing(i); dicing != nullptr)
            bytes += dicing->index_bytes(volume::asks_surface(*p->input.parts[i].fablet));
    }
    return planner.check(bytes, resident_bytes());
}

/// Finds the grid around all surfaces and the slices of it that are printed.
Result<void> set_up_grid(PrintSetup* p) {
    const std::span<const part::Part> parts(p->input.parts);
    Result<part::Grid> grid = make_grid(
        parts.first(parts.size() - static_cast<size_t>(p->input.beside_grid)), p->solids,
        p->input.pitch_mm, abi::voxel_bits(static_cast<int32_t>(p->input.materials.size())),
        p->input.margin_vox, p->input.crop_mm, p->input.window_mm, p->input.lattice_mm);
    if (p->options.interrupted()) return interrupted_early();
    if (!grid) return grid.error();
    if (const Result<void> diced = p->solid_status(); !diced) return diced;
    p->grid = *grid;
    for (std::string& thin : thin_part_warnings(p->input.parts, p->solids, p->input.pitch_mm))
        p->warnings.push_back(std::move(thin));
    for (int axis = 0; axis < 3; ++axis) {
        const double pitch = p->grid.pitch_mm[axis];
        if (p->input.lattice_mm) {
            p->grid.origin_mm[axis] -= p->input.around_vox * pitch;
        } else {
            p->grid.origin_mm[axis] =
                (std::round(p->grid.origin_mm[axis] / pitch) - p->input.around_vox) * pitch;
        }
        p->grid.size[axis] += 2 * p->input.around_vox;
    }
    Result<Vec2<int32_t>> range = slice_range(p->grid, p->options);
    if (!range) return range.error();
    p->range = *range;
    return {};
}

// In parallel: parts that own their solid first, since the others share theirs.
void place_parts(PrintSetup* p, size_t crossing_bytes) {
    for (const bool owners : {true, false}) {
        tbb::parallel_for(size_t{0}, p->parts.size(), [&](size_t i) {
            if (p->owns_solid(i) != owners) return;
            p->parts[i]->set_grid(p->grid, p->queries(), crossing_bytes, *p->parts[p->owners[i]]);
            if (p->options.dither == dither::kOwnDitherName)
                p->parts[i]->set_own_dither(abi::fold_seed(p->options.seed));
        });
    }
}

/// Places the parts on the grid and orders them: higher priority first, then the later in the build
/// list.
void set_up_parts(PrintSetup* p, size_t crossing_bytes) {
    for (size_t i = 0; i < p->input.parts.size(); ++i) {
        p->parts.push_back(std::make_unique<volume::PlacedPart>(p->input.parts[i]));
        p->parts.back()->index = static_cast<int32_t>(i);
        p->parts.back()->solid = p->solids[i];
        if (p->input.prints(i)) p->slabs.order.push_back(static_cast<int32_t>(i));
    }
    place_parts(p, crossing_bytes);
    volume::resolve_object_queries(p->parts, p->queries());
    std::sort(p->slabs.order.begin(), p->slabs.order.end(), [&](int32_t a, int32_t b) {
        const int32_t pa = p->parts[a]->part->priority;
        const int32_t pb = p->parts[b]->part->priority;
        return pa != pb ? pa > pb : a > b;
    });
}

void set_up_slabs(PrintSetup* p) {
    p->slabs.parts = &p->parts;
    const auto materials = static_cast<int32_t>(p->input.materials.size());
    p->slabs.materials = model_materials(p->input.parts, materials, p->input.support_code);
    p->slabs.channels = dither::fraction_channels(p->slabs.materials);
    p->slabs.bits = abi::voxel_bits(materials);
    p->slabs.isa = p->options.isa;
    p->slabs.dither = *dither::find_dither(p->options.dither);
    p->slabs.seed = p->options.seed;
    p->slabs.size = p->grid.size;
    p->slabs.solid_code = p->input.solid_code;
    // Nothing is evaluated then that could be left out.
    p->slabs.culling = p->options.culling && p->input.solid_code == 0;
    p->slabs.fractions = p->options.fractions;
    if (p->options.fractions != nullptr && p->options.rates.columns > 0)
        p->slabs.rates = &p->options.rates;
    for (const process::Effect* effect : p->options.effects) {
        if (effect->spreads()) p->slabs.spreads.push_back(effect);
    }
    p->slabs.separate_mixtures =
        p->slabs.fractions != nullptr &&
        std::any_of(p->parts.begin(), p->parts.end(), [](const auto& p) { return p->own_dither; });
}

Result<void> begin_effects(const PrintSetup& p) {
    process::EffectGrid grid{p.grid.origin_mm, p.grid.pitch_mm, p.grid.size, {}};
    const auto ruled =
        std::ranges::find_if(p.parts, [](const auto& part) { return part->own_dither; });
    if (ruled != p.parts.end()) grid.ruled_fablet = (*ruled)->part->fablet->name;
    for (process::Effect* effect : p.options.effects) {
        if (const Result<void> begun = effect->begin(grid); !begun) return begun;
    }
    return {};
}

/// Adds what rows of blocks take that are computed from those around them.
void add_spread_needs(const std::vector<const process::Effect*>& spreads, MemoryNeeds* needs) {
    if (spreads.empty()) return;
    const int64_t coverage = needs->per_slab / 2;  // planes and encoded slices stay one slab's
    const int64_t row = needs->per_row;
    int64_t slabs = 1, after = 1, most = 0;
    for (size_t k = spreads.size(); k-- > 0;) {
        const Vec3i near = spreads[k]->reach_blocks();
        after = std::exchange(slabs, slabs + 2 * near.z);
        needs->per_slab += (2 * near.y + 1) * slabs * row;
        most = std::max(most, spreads[k]->spread_bytes());
    }
    needs->per_slab += (slabs - 1) * coverage;
    // Those around, and those that are made of them, in which all columns may be new.
    needs->per_row *= slabs + 2 * after;
    needs->per_thread += most;
}

Result<MemoryPlan> plan_memory(const PrintSetup* p, const MemoryPlanner& planner,
                               const CacheBudgets& caches, const SurfaceCounts& displaced,
                               int64_t textures) {
    SurfaceCounts diced;
    for (size_t i = 0; i < p->solids.size(); ++i) {
        if (p->solids[i]->dicing() == nullptr) continue;
        ++diced.parts;
        diced.surfaces += p->owns_solid(i) ? 1 : 0;
    }
    const int64_t columns = int64_t{p->grid.size.x} * p->grid.size.y;
    MemoryNeeds needs = memory_needs(p->parts, p->grid.size, p->slabs.channels, p->slabs.bits,
                                     planner.max_pinned_bytes());
    needs.fixed += textures + p->options.sink_bytes_per_column * columns;
    if (p->options.fractions != nullptr && p->slabs.separate_mixtures) needs.per_row *= 2;
    // Columns whose fractions change become new ones.
    for (const process::Effect* effect : p->options.effects)
        needs.per_row *= effect->changes_voxels() ? 2 : 1;
    add_spread_needs(p->slabs.spreads, &needs);
    if (p->options.fractions != nullptr)
        needs.per_row += int64_t{p->grid.size.x} * p->slabs.materials * int64_t{sizeof(float)};
    if (p->slabs.rates != nullptr)
        needs.per_row += int64_t{p->grid.size.x + 8} * 65 * p->slabs.materials *
                         p->slabs.rates->columns * int64_t{sizeof(float)};
    const int32_t slabs = (p->range.y + 7) / 8 - p->range.x / 8;
    return planner.plan(needs, caches, displaced, diced, slabs, p->options.slabs_in_flight);
}

void fill_info(PrintSetup* p) {
    p->info.size = p->grid.size;
    p->info.pitch_mm = p->grid.pitch_mm;
    p->info.origin_mm = p->grid.origin_mm;
    p->info.slice_begin = p->range.x;
    p->info.slice_end = p->range.y;
    p->info.bits = p->slabs.bits;
    p->info.materials = p->input.materials;
    p->info.support_code = p->input.support_code;
    p->info.printer = p->input.printer;
    p->info.title = p->input.title;
    p->info.seed = p->options.seed;
    p->info.provenance = provenance(p->input, p->options);
}

Result<void> set_up_support(PrintSetup* p) {
    if (p->input.support_code == 0) return {};
    std::vector<support_material::SupportedPart> supported;
    for (const auto& part : p->parts) {
        if (!part->part->support || !p->input.prints(static_cast<size_t>(part->index))) continue;
        supported.push_back({part->placed.get(), part->box});
        if (part->cut == nullptr || part->box.lo.x >= part->box.hi.x) continue;
        supported.back().tops = solid::tops_of_piece(*part->placed, *part->cut, part->box);
    }
    Result<support_material::DepthMap> map = support_material::DepthMap::create(
        supported, p->grid,
        std::max(p->options.memory_bytes, p->options.most_memory_bytes) - resident_bytes());
    if (!map) return map.error();
    p->support = std::make_unique<const support_material::DepthMap>(std::move(*map));
    p->slabs.support = {p->support.get(), static_cast<uint8_t>(p->input.support_code)};
    return {};
}

/// Whether a solid is diced though no @Surface moves it.
bool is_diced_unmoved(const part::Part& part) {
    return std::visit(
        Overloaded{
            [](const part::MeshGeometry&) { return false; },
            [](const part::BeamGeometry&) { return false; },
            [&](const part::ShapeGeometry&) { return volume::asks_surface(*part.fablet); },
            [](const part::GrownGeometry&) { return true; },
        },
        part.geometry);
}

Result<void> set_up(PrintSetup* p) {
    const double start = seconds_now();
    p->threads = p->options.threads > 0 ? p->options.threads : usable_cores();
    p->options.isa = abi::best_isa(p->options.isa);
    if (const Result<void> checked = check_input(p->input, p->options); !checked) return checked;
    const MemoryPlanner planner(
        {p->options.memory_bytes, p->options.reserved_bytes, p->options.most_memory_bytes},
        p->threads);
    const int64_t textures = texture_bytes(p->input.parts);

    p->owners = volume::solid_owners(p->input.parts);
    SurfaceCounts displaced;
    for (size_t i = 0; i < p->owners.size(); ++i) {
        const part::Part& part = p->input.parts[i];
        if (part.fablet->has_surface == 0 && !is_diced_unmoved(part)) continue;
        ++displaced.parts;
        displaced.surfaces += p->owns_solid(i) ? 1 : 0;
    }
    const CacheBudgets caches = planner.caches(displaced, resident_bytes(), textures);
    if (const Result<void> made = set_up_solids(p, planner, caches); !made) return made;
    if (const Result<void> made = set_up_grid(p); !made) return made;
    p->trees = nearest::make_patch_cache(caches.trees);
    nearest::set_max_pinned(p->trees.get(), planner.max_pinned_bytes());
    set_up_parts(p, caches.crossings);
    volume::make_walk_lattices(p->parts, planner.walk_bytes());
    if (p->options.interrupted()) return interrupted_early();
    set_up_slabs(p);
    if (const Result<void> begun = begin_effects(*p); !begun) return begun;
    if (const Result<void> made = set_up_support(p); !made) return made;
    if (p->options.interrupted()) return interrupted_early();

    const Result<MemoryPlan> plan = plan_memory(p, planner, caches, displaced, textures);
    if (!plan) return plan.error();
    p->plan = *plan;
    if (plan->total_bytes > p->options.memory_bytes) {
        p->warnings.push_back(fmt::format(messages::kPrintTakes, format_bytes(plan->total_bytes),
                                          format_bytes(p->options.memory_bytes)));
    }
    for (const auto& solid : p->solids) {
        if (const solid::Dicing* dicing = solid->dicing(); dicing != nullptr)
            dicing->set_cache_bytes(p->plan.caches.micropolygons);
    }
    nearest::set_budget(p->trees.get(), p->plan.caches.trees);
    p->slabs.rows_in_flight = p->plan.rows_in_flight;
    fill_info(p);
    p->seconds = seconds_now() - start;
    return {};
}

}  // namespace

int64_t PrintSetup::patches_diced() const {
    int64_t diced = 0;
    for (size_t i = 0; i < solids.size(); ++i)
        diced += own_dicing(i) != nullptr ? own_dicing(i)->counts().cache_misses : 0;
    return diced;
}

/// A patch whose kernel failed is empty in all slabs from the first one that needed it.
Result<void> PrintSetup::solid_status() const {
    for (size_t i = 0; i < solids.size(); ++i) {
        if (!owns_solid(i)) continue;
        const Result<void> status = solids[i]->status();
        if (status) continue;
        return with_context(status.error(),
                            fmt::format(messages::kPartBefore, input.parts[i].name));
    }
    return {};
}

Result<std::unique_ptr<PrintSetup>> set_up_print(PrintInput input, PrintOptions options) {
    auto setup = std::make_unique<PrintSetup>();
    setup->input = std::move(input);
    setup->options = std::move(options);
    if (const Result<void> done = set_up(setup.get()); !done) return done.error();
    return setup;
}

}  // namespace openfab::pipeline

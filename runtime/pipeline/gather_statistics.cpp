// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/gather_statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "abi/halide_hooks.h"
#include "base/clock.h"
#include "runtime/pipeline/messages.h"
#include "runtime/pipeline/overlaps.h"
#include "runtime/pipeline/part_sizes.h"

namespace openfab::pipeline {

namespace {

/// Whether all slices and all of each were printed in one go, of everything in the grid.
bool is_whole(const PrintSetup& setup, const SliceCommitter& committer) {
    return committer.resumed() == 0 && committer.slices() == setup.grid.size.z &&
           !setup.input.crop_mm && !setup.input.window_mm && setup.input.beside_grid == 0;
}

}  // namespace

void gather_statistics(const PrintSetup& setup, const SlabLoop& loop,
                       const SliceCommitter& committer, double seconds_finish, PrintStatistics* s) {
    *s = {};
    s->tight = committer.totals().tight;
    if (!s->tight.empty()) {
        const Vec3i size = s->tight.size();
        s->voxels_total = int64_t{size.x} * size.y * size.z;
    }
    s->slices = committer.slices();
    s->slices_resumed = committer.resumed();
    s->voxels_solid_resumed = committer.solid_resumed();
    s->hash = committer.totals().hash;
    s->threads = setup.threads;
    s->sink_bytes = committer.bytes();
    s->warnings = setup.input.warnings;
    s->warnings.insert(s->warnings.end(), setup.warnings.begin(), setup.warnings.end());
    volume::EvaluationCounts sum(0);
    std::vector<volume::PartVoxels> voxels(setup.input.parts.size());
    double seconds_nearest = 0;
    for (const auto& e : loop.evaluators().all()) {
        const nearest::QueryCounts queries = e->query_counts();
        s->queries_asked += queries.queried;
        s->queries_skipped += queries.skipped;
        s->blocks_total += e->counts.total;
        s->blocks_filled += e->counts.filled;
        s->blocks_evaluated += e->counts.evaluated;
        for (size_t i = 0; i < voxels.size(); ++i) {
            const volume::PartVoxels& of = e->counts.by_part[i];
            voxels[i].own += of.own;
            voxels[i].empty += of.empty;
            voxels[i].unusable += of.unusable;
            s->weights_not_usable += of.unusable;
        }
        s->columns_evaluated += e->counts.columns;
        s->nearest_bytes += e->counts.nearest_bytes;
        s->slab_bytes += e->counts.slab_bytes;
        sum.seconds_bounds += e->counts.seconds_bounds;
        // What threads of a kernel's own took is not part of its caller's time.
        const double nearest = e->seconds_nearest();
        seconds_nearest += nearest;
        sum.seconds_slab += std::max(0.0, e->counts.seconds_slab - nearest);
    }
    SlabTimes times;
    Overlaps overlaps;
    std::vector<bool> covered(setup.input.parts.size());
    for (const auto& r : loop.runs().all()) {
        times.coverage += r->times.coverage;
        times.dither += r->times.dither;
        times.support += r->times.support;
        times.pack += r->times.pack;
        overlaps.add(r->overlaps());
        s->voxels_mixed += r->mixed();
        for (size_t i = 0; i < covered.size(); ++i)
            covered[i] = covered[i] || r->covered()[i];
    }
    if (is_whole(setup, committer)) {
        for (std::string& line : lost_part_warnings(setup.input.parts, covered))
            s->late_warnings.push_back(std::move(line));
    }
    for (std::string& line : overlaps.report(setup.input.parts, setup.grid))
        s->late_warnings.push_back(std::move(line));
    s->seconds_by_stage = {{"set_up", setup.seconds},
                           {"coverage", times.coverage},
                           {"volume_bounds", sum.seconds_bounds},
                           {"nearest", seconds_nearest},
                           {"slab", sum.seconds_slab},
                           {"dither", times.dither},
                           {"support", times.support},
                           {"pack", times.pack},
                           {"count", loop.seconds_count()},
                           {"encode", loop.seconds_encode()},
                           {"commit", committer.seconds_commit()},
                           {"finish", seconds_finish}};
    for (size_t i = 0; i < setup.solids.size(); ++i) {
        const solid::Dicing* dicing = setup.own_dicing(i);
        if (dicing == nullptr) continue;
        const surface::SurfaceCounts counts = dicing->counts();
        s->cache_hits += counts.cache_hits;
        s->cache_misses += counts.cache_misses;
        s->cache_evictions += counts.cache_evictions;
        s->cache_peak_bytes += counts.cache_peak_bytes;
        s->displacements_not_finite += counts.not_finite;
        s->displacements_cut += counts.cut_to_bound;
        for (std::string& line : surface::displacement_warnings(setup.input.parts[i], counts))
            s->late_warnings.push_back(std::move(line));
    }
    s->notes = empty_part_notes(setup.input.parts, voxels);
    if (const auto& asked = setup.options.slices;
        asked && asked->y != kToTheEnd && asked->y > setup.range.y)
        s->notes.push_back(
            fmt::format(messages::kSlicesPastEnd, asked->x, asked->y, setup.range.y));
    s->warnings.insert(s->warnings.end(), s->late_warnings.begin(), s->late_warnings.end());
    s->peak_rss_bytes = peak_resident_bytes();
    s->seconds_first_slice = committer.first_slice();
    s->seconds_total = process_age_seconds() - setup.options.began_seconds;
}

void fill_voxels(const PrintTotals& totals, int32_t support_code, PrintStatistics* statistics) {
    statistics->voxels_by_code = totals.voxels_by_code;
    if (support_code != 0) statistics->voxels_support = totals.voxels_by_code[support_code];
    statistics->voxels_solid = totals.voxels_solid - statistics->voxels_support;
}

}  // namespace openfab::pipeline

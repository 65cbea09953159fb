// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/supersample.h"

#include <string>
#include <thread>

#include "backends/raster/fraction_average.h"
#include "backends/raster/fraction_file.h"
#include "program/prepare.h"

namespace openfab::program {

namespace {

/// Those of a print of nothing but fractions at an N-th of the pitch.
Options fine_options(const Options& options, const pipeline::PrintInfo& coarse) {
    Options fine = options;
    const Vec3d& pitch = coarse.pitch_mm;
    const double times = options.fractions_supersample;
    fine.pitch_mm = Vec3d{pitch.x / times, pitch.y / times, pitch.z / times};
    fine.voxel_mm.reset(), fine.dpi.reset(), fine.layer_mm.reset(), fine.mesh_pitch_mm.reset();
    fine.draft = 1;
    fine.z_range_mm.reset(), fine.slices.reset();
    fine.output.clear(), fine.format.clear(), fine.stats_file.clear(), fine.previews.clear();
    fine.more_outputs.clear();
    return fine;
}

}  // namespace

Result<void> write_supersampled(const CoarsePrint& coarse, const Options& options,
                                const openfab_fablet_list& fablets,
                                const std::atomic<bool>& interrupt, Progress* progress) {
    const int32_t times = options.fractions_supersample;
    pipeline::PrintInfo info = coarse.info();
    const auto at = [&](double x, double y, double z) {
        return info.origin_mm +
               Vec3d{x * info.pitch_mm.x, y * info.pitch_mm.y, z * info.pitch_mm.z};
    };
    PrintHooks hooks{.interrupt = interrupt};
    hooks.window_mm =
        Box3d{at(0, 0, info.slice_begin), at(info.size.x, info.size.y, info.slice_end)};
    const auto threads = options.threads > 0
                             ? options.threads
                             : static_cast<int32_t>(std::thread::hardware_concurrency());
    // A slab more than threads may be in flight.
    hooks.sink_bytes_per_fraction = raster::FractionAverage::bytes_per_fraction(times, threads + 1);
    info.provenance.emplace_back("supersampling", std::to_string(times));
    raster::FractionFile file(options.fractions_file);
    raster::FractionAverage average(info, times, &file);
    hooks.fractions = &average;
    Result<PreparedPrint> ready = prepare_print(fine_options(options, info), fablets, hooks);
    if (!ready) return ready.error();
    raster::AveragedSlices slices(&average);
    pipeline::PrintStatistics statistics;
    Result<void> done = ready->print->run(
        slices, [&](const pipeline::ProgressEvent& event) { progress->update(event); }, interrupt,
        &statistics);
    progress->end();
    pipeline::PrintTotals totals = coarse.totals();
    totals.complete = totals.complete && average.complete();
    const Result<void> closed = file.finish(totals);
    return done ? closed : done;
}

}  // namespace openfab::program

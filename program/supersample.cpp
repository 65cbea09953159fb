// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/supersample.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "backends/raster/formats.h"
#include "backends/raster/fraction_average.h"
#include "backends/raster/fraction_file.h"
#include "backends/raster/grey_stack.h"
#include "base/allowance.h"
#include "base/sample_parts.h"
#include "program/messages.h"
#include "program/outputs.h"
#include "program/prepare.h"
#include "program/slab_watch.h"
#include "program/stop_reason.h"

namespace openfab::program {

namespace {

/// Returns how many of the printer's voxels a voxel is across, at least 1.
Vec3d own_voxels(const Vec3d& pitch_mm, const Vec3d& printer_pitch_mm) {
    Vec3d out;
    for (int axis = 0; axis < 3; ++axis)
        out[axis] = own_voxels_along(pitch_mm[axis], printer_pitch_mm[axis]);
    return out;
}

}  // namespace

Vec3i fraction_parts(const Options& options, const Vec3d& pitch_mm, const Vec3d& printer_pitch_mm) {
    const std::optional<int32_t> n = options.sample_centres ? 1 : options.fractions_supersample;
    if (n) return {*n, *n, *n};
    const auto part = [&](int axis) {
        return samples_along(pitch_mm[axis], printer_pitch_mm[axis]);
    };
    return {part(0), part(1), part(2)};
}

std::string describe_parts(const Vec3i& parts, const Options& options, const Vec3d& pitch_mm,
                           const Vec3d& printer_pitch_mm) {
    if (options.sample_centres || options.fractions_supersample) return {};
    const Vec3d own = own_voxels(pitch_mm, printer_pitch_mm);
    if (own.x <= parts.x && own.y <= parts.y && own.z <= parts.z) return {};
    return fmt::format(messages::kPartsLargerThanVoxels, parts.x, parts.y, parts.z, own.x, own.y,
                       own.z);
}

Options options_of_parts(const Options& options, const pipeline::PrintInfo& coarse,
                         const Vec3i& parts) {
    Options fine = options;
    const Vec3d& pitch = coarse.pitch_mm;
    fine.pitch_mm = Vec3d{pitch.x / parts.x, pitch.y / parts.y, pitch.z / parts.z};
    fine.voxel_mm.reset(), fine.dpi.reset(), fine.layer_mm.reset(), fine.mesh_pitch_mm.reset();
    fine.draft = 1;
    fine.z_range_mm.reset(), fine.slices.reset(), fine.part.reset();
    fine.output.clear(), fine.format.clear(), fine.stats_file.clear(), fine.previews.clear();
    fine.more_outputs.clear();
    return fine;
}

Box3d box_of_slices(const pipeline::PrintInfo& info) {
    const auto at = [&](double x, double y, double z) {
        return info.origin_mm +
               Vec3d{x * info.pitch_mm.x, y * info.pitch_mm.y, z * info.pitch_mm.z};
    };
    return {at(0, 0, info.slice_begin), at(info.size.x, info.size.y, info.slice_end)};
}

int64_t bytes_of_means(const Options& options, const Vec3i& parts) {
    const int32_t threads = options.threads.value_or(usable_cores());
    // A slab more than threads may be in flight.
    return raster::FractionAverage::bytes_per_fraction(parts, threads + 1);
}

namespace {

/// The print as it is recorded beside the means.
pipeline::PrintInfo info_of_means(const CoarsePrint& coarse, const Vec3i& parts) {
    pipeline::PrintInfo info = coarse.info();
    const bool alike = parts.x == parts.y && parts.x == parts.z;
    info.provenance.emplace_back(
        "supersampling",
        alike ? std::to_string(parts.x) : fmt::format("{} x {} x {}", parts.x, parts.y, parts.z));
    return info;
}

/// Prints nothing but means of the slices of `info`, which go to `to`; `layer` is called for each of them.
Result<void> print_means(const CoarsePrint& coarse, const pipeline::PrintInfo& info,
                         const Vec3i& parts, const Options& options,
                         const openfab_fablet_list& fablets, const std::atomic<bool>& interrupt,
                         pipeline::FractionSink* to, std::function<Result<void>(int32_t z)> layer,
                         Progress* progress, job::Record* record) {
    PrintHooks hooks{.interrupt = interrupt};
    hooks.window_mm = box_of_slices(info);
    hooks.sink_bytes_per_fraction = bytes_of_means(options, parts);
    pipeline::SlabClock clock;
    hooks.clock = &clock;
    raster::FractionAverage average(info, parts, to);
    hooks.fractions = &average;
    Result<PreparedPrint> ready =
        prepare_print(options_of_parts(options, info, parts), fablets, hooks);
    if (!ready) return ready.error();
    raster::AveragedSlices slices(&average, std::move(layer));
    pipeline::PrintStatistics statistics;
    Result<void> done = run_watched(
        ready->print.get(), slices,
        [&](const pipeline::ProgressEvent& event) { progress->update(event); }, interrupt, clock,
        options, progress, &statistics, record);
    progress->end();
    pipeline::PrintTotals totals = coarse.totals();
    totals.complete = totals.complete && average.complete();
    const Result<void> closed = to->finish(totals);
    return done ? closed : done;
}

}  // namespace

Result<void> write_supersampled(const CoarsePrint& coarse, const Vec3i& parts,
                                const Options& options, const openfab_fablet_list& fablets,
                                const std::atomic<bool>& interrupt, Progress* progress) {
    raster::FractionFile file(options.fractions_file);
    return print_means(coarse, info_of_means(coarse, parts), parts, options, fablets, interrupt,
                       &file, {}, progress, nullptr);
}

Vec3i grey_parts(const Options& options) {
    constexpr int32_t kUsual = 4;
    const int32_t n = options.sample_centres ? 1 : options.fractions_supersample.value_or(kUsual);
    return {n, n, n};
}

Result<void> write_grey(const CoarsePrint& coarse, const backends::Format& format,
                        const world::Printer& printer, const Options& options,
                        const openfab_fablet_list& fablets, const std::atomic<bool>& interrupt,
                        Progress* progress, job::Record* record) {
    Options alone = options;
    alone.previews.clear();
    Result<std::unique_ptr<pipeline::SliceSink>> folder = open_output(alone, printer, &interrupt);
    if (!folder) return folder.error();
    raster::GreyStack stack(std::move(*folder), raster::grey_folder_options(format, options.flip_x,
                                                                            options.grey_material));
    const Vec3i parts = grey_parts(options);
    pipeline::PrintInfo info = info_of_means(coarse, parts);
    const Result<int32_t> kept = stack.open(info, coarse.materials());
    if (!kept) return kept.error();
    if (record != nullptr) record->start(info, *kept);
    info.slice_begin += *kept;
    const auto pass = [&](int32_t z) {
        const Result<void> passed = stack.passed(z);
        if (passed && record != nullptr) record->add(1);
        return passed;
    };
    const Result<void> done = info.slice_begin == info.slice_end
                                  ? stack.finish(coarse.totals())
                                  : print_means(coarse, info, parts, options, fablets, interrupt,
                                                &stack, pass, progress, record);
    if (record != nullptr && done) record->complete(coarse.totals().hash);
    if (record != nullptr && !done) record->stop(stop_reason(done.error()));
    return done;
}

}  // namespace openfab::program

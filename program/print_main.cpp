// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/print_main.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "abi/kernel_call.h"
#include "backends/raster/fraction_file.h"
#include "base/say.h"
#include "base/text.h"
#include "base/units.h"
#include "program/build_volume.h"
#include "program/estimate.h"
#include "program/interrupt.h"
#include "program/job.h"
#include "program/options.h"
#include "program/output_check.h"
#include "program/outputs.h"
#include "program/part_sizes.h"
#include "program/progress.h"
#include "program/statistics.h"
#include "runtime/pipeline/print_job.h"

namespace openfab::program {

namespace {

bool quiet(const Options& options) {
    return options.progress == program::ProgressMode::kNone;
}

bool has_code(const openfab_kernel& kernel, openfab_isa isa) {
    const bool compiled = std::any_of(std::begin(kernel.fn), std::end(kernel.fn),
                                      [](openfab_kernel_fn fn) { return fn != nullptr; });
    return !compiled || abi::function_for(kernel.fn, isa) != nullptr;
}

bool has_code(const openfab_segments& segments, openfab_isa isa) {
    return std::all_of(segments.kernels, segments.kernels + segments.kernel_count,
                       [&](const openfab_kernel& kernel) { return has_code(kernel, isa); });
}

/// A program that was built for one instruction set may have come to a machine that lacks it.
Result<void> check_instruction_set(const openfab_fablet_list& fablets, openfab_isa isa) {
    for (int32_t k = 0; k < fablets.count; ++k) {
        const openfab_fablet& fablet = *fablets.fablets[k];
        const openfab_kernel* const kernels[] = {&fablet.surface, &fablet.surface_bounds,
                                                 &fablet.slab,    &fablet.volume_bounds,
                                                 &fablet.derived, &fablet.volume_demand};
        const bool whole =
            std::all_of(std::begin(kernels), std::end(kernels),
                        [&](const openfab_kernel* kernel) { return has_code(*kernel, isa); }) &&
            has_code(fablet.surface_segments, isa) && has_code(fablet.volume_segments, isa);
        if (whole) continue;
        Error error = user_error(fmt::format(
            "fablet `{}` was compiled for other instruction sets than this machine's, {}",
            fablet.name, isa == OPENFAB_ISA_AVX2 ? "AVX2" : "SSE4.1"));
        error.help = "`openflc build --target both` makes a program for every machine";
        return error;
    }
    return {};
}

void show_summary(const pipeline::PrintStatistics& statistics, const pipeline::PrintInfo& info,
                  const Options& options) {
    const double ml = info.pitch_mm.x * info.pitch_mm.y * info.pitch_mm.z * 1e-3;
    std::string materials;
    for (size_t m = 0; m < info.materials.size() && m + 1 < statistics.voxels_by_code.size(); ++m) {
        materials += fmt::format(", {} {:.2f} ml", printable(info.materials[m].name),
                                 static_cast<double>(statistics.voxels_by_code[m + 1]) * ml);
    }
    const double rate = statistics.seconds_total > 0
                            ? static_cast<double>(pipeline::voxels_printed(statistics)) * 1e-6 /
                                  statistics.seconds_total
                            : 0;
    for (const std::string& overlap : statistics.overlaps)
        warn(overlap);
    const std::string resumed = statistics.slices_resumed > 0
                                    ? fmt::format(" ({} resumed)", statistics.slices_resumed)
                                    : "";
    const std::string& output = options.output.empty() ? info.title : options.output;
    say(fmt::format("{}: {} slices{} in {}, {:.1f} M voxels/s{}\n",
                    output == "-" ? "standard output" : printable(output), statistics.slices,
                    resumed, format_seconds(statistics.seconds_total), rate, materials));
}

/// Adds how to resume a print that ended early for a temporary reason.
Error add_resume_hint(Error error, const Options& options, const std::string& format) {
    const bool passes = error.code == ErrorCode::kOutside || error.code == ErrorCode::kInterrupted;
    if (passes && can_be_resumed(options, format))
        error.help += std::string(error.help.empty() ? "" : "; ") +
                      "the same command with `--resume` continues from there";
    return error;
}

/// Runs the print. Statistics and pictures are written even if it ends early.
Result<void> run(pipeline::PrintJob* print, const Options& options, const std::string& format,
                 const world::Printer& printer, const std::string& sizes,
                 const std::atomic<bool>& interrupt, program::Progress& progress) {
    const DeferredInterrupt deferred;
    Result<std::unique_ptr<pipeline::SliceSink>> sink = open_output(options, printer);
    if (!sink) return sink.error();
    pipeline::PrintStatistics statistics;
    Result<void> done = print->run(
        **sink, [&](const pipeline::ProgressEvent& event) { progress.update(event); }, interrupt,
        &statistics);
    progress.end();
    statistics.layer_time_s = printer.layer_time_s;
    if (const std::string nothing = nothing_printed(statistics, sizes); !nothing.empty()) {
        statistics.warnings.push_back(nothing);
        if (!quiet(options)) warn(nothing);
    }
    Result<void> written;
    if (!options.stats_file.empty()) {
        written = program::write_statistics(options.stats_file, statistics, print->info());
    }
    if (!done) return add_resume_hint(done.error(), options, format);
    if (!quiet(options)) show_summary(statistics, print->info(), options);
    return written;
}

Result<void> run_command_line(int argc, char** argv, const openfab_fablet_list& fablets) {
    const std::string path = argc > 0 ? argv[0] : "print";
    Result<Options> options = parse_options(argc, argv, path.substr(path.find_last_of('/') + 1));
    if (!options) return options.error();
    if (options->help) {
        show(options->text);
        return {};
    }
    return run_print(*options, fablets,
                     install_interrupt(exit_code(ErrorCode::kInterrupted),
                                       "error: interrupted before the first slice\n"));
}

}  // namespace

pipeline::PrintOptions pipeline_options(const Options& options, const std::string& format,
                                        size_t materials, const std::atomic<bool>& interrupt) {
    pipeline::PrintOptions result;
    result.interrupt = &interrupt;
    result.reserved_bytes = preview_bytes(options) + queue_bytes(options);
    result.memory_bytes = options.memory_bytes - result.reserved_bytes;
    result.threads = options.threads;
    // A mesh of dithered voxels would consist of specks, which printers of meshes cannot print.
    if (is_mesh_format(format)) result.dither = "majority";
    if (!options.dither.empty()) result.dither = options.dither;
    result.seed = options.seed;
    result.z_range_mm = options.z_range_mm;
    result.slices = options.slices;
    result.culling = options.culling;
    result.slabs_in_flight = options.slabs_in_flight;
    result.isa = abi::best_isa(options.isa);
    result.sink_bytes_per_column = output_bytes_per_column(format, materials);
    return result;
}

Result<void> run_print(const Options& options, const openfab_fablet_list& fablets,
                       const std::atomic<bool>& interrupt,
                       std::vector<std::filesystem::path>* files) {
    if (Result<void> runs = check_instruction_set(fablets, abi::best_isa(options.isa)); !runs)
        return runs.error();
    Result<Job> job = load_job(options, fablets);
    if (!job) return job.error();
    if (files != nullptr) *files = job->files;
    // Reports a wrong output name before the work, not after.
    Result<std::string> format = choose_format(options, job->printer);
    if (!format) return format.error();
    if (Result<void> apart = check_outputs(options, *format, job->input.materials, job->inputs);
        !apart)
        return apart.error();
    for (std::string& thin : thin_part_warnings(job->input.parts, job->input.pitch_mm))
        job->input.warnings.push_back(std::move(thin));
    if (!quiet(options)) {
        for (const std::string& text : job->notes)
            note(text);
        for (const std::string& warning : job->input.warnings)
            warn(warning);
    }
    program::Progress progress(options.progress, stderr);
    pipeline::PrintOptions pipeline =
        pipeline_options(options, *format, job->input.materials.size(), interrupt);
    // An estimate evaluates some voxels only; their printf lines are meaningless.
    if (!options.estimate && !options.dry_run)
        pipeline.print_line = [&progress](const std::string& line) { progress.print_line(line); };
    std::optional<raster::FractionFile> fractions;
    if (!options.fractions_file.empty() && !options.estimate && !options.dry_run)
        pipeline.fractions = &fractions.emplace(options.fractions_file);
    Result<std::unique_ptr<pipeline::PrintJob>> print =
        pipeline::PrintJob::create(job->input, pipeline);
    if (!print) return print.error();
    for (const std::string& warning : (*print)->warnings()) {
        if (!quiet(options)) warn(warning);
    }
    const pipeline::PrintInfo info = (*print)->info();
    if (Result<void> fits = check_build_volume(info, job->printer, job->input.parts, job->tray);
        !fits)
        return fits.error();
    if (options.estimate || options.dry_run) {
        Result<Estimate> estimate = make_estimate(std::move(*print), job->input, pipeline, options,
                                                  job->printer, interrupt);
        if (!estimate) return estimate.error();
        show_estimate(*estimate, info);
        if (options.stats_file.empty()) return {};
        return write_estimate(options.stats_file, *estimate, info);
    }
    const std::string sizes = part_sizes(job->input.parts, job->input.pitch_mm);
    job->input = {};
    return run(print->get(), options, *format, job->printer, sizes, interrupt, progress);
}

int finish(const Result<void>& done) {
    const Result<void> written = done ? written_out() : done;
    return written ? 0 : say_error(written.error());
}

int print_main(int argc, char** argv, const openfab_fablet_list& fablets) {
    prepare_streams();
    return finish(run_command_line(argc, argv, fablets));
}

}  // namespace openfab::program

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/print_main.h"

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "backends/job/recorded_sink.h"
#include "backends/raster/fraction_file.h"
#include "base/clean_exit.h"
#include "base/near_miss.h"
#include "base/say.h"
#include "base/text.h"
#include "base/units.h"
#include "program/cost.h"
#include "program/estimate.h"
#include "program/extents.h"
#include "program/interrupt.h"
#include "program/messages.h"
#include "program/options.h"
#include "program/outputs.h"
#include "program/prepare.h"
#include "program/print_record.h"
#include "program/probe.h"
#include "program/process.h"
#include "program/progress.h"
#include "program/slab_watch.h"
#include "program/statistics.h"
#include "program/stop_reason.h"
#include "program/supersample.h"
#include "runtime/part/settings.h"
#include "runtime/pipeline/messages.h"
#include "runtime/pipeline/print_job.h"
#include "runtime/segments/printf_log.h"
#include "texture/cache.h"

namespace openfab::program {

namespace {

void show_summary(const pipeline::PrintStatistics& statistics, const pipeline::PrintInfo& info,
                  const Options& options) {
    const double ml = info.pitch_mm.x * info.pitch_mm.y * info.pitch_mm.z * 1e-3;
    std::string materials;
    for (size_t m = 0; m < info.materials.size() && m + 1 < statistics.voxels_by_code.size(); ++m) {
        materials += fmt::format(messages::kSummaryMaterial, printable(info.materials[m].name),
                                 static_cast<double>(statistics.voxels_by_code[m + 1]) * ml);
    }
    const double rate = statistics.seconds_total > 0
                            ? static_cast<double>(pipeline::voxels_printed(statistics)) * 1e-6 /
                                  statistics.seconds_total
                            : 0;
    const std::string resumed =
        statistics.slices_resumed > 0
            ? fmt::format(messages::kSummaryResumed, statistics.slices_resumed)
            : "";
    const std::string& output = options.output.empty() ? info.title : options.output;
    say(fmt::format(
        messages::kSummary, output == "-" ? messages::kStandardOutput : printable(output),
        statistics.slices, resumed, format_seconds(statistics.seconds_total), rate, materials));
}

/// Adds how to resume a print of which slices are there, and which ended early for a temporary reason. For other commands
/// it is no advice: they have no `--resume`, and what was printed for them is gone.
Error add_resume_hint(Error error, const Options& options, const backends::Format* format) {
    const bool passes = error.code == ErrorCode::kOutside || error.code == ErrorCode::kInterrupted;
    if (passes && !has_starter() && format != nullptr && can_be_resumed(options, *format) &&
        options.fractions_file.empty())
        error.help += std::string(error.help.empty() ? "" : "; ") + messages::kResumeHelp;
    return error;
}

/// Whether what is asked of grey pictures is about some that are written, of a material of the print.
Result<void> check_grey(const Options& options, bool grey, const pipeline::PrintInput& input) {
    const std::string& name = options.grey_material;
    if (!grey) {
        if (!name.empty()) return usage_error(messages::kGreyMaterialWithoutPictures);
        if (options.fractions_supersample.value_or(1) > 1 && options.fractions_file.empty())
            return usage_error(messages::kSupersampleWithoutArray);
        return {};
    }
    if (!options.fractions_file.empty()) return usage_error(messages::kGreyAndFractions);
    if (name.empty() || process::material_code(named_materials(input), name) != 0) return {};
    std::vector<std::string> names;
    for (const pipeline::SliceMaterial& material : input.materials)
        names.push_back(material.name);
    return user_error(
        fmt::format(messages::kGreyOfNoMaterial, printable(name), suggest(name, names)));
}

/// Runs the print. Statistics and pictures are written even if it ends early.
Result<void> run(pipeline::PrintJob* print, const Options& options, const backends::Format* format,
                 const world::Printer& printer, const std::string& sizes,
                 const std::atomic<bool>& interrupt, const pipeline::SlabClock& clock,
                 program::Progress& progress, job::Record* record,
                 backends::MixtureInlet* mixtures) {
    DeferredInterrupt deferred;
    if (options.resume) deferred.say(messages::kInterruptedBeforeNewSlices);
    Result<std::unique_ptr<pipeline::SliceSink>> sink =
        open_output(options, printer, &interrupt, mixtures);
    if (!sink) return sink.error();
    if (format != nullptr && format->note != nullptr) {
        if (const std::string text = format->note(print->info()); !text.empty())
            progress.note(text);
    }
    if (record != nullptr) *sink = std::make_unique<job::RecordedSink>(std::move(*sink), record);
    pipeline::PrintStatistics statistics;
    bool any = false;
    const auto update = [&](const pipeline::ProgressEvent& event) {
        deferred.count(event.slices_done, event.slices_total);
        if (!std::exchange(any, true)) {
            const bool kept = format == nullptr || format->ended_early.empty();
            const Error early{ErrorCode::kInterrupted,
                              kept ? std::string(pipeline::messages::kInterruptedAfter)
                                   : std::string(format->ended_early),
                              "",
                              {}};
            deferred.say(progress.error_text(add_resume_hint(early, options, format), {}));
        }
        progress.update(event);
    };
    Result<void> done = run_watched(print, **sink, update, interrupt, clock, options, &progress,
                                    &statistics, record);
    if (!done && record != nullptr) record->stop(stop_reason(done.error()));
    progress.end();
    add_cost(printer, print->info(), &statistics);
    if (const std::string nothing = nothing_printed(statistics, sizes); !nothing.empty()) {
        statistics.warnings.push_back(nothing);
        progress.warn(nothing);
    }
    Result<void> written;
    if (!options.stats_file.empty()) {
        written = program::write_statistics(options.stats_file, statistics, print->info());
    }
    if (!done) return statistics.slices > 0 ? add_resume_hint(done.error(), options, format) : done;
    for (const std::string& warning : statistics.late_warnings)
        progress.warn(warning);
    // Of a print of nothing there is a warning.
    for (const std::string& note : statistics.notes)
        if (statistics.voxels_solid > 0) progress.note(note);
    if (const std::string lost = lost_mixtures(statistics, options.dither, format, printer);
        !lost.empty())
        progress.warn(lost);
    if (const std::string left =
            left_out_of_grey(statistics, print->info(), options.grey_material, format);
        !left.empty())
        progress.warn(left);
    if (progress.sums_up()) show_summary(statistics, print->info(), options);
    return written;
}

/// A print without its record is as good; who looks for one should know why there is none.
void note_trouble(const job::Record* record, program::Progress* progress) {
    if (record != nullptr && !record->trouble().empty())
        progress->note(fmt::format(messages::kNoRecordOfPrint, record->trouble()));
}

/// A file that is asked for, and that only a print makes; the output says where the print would go.
void note_unwritten(const Options& options, program::Progress* progress) {
    std::vector<std::string> files;
    for (const preview::PreviewSpec& picture : options.previews)
        files.push_back(picture.file);
    if (!options.fractions_file.empty()) files.push_back(options.fractions_file);
    const char* why = options.dry_run ? "--dry-run" : "--estimate";
    for (const std::string& file : files)
        progress->note(fmt::format(messages::kNotWritten, why, file));
}

}  // namespace

Result<void> run_print(const Options& options, const openfab_fablet_list& fablets,
                       const std::atomic<bool>& interrupt,
                       std::vector<std::filesystem::path>* files, double began_seconds) {
    if (!options.extents_file.empty()) return write_extents(options, fablets);
    if (options.probe_mm) return run_probe(options, fablets, interrupt);
    program::Progress progress(options.progress, stderr);
    PrintHooks hooks{.interrupt = interrupt};
    hooks.began_seconds = began_seconds;
    pipeline::SlabClock clock;
    hooks.clock = &clock;
    const bool prints = !options.estimate && !options.dry_run;
    std::optional<raster::FractionFile> fractions;
    CoarsePrint coarse;
    Vec3i parts{1, 1, 1};
    bool grey = false;
    hooks.loaded = [&](const Job& job) {
        if (files != nullptr) *files = job.files;
        for (const std::string& text : job.notes)
            progress.note(text);
        for (const std::string& warning : job.input.warnings)
            progress.warn(warning);
        const Result<const backends::Format*> format = choose_format(options, job.printer);
        grey = prints && format && *format != nullptr && (*format)->of_fractions;
        if (grey) hooks.fractions = &coarse;
        if (options.fractions_file.empty() || !prints || grey) return;
        const Vec3d &pitch = job.input.pitch_mm, &own = job.printer.pitch_mm;
        parts = fraction_parts(options, pitch, own);
        if (parts == Vec3i{1, 1, 1}) {
            hooks.fractions = &fractions.emplace(options.fractions_file);
            return;
        }
        hooks.fractions = &coarse;
        if (const std::string note = describe_parts(parts, options, pitch, own); !note.empty())
            progress.note(note);
    };
    // An estimate evaluates some voxels only; their printf lines are meaningless.
    if (prints)
        hooks.print_line = [&progress](const std::string& line) { progress.print_line(line); };
    Result<PreparedPrint> ready = prepare_print(options, fablets, hooks);
    if (!ready) return ready.error();
    for (const std::string& warning : ready->print->warnings())
        progress.warn(warning);
    Job& job = ready->job;
    if (prints) {
        if (const Result<void> fine = check_grey(options, grey, job.input); !fine)
            return fine.error();
    } else {
        const pipeline::PrintInfo info = ready->print->info();
        Result<Estimate> estimate =
            make_estimate(std::move(ready->print), job.input, ready->options, options,
                          ready->format, job.printer, interrupt);
        if (!estimate) return estimate.error();
        note_unwritten(options, &progress);
        show_estimate(*estimate, info);
        if (options.stats_file.empty()) return {};
        return write_estimate(options.stats_file, *estimate, info);
    }
    const std::unique_ptr<job::Record> record = make_record(options, job, ready->format);
    const std::string sizes = ready->print->part_sizes();
    job.input = {};
    Options of_codes = options;
    // Grey pictures have a print of their own.
    if (grey) of_codes.output.clear(), of_codes.format.clear();
    const Result<void> done =
        run(ready->print.get(), of_codes, ready->format, job.printer, sizes, interrupt, clock,
            progress, grey ? nullptr : record.get(), ready->mixtures.get());
    note_trouble(record.get(), &progress);
    if (!done || hooks.fractions != &coarse) return done;
    ready->print.reset();  // and its memory
    if (grey) {
        const Result<void> written = write_grey(coarse, *ready->format, job.printer, options,
                                                fablets, interrupt, &progress, record.get());
        note_trouble(record.get(), &progress);
        return written ? written : add_resume_hint(written.error(), options, ready->format);
    }
    return write_supersampled(coarse, parts, options, fablets, interrupt, &progress);
}

void keep_print_lines(int64_t most) {
    segments::PrintfLog::keep_lines(most);
}

int finish(const Result<void>& done, ProgressMode progress) {
    const Result<void> written = done ? written_out() : done;
    if (written) return 0;
    const Error& error = written.error();
    Progress(progress, stderr).fail(error, part::setting_of(error));
    return exit_code(error.code);
}

int print_main(int argc, char** argv, const openfab_fablet_list& fablets) {
    prepare_streams();
    const std::string path = argc > 0 ? argv[0] : "print";
    const Result<Options> options =
        parse_options(argc, argv, path.substr(path.find_last_of('/') + 1));
    if (!options) return finish(options.error());
    if (options->help) {
        show(options->text);
        return finish({});
    }
    if (options->no_cache) texture::keep_no_textures();
    const std::atomic<bool>& interrupt =
        install_interrupt(exit_code(ErrorCode::kInterrupted), messages::kInterruptedBeforeSlices);
    return finish(run_print(*options, fablets, interrupt), options->progress);
}

}  // namespace openfab::program

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/estimate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "backends/common/output_file.h"
#include "backends/common/tee_sink.h"
#include "base/deadline.h"
#include "base/json_text.h"
#include "base/own_folder.h"
#include "base/say.h"
#include "base/text.h"
#include "base/units.h"
#include "program/cost.h"
#include "program/messages.h"
#include "program/outputs.h"
#include "program/statistics.h"

namespace openfab::program {

namespace {

/// A coarse print: its voxels at most, and the seconds that its set-up and then its slices are given.
struct CoarseTrial {
    double voxels, set_up_seconds, seconds;
};
/// Of coarse prints; with less than kFewVoxels materials are known roughly.
constexpr double kMostVoxels = 3e6, kFewVoxels = 1e6, kLeastVoxels = 1e5;
/// Seconds of the processor that a coarse print shall take, as far as the estimate of the print's own tells.
constexpr double kCoarseSeconds = 0.5;
/// Seconds for slabs at the print's own pitch.
constexpr double kTimeSeconds = 2.0;

/// Returns coarse prints to try, one after the other. Voxels shrink with the cube of the pitch, what
/// is diced far less: a patch is never less than a triangle of its mesh.
std::array<CoarseTrial, 2> coarse_prints(const Estimate& e) {
    const double share = kCoarseSeconds / std::max(e.time.processor_seconds, kCoarseSeconds);
    const double diced = e.time.dicing_seconds / std::max(e.time.processor_seconds, kCoarseSeconds);
    const double voxels = static_cast<double>(e.set_up.voxels_total) * std::pow(share, 1 + diced);
    return {{{std::clamp(voxels, kLeastVoxels, kMostVoxels), 1.0, 3 * kCoarseSeconds},
             {kLeastVoxels, 1.0, 2 * kCoarseSeconds}}};
}

/// Prints with that many voxels; returns false if it takes too long or too much memory.
Result<bool> print_coarse(const CoarseTrial& coarse, pipeline::PrintInput input,
                          pipeline::PrintOptions pipeline, const pipeline::PrintInfo& info,
                          const std::atomic<bool>& interrupt, Estimate* out) {
    const double voxels = static_cast<double>(out->set_up.voxels_total);
    const double coarser = std::max(1.0, std::cbrt(voxels / coarse.voxels));
    pipeline.slices.reset();
    if (info.slice_end - info.slice_begin < info.size.z) {
        pipeline.z_range_mm =
            Vec2<double>{info.slice_begin * info.pitch_mm.z, info.slice_end * info.pitch_mm.z};
    }
    input.pitch_mm = input.pitch_mm * coarser;
    Deadline deadline(interrupt);
    pipeline.interrupt = &deadline.passed();
    deadline.start(coarse.set_up_seconds);
    Result<std::unique_ptr<pipeline::PrintJob>> print =
        pipeline::PrintJob::create(std::move(input), std::move(pipeline));
    // Memory that the print at its own pitch gave back may still count as taken.
    const auto is_too_much = [&](const Error& error) {
        return error.code == ErrorCode::kUserInput ||
               (error.code == ErrorCode::kInterrupted && !interrupt.load());
    };
    if (!print && is_too_much(print.error())) return false;
    if (!print) return print.error();
    deadline.start(coarse.seconds);
    backends::NullSink sink;
    pipeline::PrintStatistics sample;
    const Result<void> done = (*print)->run(sink, nullptr, deadline.passed(), &sample);
    if (!done && done.error().code == ErrorCode::kInterrupted && !interrupt.load()) return false;
    if (!done) return done.error();
    const Vec3d& pitch = (*print)->info().pitch_mm;
    out->sample_voxel_ml = pitch.x * pitch.y * pitch.z * 1e-3;
    out->sample = std::move(sample);
    return true;
}

/// Samples the time with an output like the print's own, in a temporary folder. A receiver gets what a
/// file does.
Result<pipeline::TimeSample> sample_time(pipeline::PrintJob* print, const Options& options,
                                         const backends::Format* format,
                                         const world::Printer& printer,
                                         const std::atomic<bool>& interrupt) {
    // Slices alone are better than nothing.
    const Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create();
    if (!folder || format == nullptr) return print->sample_time(kTimeSeconds, nullptr, interrupt);
    Options like = options;
    like.format = format->name;
    like.output = output_in((*folder)->path(), *format);
    like.previews.clear();
    like.resume = false;
    Result<std::unique_ptr<pipeline::SliceSink>> sink = open_output(like, printer);
    if (!sink) return sink.error();
    return print->sample_time(kTimeSeconds, sink->get(), interrupt);
}

/// "about 2 h", or as much as is known about it.
std::string describe_time(const Estimate& e) {
    const std::string time = format_seconds(e.seconds());
    if (e.time.places > 0 && e.time.share == 0) return messages::kMoreThan + time;
    if (e.time.places == 0 || e.time.share == 1) return "about " + time;
    return fmt::format(messages::kRoughly, time, 100 * e.time.share);
}

/// Whether slices are ready when the printer needs them.
std::string describe_pace(const Estimate& e) {
    if (e.time.places == 0) return "";
    const std::string slice = format_seconds(e.slowest_slice_seconds());
    const std::string layer = format_seconds(e.print_seconds / e.slices);
    return e.keeps_up() ? fmt::format(messages::kKeepsUp, slice, layer)
                        : fmt::format(messages::kDoesNotKeepUp, slice, layer);
}

/// ", 3.40 EUR"
std::string describe_money(const Estimate& e, size_t code) {
    if (!e.cost) return "";
    const pipeline::MaterialCost& line = e.cost->materials[code - 1];
    std::string text;
    if (line.waste_ml > 0) text += fmt::format(messages::kMoreOfWaste, line.waste_ml);
    return text + (line.money ? fmt::format(messages::kPriceOfMaterial, *line.money,
                                            printable(e.cost->currency))
                              : messages::kPriceNotKnown);
}

std::string describe_cost(const pipeline::PrintCost& cost) {
    std::string unknown;
    for (const pipeline::MaterialCost& line : cost.materials) {
        if (!line.money && line.ml > 0)
            unknown += (unknown.empty() ? "" : ", ") + printable(line.name);
    }
    return fmt::format(messages::kCost, cost.money, printable(cost.currency),
                       unknown.empty() ? "" : " without " + unknown, cost.passes,
                       cost.seconds > 0 ? ", " + format_seconds(cost.seconds) : "");
}

}  // namespace

Result<Estimate> make_estimate(std::unique_ptr<pipeline::PrintJob> print,
                               const pipeline::PrintInput& input,
                               const pipeline::PrintOptions& pipeline, const Options& options,
                               const backends::Format* format, const world::Printer& printer,
                               const std::atomic<bool>& interrupt) {
    const pipeline::PrintInfo info = print->info();
    Estimate out;
    out.set_up = print->estimate();
    out.memory_bytes = out.set_up.memory_bytes + preview_bytes(options);
    out.slices = info.slice_end - info.slice_begin;
    out.printer_pitch_mm = printer.pitch_mm;
    out.print_seconds = print_seconds(printer, info, out.slices);
    for (const auto& [figure, why] : printer.unknown) {
        if (figure == "layer_time_s") out.no_print_seconds = why;
    }
    out.warnings = input.warnings;
    out.warnings.insert(out.warnings.end(), print->warnings().begin(), print->warnings().end());
    if (!options.estimate) return out;
    const Result<pipeline::TimeSample> time =
        sample_time(print.get(), options, format, printer, interrupt);
    if (!time) return time.error();
    out.time = *time;
    print.reset();
    for (const CoarseTrial& coarse : coarse_prints(out)) {
        out.few_voxels = coarse.voxels < kFewVoxels;
        const Result<bool> done = print_coarse(coarse, input, pipeline, info, interrupt, &out);
        if (!done) return done.error();
        if (*done) break;
    }
    out.warnings.insert(out.warnings.end(), out.sample.late_warnings.begin(),
                        out.sample.late_warnings.end());
    out.cost = print_cost(printer, info, out.slices,
                          ml_by_code(out.sample.voxels_by_code, out.sample_voxel_ml));
    return out;
}

void show_estimate(const Estimate& e, const pipeline::PrintInfo& info) {
    const Vec3i& size = e.set_up.size;
    say(fmt::format(messages::kEstimateVoxels, size.x, size.y, size.z,
                    static_cast<double>(e.set_up.voxels_total) * 1e-6, size.x * info.pitch_mm.x,
                    size.y * info.pitch_mm.y, size.z * info.pitch_mm.z));
    say(fmt::format(messages::kEstimateMemory, format_bytes(e.memory_bytes), describe_time(e)));
    if (e.print_seconds > 0) {
        say(fmt::format(messages::kEstimateSlices, e.slices, format_seconds(e.print_seconds),
                        printable(info.printer), describe_pace(e)));
    } else if (!e.no_print_seconds.empty()) {
        say(fmt::format(messages::kPrinterTimeUnknown, e.slices, printable(info.printer),
                        printable(e.no_print_seconds)));
    }
    if (e.time.places > 0 && e.sample.voxels_by_code.empty()) say(messages::kMaterialsNotKnown);
    for (size_t code = 1; code < e.sample.voxels_by_code.size(); ++code) {
        const pipeline::SliceMaterial& material = info.materials[code - 1];
        const double ml = static_cast<double>(e.sample.voxels_by_code[code]) * e.sample_voxel_ml;
        say(fmt::format(messages::kEstimateMaterial, printable(material.name),
                        e.few_voxels ? "roughly" : "about", ml, ml * material.density_g_cm3,
                        describe_money(e, code)));
    }
    if (e.cost) say(describe_cost(*e.cost));
    for (const std::string& warning : e.sample.late_warnings)
        warn(warning);
    for (const std::string& note : e.sample.notes)
        openfab::note(note);
}

std::string estimate_json(const Estimate& e, const pipeline::PrintInfo& info) {
    JsonText w(JsonText::Layout::kIndented);
    const auto number = [&](std::string_view key, double value) {
        constexpr int kDecimals = 6;
        w.key(key).fraction(value, kDecimals);
    };
    w.begin_object();
    w.member("title", info.title).member("printer", info.printer).member("estimate", true);
    write_grid(e.set_up.size, info, &w);
    w.key("printer_pitch_mm").begin_array();
    for (int a = 0; a < 3; ++a)
        w.fraction(e.printer_pitch_mm[a]);
    w.end_array();
    w.member("voxels_total", e.set_up.voxels_total).member("slices", e.slices);
    w.member("memory_bytes", e.memory_bytes);
    number("seconds_total", e.seconds());
    if (e.time.places > 0) number("processor_seconds", e.time.processor_seconds);
    if (e.print_seconds > 0) number("print_seconds", e.print_seconds);
    if (e.print_seconds > 0 && e.time.places > 0) {
        number("slowest_slice_seconds", e.slowest_slice_seconds());
        w.member("keeps_up", e.keeps_up());
    }
    for (const bool mass : {false, true}) {
        w.key(mass ? "g_by_material" : "ml_by_material").begin_object();
        for (size_t code = 1; code < e.sample.voxels_by_code.size(); ++code) {
            const pipeline::SliceMaterial& material = info.materials[code - 1];
            number(material.name, static_cast<double>(e.sample.voxels_by_code[code]) *
                                      e.sample_voxel_ml * (mass ? material.density_g_cm3 : 1));
        }
        w.end_object();
    }
    if (e.cost) write_cost(*e.cost, &w);
    w.key("warnings").begin_array();
    for (const std::string& warning : e.warnings)
        w.value(warning);
    w.end_array().key("notes").begin_array();
    for (const std::string& note : e.sample.notes)
        w.value(note);
    w.end_array().end_object();
    return w.take() + "\n";
}

Result<void> write_estimate(const std::string& file, const Estimate& e,
                            const pipeline::PrintInfo& info) {
    return backends::write_whole_file(file, estimate_json(e, info));
}

}  // namespace openfab::program

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// A profile as a table for people, and as JSON.

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "base/json_text.h"
#include "base/text.h"
#include "base/units.h"
#include "tools/tuner/profile.h"

namespace openfab::tuner {

namespace {

double percent(double part, double whole) {
    return whole > 0 ? 100 * part / whole : 0;
}

std::string size_or_dash(int64_t bytes) {
    return bytes > 0 ? format_bytes(bytes) : "-";
}

/// Bytes as a share of what memory gives one thread while all work, for what it took.
std::string memory_share(const StageCost& stage, const Machine& machine) {
    const auto bytes = static_cast<double>(stage.bytes_read + stage.bytes_written);
    // What Funcs store stays in caches, or in registers.
    if (bytes == 0 || stage.seconds <= 0 || stage.by_thread.empty()) return "-";
    return fmt::format("{:.1f} %", percent(bytes / stage.seconds, machine.bandwidth_each()));
}

std::string peak_share(const StageCost& stage, const Machine& machine) {
    if (stage.operations == 0 || stage.seconds <= 0) return "-";
    return fmt::format("{:.1f} %",
                       percent(stage.operations / stage.seconds, machine.operations_each()));
}

std::string rate(const StageCost& stage) {
    if (stage.voxels == 0 || stage.seconds <= 0) return "-";
    return fmt::format("{:.1f}", static_cast<double>(stage.voxels) / stage.seconds * 1e-6);
}

std::string row(const StageCost& stage, const Profile& profile, double whole) {
    std::string out = fmt::format(
        "{:<16} {:>8.3f} s {:>6.1f} % {:>9.1f} {:>9} {:>9} {:>9} {:>8} {:>8}  {}", stage.name,
        stage.seconds, percent(stage.seconds, whole), static_cast<double>(stage.voxels) * 1e-6,
        rate(stage), size_or_dash(stage.bytes_read), size_or_dash(stage.bytes_written),
        memory_share(stage, profile.machine), peak_share(stage, profile.machine), stage.bound);
    return out + '\n';
}

constexpr const char* kHead =
    "                    seconds  share    M voxel M voxel/s      read   written   memory     peak "
    " "
    "bound by\n";

void write_stage(JsonText* out, const StageCost& stage, double whole) {
    out->begin_object();
    out->member("name", stage.name).member("seconds", stage.seconds);
    out->member("share", whole > 0 ? stage.seconds / whole : 0);
    if (!stage.by_thread.empty()) {
        out->key("seconds_by_thread").begin_array();
        for (const double seconds : stage.by_thread)
            out->value(seconds);
        out->end_array();
    }
    out->member("voxels", stage.voxels);
    out->member("bytes_read", stage.bytes_read).member("bytes_written", stage.bytes_written);
    if (stage.operations > 0) out->member("operations", stage.operations);
    out->member("bound", stage.bound).end_object();
}

double sum(const std::vector<StageCost>& stages) {
    return std::accumulate(stages.begin(), stages.end(), 0.0,
                           [](double s, const StageCost& stage) { return s + stage.seconds; });
}

}  // namespace

std::string profile_table(const Profile& p) {
    const Machine& m = p.machine;
    std::string out = fmt::format(
        "{}: {} of {} slabs, {:.1f} M voxels in {:.2f} s with {} thread{}: {:.1f} M voxel/s\n",
        printable(p.title), p.slabs, p.slabs_total, static_cast<double>(p.voxels) * 1e-6, p.seconds,
        m.threads, m.threads == 1 ? "" : "s",
        p.seconds > 0 ? static_cast<double>(p.voxels) / p.seconds * 1e-6 : 0);
    out += fmt::format("set-up {:.2f} s; processor {:.2f} s of {:.2f} thread-seconds\n",
                       p.set_up_seconds, p.processor_seconds, p.thread_seconds());
    out += fmt::format(
        "memory {:.1f} GB/s (one thread {:.1f}), peak {:.0f} G operations/s (one thread "
        "{:.0f})\n\n",
        m.bandwidth_all * 1e-9, m.bandwidth_one * 1e-9, m.operations_all * 1e-9,
        m.operations_one * 1e-9);
    out += kHead;
    for (const StageCost& stage : p.stages) {
        if (stage.seconds > 0) out += row(stage, p, p.thread_seconds());
    }
    out += fmt::format("{:<16} {:>8.3f} s {:>6.1f} %  threads x time\n\n", "sum", sum(p.stages),
                       percent(sum(p.stages), p.thread_seconds()));
    if (!p.funcs.empty()) {
        out += fmt::format("the slab kernel by Funcs, from {} samples; shares are of the kernel\n",
                           p.samples);
        out += kHead;
        const double slab = sum(p.funcs);
        for (const StageCost& func : p.funcs)
            out += row(func, p, slab);
        out += '\n';
    }
    if (m.threads > 1) {
        out += fmt::format("threads     ");
        for (int32_t t = 0; t < m.threads; ++t)
            out += fmt::format(" {:>8}", t + 1);
        out += '\n';
        for (const StageCost& stage : p.stages) {
            if (stage.seconds <= 0 || stage.by_thread.empty()) continue;
            out += fmt::format("{:<12}", stage.name);
            for (const double seconds : stage.by_thread)
                out += fmt::format(" {:>6.2f} s", seconds);
            out += '\n';
        }
        out +=
            fmt::format("\none thread alone: {:.2f} s of {:.2f} s, {:.1f} % of the print{}\n",
                        p.alone_seconds, p.print_seconds, percent(p.alone_seconds, p.print_seconds),
                        p.whole ? "" : ", scaled from these slabs");
    }
    return out;
}

std::string profile_json(const Profile& p) {
    JsonText out;
    out.begin_object().member("title", p.title).member("whole", p.whole);
    out.member("slabs", p.slabs).member("slabs_total", p.slabs_total).member("voxels", p.voxels);
    out.member("threads", p.machine.threads).member("set_up_seconds", p.set_up_seconds);
    out.member("seconds", p.seconds).member("processor_seconds", p.processor_seconds);
    out.member("thread_seconds", p.thread_seconds());
    out.key("machine").begin_object();
    out.member("bytes_per_second", p.machine.bandwidth_all);
    out.member("bytes_per_second_one_thread", p.machine.bandwidth_one);
    out.member("operations_per_second", p.machine.operations_all);
    out.member("operations_per_second_one_thread", p.machine.operations_one).end_object();
    out.key("stages").begin_array();
    for (const StageCost& stage : p.stages)
        write_stage(&out, stage, p.thread_seconds());
    out.end_array().key("slab_funcs").begin_array();
    for (const StageCost& func : p.funcs)
        write_stage(&out, func, sum(p.funcs));
    out.end_array();
    out.member("samples", p.samples);
    out.member("alone_seconds", p.alone_seconds).member("print_seconds", p.print_seconds);
    return out.end_object().take() + "\n";
}

}  // namespace openfab::tuner

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/statistics.h"

#include <fmt/format.h>

#include "backends/common/output_file.h"
#include "base/json_text.h"
#include "program/messages.h"

namespace openfab::program {

namespace {

constexpr int kDecimals = 6;

void write(JsonText* w, std::string_view key, double value) {
    w->key(key).fraction(value, kDecimals);
}
void write(JsonText* w, std::string_view key, int64_t value) {
    w->member(key, value);
}

double rate(int64_t voxels, double seconds) {
    return seconds > 0 ? static_cast<double>(voxels) / seconds * 1e-6 : 0;
}

void write_materials(JsonText* w, const pipeline::PrintStatistics& s,
                     const pipeline::PrintInfo& info) {
    const double voxel_ml = info.pitch_mm.x * info.pitch_mm.y * info.pitch_mm.z * 1e-3;
    w->key("voxels_by_material").begin_object();
    for (size_t code = 1; code < s.voxels_by_code.size(); ++code) {
        write(w, info.materials[code - 1].name, s.voxels_by_code[code]);
    }
    w->end_object();
    w->key("ml_by_material").begin_object();
    for (size_t code = 1; code < s.voxels_by_code.size(); ++code) {
        write(w, info.materials[code - 1].name,
              static_cast<double>(s.voxels_by_code[code]) * voxel_ml);
    }
    w->end_object();
    w->key("g_by_material").begin_object();
    for (size_t code = 1; code < s.voxels_by_code.size(); ++code) {
        write(w, info.materials[code - 1].name,
              static_cast<double>(s.voxels_by_code[code]) * voxel_ml *
                  info.materials[code - 1].density_g_cm3);
    }
    w->end_object();
}

void write_times(JsonText* w, const pipeline::PrintStatistics& s) {
    write(w, "slices", int64_t{s.slices});
    if (s.slices_resumed > 0) write(w, "slices_kept", int64_t{s.slices_resumed});
    if (s.print_seconds > 0) write(w, "print_seconds", s.print_seconds);
    write(w, "seconds_total", s.seconds_total);
    write(w, "seconds_first_slice", s.seconds_first_slice);
    w->key("seconds_by_phase").begin_object();
    for (const auto& [stage, seconds] : s.seconds_by_stage)
        write(w, stage, seconds);
    w->end_object();
    write(w, "mvoxels_per_second", rate(pipeline::voxels_printed(s), s.seconds_total));
    write(w, "msolid_per_second", rate(s.voxels_solid - s.voxels_solid_resumed, s.seconds_total));
    write(w, "peak_rss_bytes", s.peak_rss_bytes);
    write(w, "threads", int64_t{s.threads});
}

void write_work(JsonText* w, const pipeline::PrintStatistics& s) {
    w->key("blocks").begin_object();
    write(w, "total", s.blocks_total);
    write(w, "filled", s.blocks_filled);
    write(w, "evaluated", s.blocks_evaluated);
    w->end_object();
    w->key("queries").begin_object();
    write(w, "asked", s.queries_asked);
    write(w, "skipped", s.queries_skipped);
    w->end_object();
    w->key("cache").begin_object();
    write(w, "hits", s.cache_hits);
    write(w, "misses", s.cache_misses);
    write(w, "evictions", s.cache_evictions);
    write(w, "peak_bytes", s.cache_peak_bytes);
    w->end_object();
    write(w, "weights_not_usable", s.weights_not_usable);
    write(w, "displacements_not_finite", s.displacements_not_finite);
    write(w, "displacements_cut", s.displacements_cut);
}

}  // namespace

void write_grid(const Vec3i& size_voxels, const pipeline::PrintInfo& info, JsonText* w) {
    w->key("size_voxels").begin_list();
    for (int a = 0; a < 3; ++a)
        w->value(size_voxels[a]);
    w->end_array().key("pitch_mm").begin_list();
    for (int a = 0; a < 3; ++a)
        w->fraction(info.pitch_mm[a], kDecimals);
    w->end_array();
}

void write_cost(const pipeline::PrintCost& cost, JsonText* w) {
    w->key("cost").begin_object();
    w->member("currency", cost.currency);
    write(w, "money", cost.money);
    if (cost.seconds > 0) write(w, "seconds", cost.seconds);
    write(w, "passes", cost.passes);
    w->key("by_material").begin_object();
    for (const pipeline::MaterialCost& line : cost.materials) {
        w->key(line.name).begin_object();
        write(w, "ml", line.ml);
        write(w, "waste_ml", line.waste_ml);
        if (line.money) write(w, "money", *line.money);
        w->end_object();
    }
    w->end_object();
    w->end_object();
}

std::string statistics_json(const pipeline::PrintStatistics& s, const pipeline::PrintInfo& info) {
    JsonText json(JsonText::Layout::kIndented);
    JsonText* const w = &json;
    w->begin_object();
    w->member("title", info.title);
    w->member("printer", info.printer);
    w->member("complete", s.complete);
    // A string, since JSON readers keep 53 bits of a number.
    w->member("hash", fmt::format("{:016x}", s.hash));
    write_grid(info.size, info, w);
    write(w, "voxels_total", s.voxels_total);
    write(w, "voxels_solid", s.voxels_solid);
    if (info.support_code != 0) {
        write(w, "voxels_support", s.voxels_support);
        w->member("support_material", info.materials[info.support_code - 1].name);
    }
    write_materials(w, s, info);
    write_times(w, s);
    if (s.cost) write_cost(*s.cost, w);
    write_work(w, s);
    w->key("warnings").begin_array();
    for (const std::string& warning : s.warnings)
        w->value(warning);
    w->end_array();
    w->key("notes").begin_array();
    for (const std::string& note : s.notes)
        w->value(note);
    w->end_array();
    w->end_object();
    return json.take() + "\n";
}

Result<void> write_statistics(const std::filesystem::path& file,
                              const pipeline::PrintStatistics& statistics,
                              const pipeline::PrintInfo& info) {
    return backends::write_whole_file(file, statistics_json(statistics, info));
}

std::string nothing_printed(const pipeline::PrintStatistics& statistics, const std::string& sizes) {
    if (!statistics.complete || statistics.voxels_solid > 0) return {};
    std::string text = messages::kNothingPrinted + sizes;
    if (statistics.weights_not_usable > 0) {
        text += fmt::format(messages::kAmountsNotUsable, statistics.weights_not_usable);
    }
    return text;
}

}  // namespace openfab::program

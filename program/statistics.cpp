// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/statistics.h"

#include <fmt/format.h>
#include <rapidjson/prettywriter.h>
#include <rapidjson/stringbuffer.h>

#include "backends/common/output_file.h"
#include "base/text.h"
#include "program/messages.h"

namespace openfab::program {

namespace {

using Writer = rapidjson::PrettyWriter<rapidjson::StringBuffer>;

void write(Writer& w, const std::string& text) {
    const std::string valid = valid_utf8(text);
    w.String(valid.c_str(), static_cast<rapidjson::SizeType>(valid.size()));
}
void write(Writer& w, const char* key, int64_t value) {
    w.Key(key);
    w.Int64(value);
}
void write(Writer& w, const char* key, double value) {
    w.Key(key);
    w.Double(value);
}
void write(Writer& w, const char* key, const std::string& value) {
    w.Key(key);
    write(w, value);
}

double rate(int64_t voxels, double seconds) {
    return seconds > 0 ? static_cast<double>(voxels) / seconds * 1e-6 : 0;
}

void write_materials(Writer& w, const pipeline::PrintStatistics& s,
                     const pipeline::PrintInfo& info) {
    const double voxel_ml = info.pitch_mm.x * info.pitch_mm.y * info.pitch_mm.z * 1e-3;
    w.Key("voxels_by_material");
    w.StartObject();
    for (size_t code = 1; code < s.voxels_by_code.size(); ++code) {
        write(w, valid_utf8(info.materials[code - 1].name).c_str(), s.voxels_by_code[code]);
    }
    w.EndObject();
    w.Key("ml_by_material");
    w.StartObject();
    for (size_t code = 1; code < s.voxels_by_code.size(); ++code) {
        write(w, valid_utf8(info.materials[code - 1].name).c_str(),
              static_cast<double>(s.voxels_by_code[code]) * voxel_ml);
    }
    w.EndObject();
    w.Key("g_by_material");
    w.StartObject();
    for (size_t code = 1; code < s.voxels_by_code.size(); ++code) {
        write(w, valid_utf8(info.materials[code - 1].name).c_str(),
              static_cast<double>(s.voxels_by_code[code]) * voxel_ml *
                  info.materials[code - 1].density_g_cm3);
    }
    w.EndObject();
}

void write_times(Writer& w, const pipeline::PrintStatistics& s) {
    write(w, "slices", int64_t{s.slices});
    if (s.slices_resumed > 0) write(w, "slices_kept", int64_t{s.slices_resumed});
    if (s.print_seconds > 0) write(w, "print_seconds", s.print_seconds);
    write(w, "seconds_total", s.seconds_total);
    write(w, "seconds_first_slice", s.seconds_first_slice);
    w.Key("seconds_by_phase");
    w.StartObject();
    for (const auto& [stage, seconds] : s.seconds_by_stage)
        write(w, stage.c_str(), seconds);
    w.EndObject();
    write(w, "mvoxels_per_second", rate(pipeline::voxels_printed(s), s.seconds_total));
    write(w, "msolid_per_second", rate(s.voxels_solid - s.voxels_solid_resumed, s.seconds_total));
    write(w, "peak_rss_bytes", s.peak_rss_bytes);
    write(w, "threads", int64_t{s.threads});
}

void write_work(Writer& w, const pipeline::PrintStatistics& s) {
    w.Key("blocks");
    w.StartObject();
    write(w, "total", s.blocks_total);
    write(w, "filled", s.blocks_filled);
    write(w, "evaluated", s.blocks_evaluated);
    w.EndObject();
    w.Key("queries");
    w.StartObject();
    write(w, "asked", s.queries_asked);
    write(w, "skipped", s.queries_skipped);
    w.EndObject();
    w.Key("cache");
    w.StartObject();
    write(w, "hits", s.cache_hits);
    write(w, "misses", s.cache_misses);
    write(w, "evictions", s.cache_evictions);
    write(w, "peak_bytes", s.cache_peak_bytes);
    w.EndObject();
    write(w, "weights_not_usable", s.weights_not_usable);
    write(w, "displacements_not_finite", s.displacements_not_finite);
    write(w, "displacements_cut", s.displacements_cut);
}

}  // namespace

void write_grid(const Vec3i& size_voxels, const pipeline::PrintInfo& info,
                rapidjson::PrettyWriter<rapidjson::StringBuffer>* w) {
    w->Key("size_voxels");
    w->SetFormatOptions(rapidjson::kFormatSingleLineArray);
    w->StartArray();
    for (int a = 0; a < 3; ++a)
        w->Int(size_voxels[a]);
    w->EndArray();
    w->Key("pitch_mm");
    w->StartArray();
    for (int a = 0; a < 3; ++a)
        w->Double(info.pitch_mm[a]);
    w->EndArray();
    w->SetFormatOptions(rapidjson::kFormatDefault);
}

void write_cost(const pipeline::PrintCost& cost,
                rapidjson::PrettyWriter<rapidjson::StringBuffer>* w) {
    w->Key("cost");
    w->StartObject();
    write(*w, "currency", cost.currency);
    write(*w, "money", cost.money);
    if (cost.seconds > 0) write(*w, "seconds", cost.seconds);
    write(*w, "passes", cost.passes);
    w->Key("by_material");
    w->StartObject();
    for (const pipeline::MaterialCost& line : cost.materials) {
        w->Key(valid_utf8(line.name).c_str());
        w->StartObject();
        write(*w, "ml", line.ml);
        write(*w, "waste_ml", line.waste_ml);
        if (line.money) write(*w, "money", *line.money);
        w->EndObject();
    }
    w->EndObject();
    w->EndObject();
}

std::string statistics_json(const pipeline::PrintStatistics& s, const pipeline::PrintInfo& info) {
    rapidjson::StringBuffer buffer;
    Writer w(buffer);
    w.SetMaxDecimalPlaces(6);
    w.SetIndent(' ', 2);
    w.StartObject();
    write(w, "title", info.title);
    write(w, "printer", info.printer);
    w.Key("complete");
    w.Bool(s.complete);
    // A string, since JSON readers keep 53 bits of a number.
    write(w, "hash", fmt::format("{:016x}", s.hash));
    write_grid(info.size, info, &w);
    write(w, "voxels_total", s.voxels_total);
    write(w, "voxels_solid", s.voxels_solid);
    if (info.support_code != 0) {
        write(w, "voxels_support", s.voxels_support);
        write(w, "support_material", info.materials[info.support_code - 1].name);
    }
    write_materials(w, s, info);
    write_times(w, s);
    if (s.cost) write_cost(*s.cost, &w);
    write_work(w, s);
    w.Key("warnings");
    w.StartArray();
    for (const std::string& warning : s.warnings)
        write(w, warning);
    w.EndArray();
    w.EndObject();
    return std::string(buffer.GetString(), buffer.GetSize()) + "\n";
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

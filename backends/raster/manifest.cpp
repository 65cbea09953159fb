// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The texts beside the slices: manifest.json for programs, HANDOFF.txt for the operator of the
// printer's front end, and what an array lacks.

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "backends/common/hex_color.h"
#include "backends/common/resume_check.h"
#include "backends/raster/folder_sink.h"
#include "backends/raster/grey_slice.h"
#include "backends/raster/messages.h"
#include "backends/raster/npy_sink.h"
#include "backends/raster/slice_digests.h"
#include "base/json_text.h"
#include "base/text.h"

namespace openfab::raster {

namespace {

/// Six digits are finer than any printer, and avoid 0.042333333333333334.
double rounded(double value) {
    return std::strtod(fmt::format("{:.6f}", value).c_str(), nullptr);
}

void put(JsonText& json, std::string_view name, double value) {
    json.key(name).fraction(rounded(value));
}
void put_list(JsonText& json, std::string_view name, std::initializer_list<double> values) {
    json.key(name).begin_list();
    for (const double value : values)
        json.fraction(rounded(value));
    json.end_array();
}

double voxel_ml(const pipeline::PrintInfo& info) {
    return info.pitch_mm.x * info.pitch_mm.y * info.pitch_mm.z * 1e-3;
}

int64_t voxels_of(const pipeline::PrintTotals& totals, size_t code) {
    return code < totals.voxels_by_code.size() ? totals.voxels_by_code[code] : 0;
}

void put_geometry(JsonText& json, const pipeline::PrintInfo& info) {
    const Vec3d& pitch = info.pitch_mm;
    put_list(json, "dpi", {25.4 / pitch.x, 25.4 / pitch.y});
    put(json, "layer_um", pitch.z * 1000);
    put_list(json, "pitch_mm", {pitch.x, pitch.y, pitch.z});
    put_list(json, "size_mm",
             {info.size.x * pitch.x, info.size.y * pitch.y, info.size.z * pitch.z});
    put_list(json, "origin_mm", {info.origin_mm.x, info.origin_mm.y, info.origin_mm.z});
}

void put_axes(JsonText& json, const FolderOptions& options) {
    json.key("axes").begin_object();
    json.member("image_right", options.flip_x ? "-x" : "+x");
    json.member("image_up", "+y");
    json.member("next_slice", "+z");
    json.member("flipped_x", options.flip_x);
    json.end_object();
}

/// `bitmaps`: each has files of its own.
void put_materials(JsonText& json, const pipeline::PrintInfo& info,
                   const pipeline::PrintTotals& totals, bool bitmaps) {
    json.key("materials").begin_array();
    for (size_t i = 0; i < info.materials.size(); ++i) {
        const pipeline::SliceMaterial& material = info.materials[i];
        const int64_t voxels = voxels_of(totals, i + 1);
        const double ml = static_cast<double>(voxels) * voxel_ml(info);
        json.begin_object();
        json.member("name", material.name);
        if (bitmaps) json.member("file_suffix", fmt::format("_{}.bmp", i + 1));
        json.member("color", backends::hex_color(material.key));
        json.member("channel", material.channel);
        put(json, "density_g_cm3", material.density_g_cm3);
        json.member("voxels", voxels);
        put(json, "ml", ml);
        put(json, "g", ml * material.density_g_cm3);
        json.end_object();
    }
    json.end_array();
}

void put_provenance(JsonText& json, const pipeline::PrintInfo& info) {
    json.member("seed", std::to_string(info.seed));
    if (info.provenance.empty()) return;
    json.key("made_from").begin_object();
    for (const auto& [name, value] : info.provenance)
        json.member(name, value);
    json.end_object();
}

/// What changed while the print ran.
void put_changes(JsonText& json, const pipeline::PrintTotals& totals) {
    if (totals.changes.empty()) return;
    std::string open;  // list
    for (const process::EffectChange& change : totals.changes) {
        const std::string list = change.effect + "_changes";
        if (list != open) {
            if (!open.empty()) json.end_array();
            json.key(list).begin_array();
            open = list;
        }
        json.begin_object();
        json.member("from_slice", int64_t{change.slice});
        json.member(change.key, change.text);
        json.end_object();
    }
    json.end_array();
}

void put_sizes(JsonText& json, std::string_view name, std::initializer_list<int32_t> sizes) {
    json.key(name).begin_list();
    for (const int32_t size : sizes)
        json.value(size);
    json.end_array();
}

/// Of a part of a print: how many slices the whole has, and which of them are elsewhere, B excluded.
void put_missing(JsonText& json, const pipeline::PrintInfo& info) {
    if (info.slice_begin == 0 && info.slice_end == info.size.z) return;
    json.member("slices_of_whole", int64_t{info.size.z});
    json.key("slices_elsewhere").begin_array();
    for (const auto& [begin, end] :
         {std::pair(0, info.slice_begin), std::pair(info.slice_end, info.size.z)}) {
        if (begin == end) continue;
        json.value(fmt::format("{}:{}", begin, end));
    }
    json.end_array();
}

void put_digests(JsonText& json, const pipeline::PrintInfo& info, const FolderOptions& options,
                 std::span<const Sha256Digest> digests) {
    if (digests.empty()) return;
    const size_t files = files_a_slice(info, options);
    const auto identity = print_identity(manifest_json(info, {}, 0, options));
    for (const bool seals : {false, true}) {
        json.key(seals ? "seals" : "sha256").begin_object();
        for (size_t i = 0; i < digests.size(); ++i) {
            const auto z = info.slice_begin + static_cast<int32_t>(i / files);
            const std::string name = slice_file_name(z, i % files, info, options);
            json.member(name, hex_text(seals ? seal_of(*identity, name, digests[i]) : digests[i]));
        }
        json.end_object();
    }
}

/// Returns the name of the last file of the last slice.
std::string last_file(const pipeline::PrintInfo& info, int32_t slices_written,
                      const FolderOptions& options) {
    return slice_file_name(info.slice_begin + std::max(slices_written, 1) - 1,
                           files_a_slice(info, options) - 1, info, options);
}

size_t grey_index(const pipeline::PrintInfo& info, const FolderOptions& options) {
    return static_cast<size_t>(std::max(grey_material(info, options), 0));
}

const char* color_mode(SliceFormat format) {
    if (is_grey(format)) return is_grey_of_16_bits(format) ? "grey16" : "grey8";
    return format == SliceFormat::kIndexed   ? "indexed"
           : format == SliceFormat::kBitmaps ? "bitmaps"
                                             : "rgba";
}

/// Slices that are read from a file have its provenance.
bool slices_hold_support(const pipeline::PrintInfo& info) {
    return info.support_code != 0 ||
           std::any_of(info.provenance.begin(), info.provenance.end(), [](const auto& setting) {
               return setting.first == "support" && setting.second != "none";
           });
}

}  // namespace

std::string manifest_json(const pipeline::PrintInfo& info, const pipeline::PrintTotals& totals,
                          int32_t slices_written, const FolderOptions& options,
                          std::span<const Sha256Digest> digests) {
    const bool bitmaps = options.format == SliceFormat::kBitmaps;
    JsonText json(JsonText::Layout::kIndented);
    json.begin_object();
    json.member("format", std::string(bitmaps                   ? "openfab-bmp-slices"
                                      : is_grey(options.format) ? "openfab-grey-slices"
                                                                : "openfab-png-slices"));
    json.member("version", int64_t{1});
    json.member("complete", totals.complete);
    json.member("title", info.title);
    json.member("printer", info.printer);
    json.member("slices", int64_t{slices_written});
    json.member("slices_planned", int64_t{info.slice_end - info.slice_begin});
    json.member("first_slice_z", int64_t{info.slice_begin});
    put_missing(json, info);
    json.member("first_file", slice_file_name(info.slice_begin, 0, info, options));
    json.member("last_file", last_file(info, slices_written, options));
    put_sizes(json, "pixels", {info.size.x, info.size.y});
    put_geometry(json, info);
    put_axes(json, options);
    json.member("color_mode", std::string(color_mode(options.format)));
    if (is_grey(options.format))
        json.member("grey_material", info.materials[grey_index(info, options)].name);
    else
        json.member("void_color", backends::hex_color({0, 0, 0, 0}));
    json.member("support_made_by", std::string(slices_hold_support(info)         ? "slices"
                                               : options.front_end_makes_support ? "front_end"
                                                                                 : "nobody"));
    put_materials(json, info, totals, bitmaps);
    json.member("voxels_solid", totals.voxels_solid);
    put_provenance(json, info);
    put_changes(json, totals);
    json.member("hash", fmt::format("{:016x}", totals.hash));
    put_digests(json, info, options, digests);
    json.end_object();
    return json.take() + "\n";
}

std::string array_json(const pipeline::PrintInfo& info, const pipeline::PrintTotals& totals,
                       int32_t slices_written, std::optional<uint64_t> fractions_hash) {
    JsonText json(JsonText::Layout::kIndented);
    json.begin_object();
    json.member("format", "openfab-array");
    json.member("version", int64_t{1});
    json.member("complete", totals.complete);
    json.member("title", info.title);
    json.member("printer", info.printer);
    put_sizes(json, "shape_zyx", {slices_written, info.size.y, info.size.x});
    json.member("first_slice_z", int64_t{info.slice_begin});
    put_missing(json, info);
    put_geometry(json, info);
    put_materials(json, info, totals, false);
    json.member("voxels_solid", totals.voxels_solid);
    put_provenance(json, info);
    put_changes(json, totals);
    json.member("hash", fmt::format("{:016x}", totals.hash));
    if (fractions_hash) json.member("fractions_hash", fmt::format("{:016x}", *fractions_hash));
    json.end_object();
    return json.take() + "\n";
}

namespace {

/// Writes the entries that are only known at the end.
bool is_of_the_end(const std::string& name) {
    for (const char* known :
         {"complete", "slices", "last_file", "voxels_solid", "hash", "voxels", "ml", "g", "sha256",
          "seals", "slices_of_whole", "slices_elsewhere"}) {
        if (name == known) return true;
    }
    return name.ends_with("_changes");
}

/// Writes a value without what is only known at the end.
void write_beginning(const JsonValue& value, JsonText* json) {
    if (value.is(JsonValue::Kind::kObject)) {
        json->begin_object();
        for (const JsonMember& member : value.members) {
            if (is_of_the_end(member.key)) continue;
            json->key(member.key);
            write_beginning(member.value, json);
        }
        json->end_object();
    } else if (value.is(JsonValue::Kind::kArray)) {
        json->begin_array();
        for (const JsonValue& item : value.items)
            write_beginning(item, json);
        json->end_array();
    } else {
        json->value(value);
    }
}

std::string text_of(const JsonValue& value) {
    return value.is(JsonValue::Kind::kString) ? value.text : JsonText().value(value).take();
}

std::string difference(const JsonValue& there, const JsonValue& here, const std::string& name) {
    if (here.is(JsonValue::Kind::kObject) && there.is(JsonValue::Kind::kObject)) {
        for (const JsonMember& member : here.members) {
            if (is_of_the_end(member.key)) continue;
            const JsonValue* const other = member_of(there, member.key);
            if (other == nullptr) return fmt::format(messages::kManifestLacks, member.key);
            std::string differs = difference(*other, member.value, member.key);
            if (!differs.empty()) return differs;
        }
        return {};
    }
    const std::vector<JsonValue>& items = here.items;
    const bool objects = !items.empty() && items[0].is(JsonValue::Kind::kObject);
    if (objects && there.items.size() == items.size()) {
        for (size_t i = 0; i < items.size(); ++i) {
            std::string differs =
                difference(there.items[i], items[i], fmt::format("{} {}", name, i + 1));
            if (!differs.empty()) return differs;
        }
        return {};
    }
    const std::string a = text_of(there), b = text_of(here);
    return a == b ? std::string() : backends::differs(name, a, b);
}

}  // namespace

std::optional<JsonValue> parse_manifest(std::string_view text) {
    Result<JsonValue> root =
        parse_json(text, "manifest.json", std::numeric_limits<int64_t>::max(), kMostManifestValues);
    if (!root || !root->is(JsonValue::Kind::kObject)) return {};
    return std::move(*root);
}

bool manifest_is_complete(const std::string& text) {
    const std::optional<JsonValue> manifest = parse_manifest(text);
    const JsonValue* const complete = manifest ? member_of(*manifest, "complete") : nullptr;
    return complete != nullptr && complete->boolean;
}

std::string manifest_hash(const std::string& text) {
    const std::optional<JsonValue> manifest = parse_manifest(text);
    const JsonValue* const hash = manifest ? member_of(*manifest, "hash") : nullptr;
    return hash != nullptr ? hash->text : std::string();
}

std::optional<Sha256Digest> print_identity(const std::string& manifest) {
    const std::optional<JsonValue> root = parse_manifest(manifest);
    if (!root) return {};
    JsonText beginning;
    write_beginning(*root, &beginning);
    return sha256(beginning.text());
}

std::string manifest_difference(const std::string& text, const pipeline::PrintInfo& info,
                                const FolderOptions& options) {
    const std::optional<JsonValue> there = parse_manifest(text);
    if (!there) return messages::kManifestDamaged;
    const std::optional<JsonValue> here = parse_manifest(manifest_json(info, {}, 0, options));
    return difference(*there, *here, "manifest");
}

std::string handoff_text(const pipeline::PrintInfo& info, const pipeline::PrintTotals& totals,
                         int32_t slices_written, const FolderOptions& options) {
    const Vec3d& pitch = info.pitch_mm;
    std::string text =
        fmt::format("{}: what to enter in the printer's front end\n\n", printable(info.title));
    if (!totals.complete)
        text +=
            "NOT COMPLETE: the print of these slices did not reach its end. Do not use them.\n\n";
    text += fmt::format("printer             {}\n", printable(info.printer));
    text += fmt::format("slice files         {} to {}, {} files, the first is the lowest\n",
                        slice_file_name(info.slice_begin, 0, info, options),
                        last_file(info, slices_written, options),
                        static_cast<size_t>(slices_written) * files_a_slice(info, options));
    text += fmt::format("pixels              {} x {}\n", info.size.x, info.size.y);
    text += fmt::format("resolution          {:.6g} dpi across (x), {:.6g} dpi down (y)\n",
                        25.4 / pitch.x, 25.4 / pitch.y);
    text += fmt::format("slice thickness     {:.6g} um ({:.6g} mm)\n", pitch.z * 1000, pitch.z);
    text += fmt::format("finished size       {:.2f} x {:.2f} x {:.2f} mm\n", info.size.x * pitch.x,
                        info.size.y * pitch.y, slices_written * pitch.z);
    text += fmt::format("orientation         seen from above, x runs to the {}, y runs up\n",
                        options.flip_x ? "left (the pictures are mirrored)" : "right");
    const bool bitmaps = options.format == SliceFormat::kBitmaps;
    const bool grey = is_grey(options.format);
    const char* empty = bitmaps ? "what no file has is empty"
                        : grey  ? "black is empty"
                                : "transparent pixels are empty";
    text += slices_hold_support(info)
                ? "support             is in the slices; let the front end add none\n"
                : fmt::format("support             {}; {}\n",
                              options.front_end_makes_support ? "let the front end add it"
                                                              : "none is in the slices",
                              empty);
    if (grey) {
        text += fmt::format(
            "\nThe pictures are of `{}`: {} bits a pixel, white where a voxel is all of it.\n",
            printable(info.materials[grey_index(info, options)].name),
            is_grey_of_16_bits(options.format) ? 16 : 8);
    }
    text +=
        grey ? "\nAmounts of the print's materials, as dithered:\n"
        : bitmaps
            ? "\nAssign a material to each ending of the files' names; black is where it goes:\n"
            : "\nAssign a material to each colour:\n";
    for (size_t i = 0; i < info.materials.size(); ++i) {
        const pipeline::SliceMaterial& material = info.materials[i];
        const double ml = static_cast<double>(voxels_of(totals, i + 1)) * voxel_ml(info);
        const std::string mark = bitmaps ? fmt::format("_{}.bmp", i + 1)
                                         : fmt::format("RGB {:3} {:3} {:3}", material.key[0],
                                                       material.key[1], material.key[2]);
        text += fmt::format("  {}   {:<20} {:9.2f} ml {:9.2f} g{}\n", mark,
                            printable(material.name), ml, ml * material.density_g_cm3,
                            material.channel.empty() ? "" : "   channel " + material.channel);
    }
    if (!options.handoff.empty()) text += "\n" + options.handoff + "\n";
    text += fmt::format("\nhash {:016x}\n", totals.hash);
    return text;
}

}  // namespace openfab::raster

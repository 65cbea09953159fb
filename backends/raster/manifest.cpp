// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The texts beside the slices: manifest.json for programs, HANDOFF.txt for the operator of the
// printer's front end, and what an array lacks.

#include <fmt/format.h>
#include <rapidjson/document.h>
#include <rapidjson/prettywriter.h>
#include <rapidjson/stringbuffer.h>

#include <algorithm>

#include "backends/common/resume_check.h"
#include "backends/raster/folder_sink.h"
#include "backends/raster/grey_slice.h"
#include "backends/raster/messages.h"
#include "backends/raster/npy_sink.h"
#include "base/text.h"

namespace openfab::raster {

namespace {

using Json = rapidjson::PrettyWriter<rapidjson::StringBuffer>;

std::string hex_color(const std::array<uint8_t, 4>& c) {
    return fmt::format("#{:02x}{:02x}{:02x}{:02x}", c[0], c[1], c[2], c[3]);
}

/// Six digits are finer than any printer, and avoid 0.042333333333333334.
double rounded(double value) {
    return std::strtod(fmt::format("{:.6f}", value).c_str(), nullptr);
}

void key(Json& json, const char* name) {
    json.Key(name);
}
void put(Json& json, const char* name, const std::string& value) {
    key(json, name);
    const std::string valid = valid_utf8(value);
    json.String(valid.c_str(), static_cast<rapidjson::SizeType>(valid.size()));
}
void put(Json& json, const char* name, bool value) {
    key(json, name);
    json.Bool(value);
}
void put(Json& json, const char* name, int64_t value) {
    key(json, name);
    json.Int64(value);
}
void put(Json& json, const char* name, double value) {
    key(json, name);
    json.Double(rounded(value));
}
template <typename... T>
void put_list(Json& json, const char* name, T... values) {
    key(json, name);
    json.SetFormatOptions(rapidjson::kFormatSingleLineArray);
    json.StartArray();
    (json.Double(rounded(values)), ...);
    json.EndArray();
    json.SetFormatOptions(rapidjson::kFormatDefault);
}

double voxel_ml(const pipeline::PrintInfo& info) {
    return info.pitch_mm.x * info.pitch_mm.y * info.pitch_mm.z * 1e-3;
}

int64_t voxels_of(const pipeline::PrintTotals& totals, size_t code) {
    return code < totals.voxels_by_code.size() ? totals.voxels_by_code[code] : 0;
}

void put_geometry(Json& json, const pipeline::PrintInfo& info) {
    const Vec3d& pitch = info.pitch_mm;
    put_list(json, "dpi", 25.4 / pitch.x, 25.4 / pitch.y);
    put(json, "layer_um", pitch.z * 1000);
    put_list(json, "pitch_mm", pitch.x, pitch.y, pitch.z);
    put_list(json, "size_mm", info.size.x * pitch.x, info.size.y * pitch.y, info.size.z * pitch.z);
    put_list(json, "origin_mm", info.origin_mm.x, info.origin_mm.y, info.origin_mm.z);
}

void put_axes(Json& json, const FolderOptions& options) {
    key(json, "axes");
    json.StartObject();
    put(json, "image_right", std::string(options.flip_x ? "-x" : "+x"));
    put(json, "image_up", std::string("+y"));
    put(json, "next_slice", std::string("+z"));
    put(json, "flipped_x", options.flip_x);
    json.EndObject();
}

/// `bitmaps`: each has files of its own.
void put_materials(Json& json, const pipeline::PrintInfo& info, const pipeline::PrintTotals& totals,
                   bool bitmaps) {
    key(json, "materials");
    json.StartArray();
    for (size_t i = 0; i < info.materials.size(); ++i) {
        const pipeline::SliceMaterial& material = info.materials[i];
        const int64_t voxels = voxels_of(totals, i + 1);
        const double ml = static_cast<double>(voxels) * voxel_ml(info);
        json.StartObject();
        put(json, "name", material.name);
        if (bitmaps) put(json, "file_suffix", fmt::format("_{}.bmp", i + 1));
        put(json, "color", hex_color(material.key));
        put(json, "channel", material.channel);
        put(json, "density_g_cm3", material.density_g_cm3);
        put(json, "voxels", voxels);
        put(json, "ml", ml);
        put(json, "g", ml * material.density_g_cm3);
        json.EndObject();
    }
    json.EndArray();
}

void put_provenance(Json& json, const pipeline::PrintInfo& info) {
    put(json, "seed", std::to_string(info.seed));
    if (info.provenance.empty()) return;
    key(json, "made_from");
    json.StartObject();
    for (const auto& [name, value] : info.provenance)
        put(json, name.c_str(), value);
    json.EndObject();
}

/// What changed while the print ran.
void put_changes(Json& json, const pipeline::PrintTotals& totals) {
    if (totals.changes.empty()) return;
    std::string open;  // list
    for (const process::EffectChange& change : totals.changes) {
        const std::string list = change.effect + "_changes";
        if (list != open) {
            if (!open.empty()) json.EndArray();
            key(json, list.c_str());
            json.StartArray();
            open = list;
        }
        json.StartObject();
        put(json, "from_slice", int64_t{change.slice});
        put(json, change.key.c_str(), change.text);
        json.EndObject();
    }
    json.EndArray();
}

void put_sizes(Json& json, const char* name, std::initializer_list<int32_t> sizes) {
    key(json, name);
    json.SetFormatOptions(rapidjson::kFormatSingleLineArray);
    json.StartArray();
    for (const int32_t size : sizes)
        json.Int(size);
    json.EndArray();
    json.SetFormatOptions(rapidjson::kFormatDefault);
}

/// Of a part of a print: how many slices the whole has, and which of them are elsewhere, B excluded.
void put_missing(Json& json, const pipeline::PrintInfo& info) {
    if (info.slice_begin == 0 && info.slice_end == info.size.z) return;
    put(json, "slices_of_whole", int64_t{info.size.z});
    key(json, "slices_elsewhere");
    json.StartArray();
    for (const auto& [begin, end] :
         {std::pair(0, info.slice_begin), std::pair(info.slice_end, info.size.z)}) {
        if (begin == end) continue;
        const std::string text = fmt::format("{}:{}", begin, end);
        json.String(text.c_str(), static_cast<rapidjson::SizeType>(text.size()));
    }
    json.EndArray();
}

void put_digests(Json& json, const pipeline::PrintInfo& info, const FolderOptions& options,
                 std::span<const Sha256Digest> digests) {
    if (digests.empty()) return;
    const size_t files = files_a_slice(info, options);
    const auto identity = print_identity(manifest_json(info, {}, 0, options));
    for (const bool seals : {false, true}) {
        key(json, seals ? "seals" : "sha256");
        json.StartObject();
        for (size_t i = 0; i < digests.size(); ++i) {
            const auto z = info.slice_begin + static_cast<int32_t>(i / files);
            const std::string name = slice_file_name(z, i % files, info, options);
            put(json, name.c_str(),
                hex_text(seals ? seal_of(*identity, name, digests[i]) : digests[i]));
        }
        json.EndObject();
    }
}

std::string text_of(const rapidjson::StringBuffer& buffer) {
    return std::string(buffer.GetString(), buffer.GetSize()) + "\n";
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
    rapidjson::StringBuffer buffer;
    Json json(buffer);
    json.SetIndent(' ', 2);
    json.StartObject();
    put(json, "format",
        std::string(bitmaps                   ? "openfab-bmp-slices"
                    : is_grey(options.format) ? "openfab-grey-slices"
                                              : "openfab-png-slices"));
    put(json, "version", int64_t{1});
    put(json, "complete", totals.complete);
    put(json, "title", info.title);
    put(json, "printer", info.printer);
    put(json, "slices", int64_t{slices_written});
    put(json, "slices_planned", int64_t{info.slice_end - info.slice_begin});
    put(json, "first_slice_z", int64_t{info.slice_begin});
    put_missing(json, info);
    put(json, "first_file", slice_file_name(info.slice_begin, 0, info, options));
    put(json, "last_file", last_file(info, slices_written, options));
    put_sizes(json, "pixels", {info.size.x, info.size.y});
    put_geometry(json, info);
    put_axes(json, options);
    put(json, "color_mode", std::string(color_mode(options.format)));
    if (is_grey(options.format))
        put(json, "grey_material", info.materials[grey_index(info, options)].name);
    else
        put(json, "void_color", hex_color({0, 0, 0, 0}));
    put(json, "support_made_by",
        std::string(slices_hold_support(info)         ? "slices"
                    : options.front_end_makes_support ? "front_end"
                                                      : "nobody"));
    put_materials(json, info, totals, bitmaps);
    put(json, "voxels_solid", totals.voxels_solid);
    put_provenance(json, info);
    put_changes(json, totals);
    put(json, "hash", fmt::format("{:016x}", totals.hash));
    put_digests(json, info, options, digests);
    json.EndObject();
    return text_of(buffer);
}

std::string array_json(const pipeline::PrintInfo& info, const pipeline::PrintTotals& totals,
                       int32_t slices_written, std::optional<uint64_t> fractions_hash) {
    rapidjson::StringBuffer buffer;
    Json json(buffer);
    json.SetIndent(' ', 2);
    json.StartObject();
    put(json, "format", std::string("openfab-array"));
    put(json, "version", int64_t{1});
    put(json, "complete", totals.complete);
    put(json, "title", info.title);
    put(json, "printer", info.printer);
    put_sizes(json, "shape_zyx", {slices_written, info.size.y, info.size.x});
    put(json, "first_slice_z", int64_t{info.slice_begin});
    put_missing(json, info);
    put_geometry(json, info);
    put_materials(json, info, totals, false);
    put(json, "voxels_solid", totals.voxels_solid);
    put_provenance(json, info);
    put_changes(json, totals);
    put(json, "hash", fmt::format("{:016x}", totals.hash));
    if (fractions_hash) put(json, "fractions_hash", fmt::format("{:016x}", *fractions_hash));
    json.EndObject();
    return text_of(buffer);
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
void write_beginning(const rapidjson::Value& value,
                     rapidjson::Writer<rapidjson::StringBuffer>* writer) {
    if (value.IsObject()) {
        writer->StartObject();
        for (const auto& [name, member] : value.GetObject()) {
            if (is_of_the_end(name.GetString())) continue;
            name.Accept(*writer);
            write_beginning(member, writer);
        }
        writer->EndObject();
    } else if (value.IsArray()) {
        writer->StartArray();
        for (const rapidjson::Value& item : value.GetArray())
            write_beginning(item, writer);
        writer->EndArray();
    } else {
        value.Accept(*writer);
    }
}

std::string text_of(const rapidjson::Value& value) {
    if (value.IsString()) return {value.GetString(), value.GetStringLength()};
    rapidjson::StringBuffer buffer;
    rapidjson::Writer<rapidjson::StringBuffer> writer(buffer);
    value.Accept(writer);
    return {buffer.GetString(), buffer.GetSize()};
}

std::string difference(const rapidjson::Value& there, const rapidjson::Value& here,
                       const std::string& name) {
    if (here.IsObject() && there.IsObject()) {
        for (const auto& member : here.GetObject()) {
            const std::string key = member.name.GetString();
            if (is_of_the_end(key)) continue;
            const auto other = there.FindMember(member.name);
            if (other == there.MemberEnd()) return fmt::format(messages::kManifestLacks, key);
            std::string found = difference(other->value, member.value, key);
            if (!found.empty()) return found;
        }
        return {};
    }
    const bool objects = here.IsArray() && !here.Empty() && here[0].IsObject();
    if (objects && there.IsArray() && there.Size() == here.Size()) {
        for (rapidjson::SizeType i = 0; i < here.Size(); ++i) {
            std::string found = difference(there[i], here[i], fmt::format("{} {}", name, i + 1));
            if (!found.empty()) return found;
        }
        return {};
    }
    const std::string a = text_of(there), b = text_of(here);
    return a == b ? std::string() : backends::differs(name, a, b);
}

}  // namespace

bool manifest_is_complete(const std::string& text) {
    rapidjson::Document manifest;
    manifest.Parse<rapidjson::kParseIterativeFlag>(text.data(), text.size());
    if (manifest.HasParseError() || !manifest.IsObject()) return false;
    return manifest.HasMember("complete") && manifest["complete"].IsTrue();
}

std::string manifest_hash(const std::string& text) {
    rapidjson::Document manifest;
    manifest.Parse<rapidjson::kParseIterativeFlag>(text.data(), text.size());
    if (manifest.HasParseError() || !manifest.IsObject()) return {};
    const auto hash = manifest.FindMember("hash");
    const bool known = hash != manifest.MemberEnd() && hash->value.IsString();
    return known ? hash->value.GetString() : std::string();
}

std::optional<Sha256Digest> print_identity(const std::string& manifest) {
    rapidjson::Document root;
    root.Parse<rapidjson::kParseIterativeFlag>(manifest.data(), manifest.size());
    if (root.HasParseError() || !root.IsObject()) return {};
    rapidjson::StringBuffer buffer;
    rapidjson::Writer<rapidjson::StringBuffer> writer(buffer);
    write_beginning(root, &writer);
    return sha256(std::string_view(buffer.GetString(), buffer.GetSize()));
}

std::string manifest_difference(const std::string& text, const pipeline::PrintInfo& info,
                                const FolderOptions& options) {
    rapidjson::Document there, here;
    there.Parse<rapidjson::kParseIterativeFlag>(text.data(), text.size());
    if (there.HasParseError() || !there.IsObject()) return messages::kManifestDamaged;
    const std::string expected = manifest_json(info, {}, 0, options);
    here.Parse(expected.data(), expected.size());
    return difference(there, here, "manifest");
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

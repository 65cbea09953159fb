// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/zarr/layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <span>
#include <string_view>

#include "backends/common/hex_color.h"
#include "backends/zarr/messages.h"
#include "base/json_text.h"

namespace openfab::zarr {

namespace {

constexpr int32_t kCoarseEnough = 256;
constexpr int32_t kMostSide = 1 << 20;
constexpr size_t kMostMaterials = 254;

void put_list(JsonText& json, std::string_view name, std::initializer_list<double> values) {
    json.key(name).begin_list();
    for (const double value : values)
        json.value(value);
    json.end_array();
}

void put_sizes(JsonText& json, std::string_view name, std::initializer_list<int32_t> values) {
    json.key(name).begin_list();
    for (const int32_t value : values)
        json.value(value);
    json.end_array();
}

void put_axes(JsonText& json) {
    json.key("axes").begin_array();
    for (const char* axis : {"z", "y", "x"}) {
        json.begin_object();
        json.member("name", axis);
        json.member("type", "space");
        json.member("unit", "millimeter");
        json.end_object();
    }
    json.end_array();
}

/// `translation` is of the middle of the first voxel.
void put_datasets(JsonText& json, const pipeline::PrintInfo& info, size_t levels) {
    json.key("datasets").begin_array();
    for (size_t level = 0; level < levels; ++level) {
        const double times = std::ldexp(1, static_cast<int>(level));
        const Vec3d pitch = info.pitch_mm * times;
        const Vec3d first = info.origin_mm + pitch * 0.5;
        json.begin_object();
        json.member("path", std::to_string(level));
        json.key("coordinateTransformations").begin_array();
        json.begin_object();
        json.member("type", "scale");
        put_list(json, "scale", {pitch.z, pitch.y, pitch.x});
        json.end_object();
        json.begin_object();
        json.member("type", "translation");
        put_list(json, "translation", {first.z, first.y, first.x});
        json.end_object();
        json.end_array();
        json.end_object();
    }
    json.end_array();
}

void put_labels(JsonText& json, const pipeline::PrintInfo& info) {
    json.key("image-label").begin_object();
    json.key("colors").begin_array();
    for (size_t m = 0; m < info.materials.size(); ++m) {
        const auto& color = info.materials[m].preview;
        json.begin_object();
        json.member("label-value", static_cast<int64_t>(m + 1));
        put_sizes(json, "rgba", {color[0], color[1], color[2], color[3]});
        json.end_object();
    }
    json.end_array();
    json.key("properties").begin_array();
    for (size_t m = 0; m < info.materials.size(); ++m) {
        json.begin_object();
        json.member("label-value", static_cast<int64_t>(m + 1));
        json.member("name", info.materials[m].name);
        json.end_object();
    }
    json.end_array();
    json.end_object();
}

void put_print(JsonText& json, const pipeline::PrintInfo& info) {
    json.key("openfab").begin_object();
    json.member("version", int64_t{1});
    put_sizes(json, "size", {info.size.x, info.size.y, info.size.z});
    put_list(json, "pitch_mm", {info.pitch_mm.x, info.pitch_mm.y, info.pitch_mm.z});
    put_list(json, "origin_mm", {info.origin_mm.x, info.origin_mm.y, info.origin_mm.z});
    json.member("bits", int64_t{info.bits});
    json.member("title", info.title);
    json.member("printer", info.printer);
    json.member("seed", std::to_string(info.seed));
    json.key("materials").begin_array();
    for (const pipeline::SliceMaterial& material : info.materials) {
        json.begin_object();
        json.member("name", material.name);
        json.member("color", backends::hex_color(material.key));
        json.member("preview", backends::hex_color(material.preview));
        json.member("density_g_cm3", material.density_g_cm3);
        json.member("channel", material.channel);
        json.end_object();
    }
    json.end_array();
    json.key("made_from").begin_object();
    for (const auto& [name, value] : info.provenance)
        json.member(name, value);
    json.end_object();
    json.end_object();
}

const JsonValue* at(const JsonValue* object, std::string_view key) {
    return object == nullptr ? nullptr : member_of(*object, key);
}

std::string text_of(const JsonValue* object, std::string_view key) {
    const JsonValue* const value = at(object, key);
    return value != nullptr && value->is(JsonValue::Kind::kString) ? value->text : std::string();
}

bool read_numbers(const JsonValue* object, std::string_view key, std::span<double> out) {
    const JsonValue* const list = at(object, key);
    if (list == nullptr || list->items.size() != out.size()) return false;
    for (size_t i = 0; i < out.size(); ++i) {
        if (!list->items[i].is(JsonValue::Kind::kNumber) || !std::isfinite(list->items[i].number))
            return false;
        out[i] = list->items[i].number;
    }
    return true;
}

bool read_materials(const JsonValue* own, pipeline::PrintInfo* info) {
    const JsonValue* const materials = at(own, "materials");
    if (materials == nullptr || materials->items.size() > kMostMaterials) return false;
    for (const JsonValue& item : materials->items) {
        const JsonValue* const density = at(&item, "density_g_cm3");
        pipeline::SliceMaterial material;
        material.name = text_of(&item, "name");
        material.channel = text_of(&item, "channel");
        if (density != nullptr) material.density_g_cm3 = density->number;
        if (!backends::read_color(text_of(&item, "color"), &material.key) ||
            !backends::read_color(text_of(&item, "preview"), &material.preview))
            return false;
        info->materials.push_back(std::move(material));
    }
    return true;
}

bool read_print(const JsonValue* own, pipeline::PrintInfo* info) {
    std::array<double, 3> size{}, pitch{}, origin{};
    if (!read_numbers(own, "size", size) || !read_numbers(own, "pitch_mm", pitch) ||
        !read_numbers(own, "origin_mm", origin))
        return false;
    for (int a = 0; a < 3; ++a) {
        const double n = size[static_cast<size_t>(a)];
        if (!(n >= 1) || n > kMostSide || n != std::floor(n)) return false;
        if (!(pitch[static_cast<size_t>(a)] > 0)) return false;
        info->size[a] = static_cast<int32_t>(n);
        info->pitch_mm[a] = pitch[static_cast<size_t>(a)];
        info->origin_mm[a] = origin[static_cast<size_t>(a)];
    }
    const JsonValue* const bits = at(own, "bits");
    if (bits == nullptr || (bits->number != 4 && bits->number != 8)) return false;
    info->bits = static_cast<int32_t>(bits->number);
    info->slice_end = info->size.z;
    info->title = text_of(own, "title");
    info->printer = text_of(own, "printer");
    const std::string seed = text_of(own, "seed");
    std::from_chars(seed.data(), seed.data() + seed.size(), info->seed);
    if (!read_materials(own, info) || (info->bits == 4 && info->materials.size() > 15))
        return false;
    const JsonValue* const made_from = at(own, "made_from");
    if (made_from == nullptr) return true;
    for (const JsonMember& setting : made_from->members)
        info->provenance.emplace_back(setting.key, setting.value.text);
    return true;
}

/// Returns the JSON of a node of the store. Fails for other versions of Zarr.
Result<JsonValue> read_node(const std::string& text, const std::string& name) {
    Result<JsonValue> root = parse_json(text, name);
    if (!root) return root;
    const JsonValue* const version = member_of(*root, "zarr_format");
    if (version != nullptr && version->number == 3) return root;
    return user_error(fmt::format(messages::kOtherVersion, name,
                                  version == nullptr ? "?" : fmt::format("{}", version->number)));
}

bool equal(const JsonValue& a, const JsonValue& b) {
    if (a.kind != b.kind || a.boolean != b.boolean || a.number != b.number || a.text != b.text ||
        a.items.size() != b.items.size())
        return false;
    for (size_t i = 0; i < a.items.size(); ++i)
        if (!equal(a.items[i], b.items[i])) return false;
    // Members that other programs add to an array say nothing of its bytes.
    return std::all_of(b.members.begin(), b.members.end(), [&](const JsonMember& member) {
        const JsonValue* const there = member_of(a, member.key);
        return there != nullptr && equal(*there, member.value);
    });
}

}  // namespace

std::vector<Level> levels_of(const Vec3i& size) {
    std::vector<Level> levels{{size, kSlab}};
    const auto is_coarse = [](const Vec3i& s) {
        return std::max({s.x, s.y, s.z}) <= kCoarseEnough;
    };
    while (!is_coarse(levels.back().size)) {
        const Vec3i& finer = levels.back().size;
        const Vec3i half{(finer.x + 1) / 2, (finer.y + 1) / 2, (finer.z + 1) / 2};
        const size_t level = levels.size();
        levels.push_back({half, level < kSlabLevels ? kSlab >> level : kSlab});
    }
    return levels;
}

std::string group_json(const pipeline::PrintInfo& info) {
    JsonText json(JsonText::Layout::kIndentedLists);
    json.begin_object();
    json.member("zarr_format", int64_t{3});
    json.member("node_type", "group");
    json.key("attributes").begin_object();
    json.key("ome").begin_object();
    json.member("version", "0.5");
    json.key("multiscales").begin_array().begin_object();
    json.member("name", info.title);
    json.member("type", "mode");
    put_axes(json);
    put_datasets(json, info, levels_of(info.size).size());
    json.end_object().end_array();
    put_labels(json, info);
    json.end_object();
    put_print(json, info);
    json.end_object();
    json.end_object();
    return json.take() + "\n";
}

std::string array_json(const Level& level) {
    JsonText json(JsonText::Layout::kIndentedLists);
    json.begin_object();
    json.member("zarr_format", int64_t{3});
    json.member("node_type", "array");
    put_sizes(json, "shape", {level.size.z, level.size.y, level.size.x});
    json.member("data_type", "uint8");
    json.key("chunk_grid").begin_object();
    json.member("name", "regular");
    json.key("configuration").begin_object();
    put_sizes(json, "chunk_shape", {level.depth, level.tiles_y() * kTile, level.tiles_x() * kTile});
    json.end_object().end_object();
    json.key("chunk_key_encoding").begin_object();
    json.member("name", "default");
    json.key("configuration").begin_object().member("separator", "/").end_object();
    json.end_object();
    json.member("fill_value", int64_t{0});
    json.key("codecs").begin_array().begin_object();
    json.member("name", "sharding_indexed");
    json.key("configuration").begin_object();
    put_sizes(json, "chunk_shape", {level.depth, kTile, kTile});
    json.key("codecs").begin_array();
    json.begin_object().member("name", "bytes").end_object();
    json.begin_object().member("name", "zstd");
    json.key("configuration").begin_object();
    json.member("level", int64_t{1}).member("checksum", true);
    json.end_object().end_object().end_array();
    json.key("index_codecs").begin_array();
    json.begin_object().member("name", "bytes");
    json.key("configuration").begin_object().member("endian", "little").end_object();
    json.end_object();
    json.begin_object().member("name", "crc32c").end_object();
    json.end_array();
    json.member("index_location", "end");
    json.end_object().end_object().end_array();
    json.key("attributes").begin_object().end_object();
    json.key("dimension_names").begin_list().value("z").value("y").value("x").end_array();
    json.end_object();
    return json.take() + "\n";
}

std::string shard_key(size_t level, int32_t shard) {
    return fmt::format("{}/c/{}/0/0", level, shard);
}

Result<pipeline::PrintInfo> read_group(const std::string& text, const std::string& name) {
    const Result<JsonValue> root = read_node(text, name);
    if (!root) return root.error();
    const JsonValue* const own = at(at(&*root, "attributes"), "openfab");
    if (own == nullptr) return user_error(fmt::format(messages::kNoPrint, name));
    pipeline::PrintInfo info;
    const JsonValue* const version = at(own, "version");
    if (version == nullptr || version->number != 1 || !read_print(own, &info))
        return user_error(fmt::format(messages::kPrintDamaged, name));
    return info;
}

Result<void> check_array(const std::string& text, const Level& level, const std::string& name) {
    const Result<JsonValue> there = read_node(text, name);
    if (!there) return there.error();
    const Result<JsonValue> wanted = parse_json(array_json(level), name);
    if (!wanted) return wanted.error();
    for (const JsonMember& member : wanted->members) {
        const JsonValue* const value = member_of(*there, member.key);
        if (value == nullptr || !equal(*value, member.value))
            return user_error(fmt::format(messages::kOtherArray, name, member.key));
    }
    return {};
}

}  // namespace openfab::zarr

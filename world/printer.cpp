// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/printer.h"

#include <algorithm>

#include "base/json.h"
#include "base/near_miss.h"
#include "world/json_reader.h"
#include "world/messages.h"
#include "world/printer_profiles.h"

namespace openfab::world {
namespace {

constexpr std::string_view kSuffix = ".printer.json";
constexpr size_t kLargestPrinter = 1'000'000;
constexpr double kInch_mm = 25.4;

const KeySet& printer_keys() {
    static const KeySet set = {"printer",
                               {"name",          "maker",
                                "model",         "dpi",
                                "layer_um",      "layers_um",
                                "pitch_mm",      "build_volume_mm",
                                "max_materials", "native_format",
                                "formats",       "mesh_colors",
                                "makes_support", "support_material",
                                "layer_time_s",  "inks",
                                "handoff",       "sources",
                                "unknown",       "process"},
                               {"name"}};
    return set;
}

bool is_unknown(const Printer& printer, std::string_view figure) {
    return std::any_of(printer.unknown.begin(), printer.unknown.end(),
                       [&](const auto& entry) { return entry.first == figure; });
}

/// Figures that are not known have a sentence instead of a value.
void read_unknown(const JsonValue& root, JsonReader* json, Printer* out) {
    const JsonMember* list = root.find("unknown");
    if (list == nullptr) return;
    if (!list->value.is(JsonValue::Kind::kObject)) {
        return json->fail(list->value,
                          fmt::format(messages::kUnknownNoObject, list->value.kind_name()),
                          messages::kUnknownNoObjectHelp);
    }
    for (const JsonMember& entry : list->value.members) {
        if (root.find(entry.key) != nullptr) {
            json->fail_at(entry.line, entry.column,
                          fmt::format(messages::kGivenAndUnknown, entry.key));
        }
        out->unknown.emplace_back(entry.key,
                                  json->string(entry.value, "`" + entry.key + "` of `unknown`"));
    }
}

/// Reads either `pitch_mm`, or `dpi` along x and y with `layer_um`, of which each may be unknown.
void read_pitch(const JsonValue& root, JsonReader* json, Printer* out) {
    const JsonMember* pitch = root.find("pitch_mm");
    const JsonMember* dpi = root.find("dpi");
    const JsonMember* layer = root.find("layer_um");
    const bool no_dpi = is_unknown(*out, "dpi"), no_layer = is_unknown(*out, "layer_um");
    const bool plane = dpi != nullptr || no_dpi, thickness = layer != nullptr || no_layer;
    if ((pitch != nullptr) == plane || plane != thickness) {
        return json->fail(root, messages::kPitchNotClear, messages::kPitchNotClearHelp);
    }
    if (pitch != nullptr) {
        const std::vector<double> n = json->numbers(pitch->value, "`pitch_mm`", 3, 1000);
        out->pitch_mm = {n[0], n[1], n[2]};
    } else {
        out->pitch_mm = {0, 0, 0};
        if (dpi != nullptr) {
            const std::vector<double> n = json->numbers(dpi->value, "`dpi`", 2, 1e6);
            out->pitch_mm.x = kInch_mm / n[0];
            out->pitch_mm.y = kInch_mm / n[1];
        }
        if (layer != nullptr)
            out->pitch_mm.z = json->number(layer->value, "`layer_um`", 0.001, 1e6) / 1000;
    }
    const JsonValue& culprit = pitch != nullptr ? pitch->value : dpi != nullptr ? dpi->value : root;
    for (int axis = 0; axis < 3; ++axis) {
        if (pitch == nullptr && (axis == 2 ? no_layer : no_dpi)) continue;
        if (!(out->pitch_mm[axis] >= 1e-6 && out->pitch_mm[axis] <= 1000)) {
            json->fail(culprit, messages::kPitchOutside);
        }
    }
}

/// Calls `read` for each item of an array; `what` names it in messages.
template <typename Read>
void read_list(const JsonValue& root, std::string_view key, JsonReader* json, Read&& read) {
    const JsonMember* list = root.find(key);
    if (list == nullptr) return;
    if (!list->value.is(JsonValue::Kind::kArray)) {
        return json->fail(list->value,
                          fmt::format(messages::kNotAnArray, key, list->value.kind_name()));
    }
    for (const JsonValue& item : list->value.items)
        read(item);
}

void read_lists(const JsonValue& root, JsonReader* json, Printer* out) {
    read_list(root, "layers_um", json, [&](const JsonValue& item) {
        out->layers_um.push_back(json->number(item, "a layer of `layers_um`", 0.001, 1e6));
    });
    read_list(root, "formats", json, [&](const JsonValue& item) {
        out->formats.push_back(json->string(item, "a format of `formats`"));
    });
    read_list(root, "inks", json, [&](const JsonValue& item) {
        static const KeySet keys = {"ink", {"name", "density_g_cm3"}, {"name"}};
        if (!json->object(item, keys, "an ink of `inks`")) return;
        Ink ink{json->string(item.find("name")->value, "`name` of an ink")};
        if (const JsonMember* p = item.find("density_g_cm3"))
            ink.density_g_cm3 = json->number(p->value, "`density_g_cm3` of an ink", 0.001, 30);
        out->inks.push_back(std::move(ink));
    });
    read_list(root, "sources", json, [&](const JsonValue& item) {
        static const KeySet keys = {
            "source", {"document", "url", "seen", "gives"}, {"document", "gives"}};
        if (!json->object(item, keys, "a source of `sources`")) return;
        PrinterSource source{json->string(item.find("document")->value, "`document` of a source")};
        if (const JsonMember* p = item.find("url"))
            source.url = json->string(p->value, "`url` of a source");
        if (const JsonMember* p = item.find("seen")) {
            source.seen = static_cast<Seen>(
                json->choice(p->value, "`seen` of a source", {"read", "quoted", "unread"}));
        }
        read_list(item, "gives", json, [&](const JsonValue& figure) {
            source.gives.push_back(json->string(figure, "an item of `gives`"));
            if (json->ok() && root.find(source.gives.back()) == nullptr) {
                json->fail(figure, fmt::format(messages::kSourceGivesTooMuch, source.gives.back()));
            }
        });
        out->sources.push_back(std::move(source));
    });
}

/// Has the keys of a world's materials, and a name.
void read_support_material(const JsonValue& value, JsonReader* json, SupportMaterial* out) {
    static const KeySet keys = {
        "support_material", {"name", "key", "preview", "density_g_cm3", "channel"}, {}};
    if (!json->object(value, keys, "the support material")) return;
    if (const JsonMember* p = value.find("name")) {
        out->name = json->string(p->value, "`name` of the support material");
        if (out->name.empty()) json->fail(p->value, messages::kSupportWithoutName);
    }
    if (const JsonMember* p = value.find("key"))
        out->key = out->preview = json->color(p->value, "`key` of the support material", false);
    if (const JsonMember* p = value.find("preview"))
        out->preview = json->color(p->value, "`preview` of the support material", true);
    if (const JsonMember* p = value.find("density_g_cm3")) {
        out->density_g_cm3 =
            json->number(p->value, "`density_g_cm3` of the support material", 0.001, 30);
    }
    if (const JsonMember* p = value.find("channel"))
        out->channel = json->string(p->value, "`channel` of the support material");
}

Result<Printer> parse_printer(std::string_view text, const std::string& name) {
    const Result<JsonValue> root = parse_json(text, name);
    if (!root) return root.error();
    JsonReader json(name);
    Printer out;
    if (!json.object(*root, printer_keys(), "the printer")) return json.error();
    out.name = json.string(root->find("name")->value, "`name`");
    if (const JsonMember* p = root->find("maker")) out.maker = json.string(p->value, "`maker`");
    if (const JsonMember* p = root->find("model")) out.model = json.string(p->value, "`model`");
    read_unknown(*root, &json, &out);
    read_pitch(*root, &json, &out);
    read_lists(*root, &json, &out);
    if (is_unknown(out, "build_volume_mm")) out.build_volume_mm = {0, 0, 0};
    if (const JsonMember* p = root->find("build_volume_mm")) {
        const std::vector<double> n = json.numbers(p->value, "`build_volume_mm`", 3, 1e5);
        out.build_volume_mm = {n[0], n[1], n[2]};
        if (!(n[0] > 0 && n[1] > 0 && n[2] > 0))
            json.fail(p->value, messages::kBuildVolumeNotAboveZero);
    }
    if (const JsonMember* p = root->find("max_materials")) {
        out.max_materials = json.integer(p->value, "`max_materials`", 1, 254);
    }
    if (const JsonMember* p = root->find("native_format"))
        out.native_format = json.string(p->value, "`native_format`");
    if (const JsonMember* p = root->find("mesh_colors"))
        out.mesh_colors = json.boolean(p->value, "`mesh_colors`");
    if (const JsonMember* p = root->find("makes_support")) {
        out.makes_support = json.boolean(p->value, "`makes_support`");
    }
    if (const JsonMember* p = root->find("support_material"))
        read_support_material(p->value, &json, &out.support_material);
    if (const JsonMember* p = root->find("layer_time_s")) {
        out.layer_time_s = json.number(p->value, "`layer_time_s`", 0, 1e6);
    }
    if (const JsonMember* p = root->find("process"))
        read_process(p->value, name, &json, &out.process);
    if (const JsonMember* p = root->find("handoff"))
        out.handoff = json.string(p->value, "`handoff`");
    if (!json.ok()) return json.error();
    return out;
}

}  // namespace

std::vector<std::string> printer_names() {
    std::vector<std::string> names;
    for (const EmbeddedText& profile : kPrinterProfiles)
        names.emplace_back(profile.name.substr(0, profile.name.size() - kSuffix.size()));
    return names;
}

Result<Printer> load_printer(const std::string& name_or_path) {
    const std::string file = name_or_path + std::string(kSuffix);
    for (const EmbeddedText& profile : kPrinterProfiles) {
        if (profile.name == file) return parse_printer(profile.text, file);
    }
    if (!name_or_path.ends_with(kSuffix)) {
        return user_error(fmt::format(messages::kNoSuchPrinter, name_or_path, kSuffix,
                                      suggest(name_or_path, printer_names())));
    }
    const Result<std::string> text = read_text_file(name_or_path, kLargestPrinter);
    if (!text) return text.error();
    return parse_printer(*text, name_or_path);
}

Result<std::string> printer_text(const std::string& name_or_path) {
    const std::string file = name_or_path + std::string(kSuffix);
    for (const EmbeddedText& profile : kPrinterProfiles) {
        if (profile.name == file) return std::string(profile.text);
    }
    return read_text_file(name_or_path, kLargestPrinter);
}

}  // namespace openfab::world

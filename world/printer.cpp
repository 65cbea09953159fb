// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/printer.h"

#include <algorithm>

#include "base/json.h"
#include "base/near_miss.h"
#include "world/json_reader.h"
#include "world/printer_profiles.h"

namespace openfab::world {
namespace {

constexpr std::string_view kSuffix = ".printer.json";
constexpr size_t kLargestFile = 1'000'000;
constexpr double kInch_mm = 25.4;

const KeySet& printer_keys() {
    static const KeySet set = {
        "printer",
        {"name", "dpi", "layer_um", "pitch_mm", "build_volume_mm", "max_materials", "native_format",
         "makes_support", "support_material", "layer_time_s", "handoff"},
        {"name"}};
    return set;
}

/// Reads either `pitch_mm`, or `dpi` along x and y with `layer_um`.
void read_pitch(const JsonValue& root, JsonReader* json, Printer* out) {
    const JsonMember* pitch = root.find("pitch_mm");
    const JsonMember* dpi = root.find("dpi");
    const JsonMember* layer = root.find("layer_um");
    if ((pitch != nullptr) == (dpi != nullptr) || (dpi != nullptr) != (layer != nullptr)) {
        return json->fail(root, "the printer's pitch is not clear",
                          "give `pitch_mm`, or `dpi` and `layer_um`");
    }
    if (pitch != nullptr) {
        const std::vector<double> n = json->numbers(pitch->value, "`pitch_mm`", 3, 1000);
        out->pitch_mm = {n[0], n[1], n[2]};
    } else {
        const std::vector<double> n = json->numbers(dpi->value, "`dpi`", 2, 1e6);
        const double layer_um = json->number(layer->value, "`layer_um`", 0.001, 1e6);
        out->pitch_mm = {kInch_mm / n[0], kInch_mm / n[1], layer_um / 1000};
    }
    const JsonValue& culprit = pitch != nullptr ? pitch->value : dpi->value;
    for (int axis = 0; axis < 3; ++axis) {
        if (!(out->pitch_mm[axis] >= 1e-6 && out->pitch_mm[axis] <= 1000)) {
            json->fail(culprit, "a pitch is not between 1e-6 and 1000 mm");
        }
    }
}

/// Has the keys of a world's materials, and a name.
void read_support_material(const JsonValue& value, JsonReader* json, SupportMaterial* out) {
    static const KeySet keys = {
        "support_material", {"name", "key", "preview", "density_g_cm3", "channel"}, {}};
    if (!json->object(value, keys, "the support material")) return;
    if (const JsonMember* p = value.find("name")) {
        out->name = json->string(p->value, "`name` of the support material");
        if (out->name.empty()) json->fail(p->value, "the support material has no name");
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
    read_pitch(*root, &json, &out);
    if (const JsonMember* p = root->find("build_volume_mm")) {
        const std::vector<double> n = json.numbers(p->value, "`build_volume_mm`", 3, 1e5);
        out.build_volume_mm = {n[0], n[1], n[2]};
        if (!(n[0] > 0 && n[1] > 0 && n[2] > 0))
            json.fail(p->value, "`build_volume_mm` has a size that is not above 0");
    }
    if (const JsonMember* p = root->find("max_materials")) {
        out.max_materials = json.integer(p->value, "`max_materials`", 1, 64);
    }
    if (const JsonMember* p = root->find("native_format"))
        out.native_format = json.string(p->value, "`native_format`");
    if (const JsonMember* p = root->find("makes_support")) {
        out.makes_support = json.boolean(p->value, "`makes_support`");
    }
    if (const JsonMember* p = root->find("support_material"))
        read_support_material(p->value, &json, &out.support_material);
    if (const JsonMember* p = root->find("layer_time_s")) {
        out.layer_time_s = json.number(p->value, "`layer_time_s`", 0, 1e6);
    }
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
        return user_error(
            fmt::format("no printer is called `{}`, and it is not the path of a {} file; {}",
                        name_or_path, kSuffix, suggest(name_or_path, printer_names())));
    }
    const Result<std::string> text = read_text_file(name_or_path, kLargestFile);
    if (!text) return text.error();
    return parse_printer(*text, name_or_path);
}

}  // namespace openfab::world

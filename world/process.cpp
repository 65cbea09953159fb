// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/process.h"

#include <algorithm>

#include "world/json_reader.h"
#include "world/messages.h"

namespace openfab::world {

namespace {

ByMaterial read_by_material(const JsonValue& value, JsonReader* json, const std::string& what,
                            double most) {
    ByMaterial out;
    if (value.is(JsonValue::Kind::kNumber)) {
        out.others = json->number(value, what, 0, most);
        return out;
    }
    if (!value.is(JsonValue::Kind::kObject)) {
        json->fail(value, fmt::format("{} is {}", what, value.kind_name()),
                   messages::kNumberOrOfMaterials);
        return out;
    }
    for (const JsonMember& member : value.members) {
        const double number =
            json->number(member.value, fmt::format("{} of `{}`", what, member.key), 0, most);
        if (member.key == "*")
            out.others = number;
        else
            out.named[member.key] = number;
    }
    return out;
}

Cost read_cost(const JsonValue& value, JsonReader* json) {
    static const KeySet keys = {"cost",
                                {"currency", "price_ml", "waste_ml_swath", "swath_mm", "passes",
                                 "seconds_pass", "seconds_layer"},
                                {}};
    Cost out;
    if (!json->object(value, keys, "`cost`")) return out;
    if (const JsonMember* p = value.find("currency"))
        out.currency = json->string(p->value, "`currency`");
    if (const JsonMember* p = value.find("price_ml"))
        out.price_ml = read_by_material(p->value, json, "`price_ml`", 1e9);
    if (const JsonMember* p = value.find("waste_ml_swath"))
        out.waste_ml_swath = read_by_material(p->value, json, "`waste_ml_swath`", 1e6);
    if (const JsonMember* p = value.find("swath_mm"))
        out.swath_mm = json->number(p->value, "`swath_mm`", 0.001, 1e5);
    if (const JsonMember* p = value.find("passes"))
        out.passes = json->integer(p->value, "`passes`", 1, 1000);
    if (const JsonMember* p = value.find("seconds_pass"))
        out.seconds_pass = json->number(p->value, "`seconds_pass`", 0, 1e6);
    if (const JsonMember* p = value.find("seconds_layer"))
        out.seconds_layer = json->number(p->value, "`seconds_layer`", 0, 1e6);
    return out;
}

Checks read_checks(const JsonValue& value, JsonReader* json) {
    static const KeySet keys = {
        "checks", {"wall_mm", "gap_mm", "hole_mm", "island_mm3", "trapped_mm3", "apart"}, {}};
    Checks out;
    if (!json->object(value, keys, "`checks`")) return out;
    constexpr double kMost = 1e6;
    const auto read = [&](const char* key, ByMaterial* to) {
        if (const JsonMember* p = value.find(key))
            *to = read_by_material(p->value, json, fmt::format("`{}`", key), kMost);
    };
    read("wall_mm", &out.wall_mm);
    read("gap_mm", &out.gap_mm);
    read("hole_mm", &out.hole_mm);
    read("island_mm3", &out.island_mm3);
    if (const JsonMember* p = value.find("trapped_mm3"))
        out.trapped_mm3 = json->number(p->value, "`trapped_mm3`", 0, kMost);
    const JsonMember* apart = value.find("apart");
    if (apart == nullptr) return out;
    const char* rule = messages::kMustBePairsOfNames;
    if (!apart->value.is(JsonValue::Kind::kArray)) {
        json->fail(apart->value, fmt::format(messages::kApartNoArray, apart->value.kind_name()),
                   rule);
        return out;
    }
    for (const JsonValue& pair : apart->value.items) {
        if (!pair.is(JsonValue::Kind::kArray) || pair.items.size() != 2) {
            json->fail(pair, messages::kEntryIsNoPair, rule);
            return out;
        }
        out.apart.emplace_back(json->string(pair.items[0], "a name in `apart`"),
                               json->string(pair.items[1], "a name in `apart`"));
    }
    return out;
}

Vec3d read_scale(const JsonValue& value, JsonReader* json) {
    constexpr double kLeast = 0.5, kMost = 2;
    if (value.is(JsonValue::Kind::kNumber)) {
        const double s = json->number(value, "`scale`", kLeast, kMost);
        return {s, s, s};
    }
    const std::vector<double> n = json->numbers(value, "`scale`", 3, kMost);
    for (const double s : n) {
        if (s < kLeast)
            json->fail(value, fmt::format(messages::kScaleOutside, s),
                       fmt::format(messages::kScaleOutsideHelp, kLeast, kMost));
    }
    return {n[0], n[1], n[2]};
}

}  // namespace

std::vector<std::string_view> process_keys() {
    return {"scale", "about_mm", "field", "cost", "checks"};
}

void read_process(const JsonValue& value, const std::filesystem::path& file, JsonReader* json,
                  Process* out) {
    const std::vector<std::string_view> own = process_keys();
    KeySet keys{"process", own, {}};
    if (value.is(JsonValue::Kind::kObject)) {
        for (const JsonMember& member : value.members) {
            if (std::ranges::find(own, member.key) != own.end()) continue;
            keys.keys.push_back(member.key);
            std::erase_if(out->effects,
                          [&](const auto& entry) { return entry.member.key == member.key; });
            out->effects.push_back({member, file.string()});
        }
    }
    if (!json->object(value, keys, "`process`")) return;
    if (const JsonMember* p = value.find("scale")) out->scale = read_scale(p->value, json);
    if (const JsonMember* p = value.find("about_mm")) {
        const std::vector<double> n = json->numbers(p->value, "`about_mm`", 3, 1e5);
        out->about_mm = {n[0], n[1], n[2]};
    }
    if (const JsonMember* p = value.find("field")) {
        const std::string name = json->string(p->value, "`field`");
        if (json->ok() && name.empty())
            json->fail(p->value, messages::kFieldEmpty, messages::kFieldEmptyHelp);
        out->field = file.parent_path() / name;
    }
    if (const JsonMember* p = value.find("cost")) out->cost = read_cost(p->value, json);
    if (const JsonMember* p = value.find("checks")) out->checks = read_checks(p->value, json);
}

Result<Process> load_process(const std::filesystem::path& file, const Process& profile) {
    const Result<std::string> text = read_text_file(file.string(), kLargestProcess);
    if (!text) return text.error();
    const Result<JsonValue> root = parse_json(*text, file.string());
    if (!root) return root.error();
    JsonReader json(file.string());
    Process out = profile;
    read_process(*root, file, &json, &out);
    if (!json.ok()) return json.error();
    return out;
}

}  // namespace openfab::world

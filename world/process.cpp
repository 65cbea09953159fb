// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/process.h"

#include <algorithm>

#include "world/json_reader.h"
#include "world/messages.h"

namespace openfab::world {

namespace {

constexpr int64_t kLargestProcess = 4'000'000;
constexpr int32_t kMostNozzles = 1'000'000;

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

std::vector<Vec2<int32_t>> read_nozzles(const JsonValue& value, JsonReader* json) {
    std::vector<Vec2<int32_t>> out;
    if (!value.is(JsonValue::Kind::kArray) || value.items.empty()) {
        json->fail(value, fmt::format(messages::kNozzlesNoArray, value.kind_name()),
                   messages::kNozzlesNoArrayHelp);
        return out;
    }
    for (const JsonValue& item : value.items) {
        if (!item.is(JsonValue::Kind::kArray)) {
            const int32_t one = json->integer(item, "a number in `nozzles`", 0, kMostNozzles);
            out.push_back({one, one});
            continue;
        }
        if (item.items.size() != 2) {
            json->fail(item, messages::kRangeWithoutTwoNumbers,
                       messages::kRangeWithoutTwoNumbersHelp);
            return out;
        }
        const int32_t first =
            json->integer(item.items[0], "a number in `nozzles`", 0, kMostNozzles);
        const int32_t last = json->integer(item.items[1], "a number in `nozzles`", 0, kMostNozzles);
        if (json->ok() && last < first)
            json->fail(item, messages::kRangeEndsBeforeBegin, messages::kRangeEndsBeforeBeginHelp);
        out.push_back({first, last});
    }
    return out;
}

DeadNozzles read_dead(const JsonValue& value, JsonReader* json) {
    static const KeySet keys = {
        "dead",
        {"material", "substitute", "nozzles", "head", "passes", "pass", "jog"},
        {"material", "substitute", "nozzles"}};
    DeadNozzles out;
    if (!json->object(value, keys, "an entry of `dead`")) return out;
    out.material = json->string(value.find("material")->value, "`material` of dead nozzles");
    out.substitute = json->string(value.find("substitute")->value, "`substitute` of dead nozzles");
    if (json->ok() && out.material == out.substitute)
        json->fail(value.find("substitute")->value,
                   fmt::format(messages::kStandsInForItself, out.material),
                   messages::kStandsInForItselfHelp);
    out.nozzles = read_nozzles(value.find("nozzles")->value, json);
    if (const JsonMember* p = value.find("head"))
        out.head = json->integer(p->value, "`head`", 1, kMostNozzles);
    if (const JsonMember* p = value.find("passes"))
        out.passes = json->integer(p->value, "`passes`", 1, 1000);
    if (const JsonMember* p = value.find("pass"))
        out.pass = json->integer(p->value, "`pass`", 0, out.passes - 1);
    if (const JsonMember* p = value.find("jog"))
        out.jog = json->integer(p->value, "`jog`", -kMostNozzles, kMostNozzles);
    for (const Vec2<int32_t>& range : out.nozzles) {
        if (!json->ok() || out.head == 0 || range.y < out.head) continue;
        json->fail(value.find("nozzles")->value,
                   fmt::format(messages::kNoSuchNozzle, range.y, out.head),
                   messages::kNoSuchNozzleHelp);
    }
    return out;
}

std::vector<DeadNozzles> read_dead_list(const JsonValue& value, JsonReader* json) {
    std::vector<DeadNozzles> out;
    if (!value.is(JsonValue::Kind::kArray)) {
        json->fail(value, fmt::format(messages::kDeadNoArray, value.kind_name()),
                   messages::kDeadNoArrayHelp);
        return out;
    }
    constexpr size_t kMost = 10'000;
    if (value.items.size() > kMost)
        json->fail(value, fmt::format(messages::kTooManyDead, value.items.size()),
                   fmt::format(messages::kAtMost, kMost));
    for (const JsonValue& item : value.items) {
        if (!json->ok()) break;
        out.push_back(read_dead(item, json));
    }
    return out;
}

Vec3d read_sigma(const JsonValue& value, JsonReader* json) {
    constexpr double kMost_um = 10'000;
    if (value.is(JsonValue::Kind::kNumber)) {
        const double s = json->number(value, "`sigma_um`", 0, kMost_um);
        return {s, s, s};
    }
    const std::vector<double> n = json->numbers(value, "`sigma_um`", 3, kMost_um);
    for (const double s : n) {
        if (s < 0)
            json->fail(value, fmt::format(messages::kSigmaNegative, s),
                       messages::kSigmaNegativeHelp);
    }
    return {n[0], n[1], n[2]};
}

PairBleed read_pair(const JsonValue& value, JsonReader* json) {
    static const KeySet keys = {"pairs", {"materials", "sigma_um"}, {"materials", "sigma_um"}};
    PairBleed out;
    if (!json->object(value, keys, "an entry of `pairs`")) return out;
    const JsonValue& names = value.find("materials")->value;
    if (!names.is(JsonValue::Kind::kArray) || names.items.size() != 2) {
        json->fail(names, messages::kPairWithoutTwoNames, messages::kPairWithoutTwoNamesHelp);
        return out;
    }
    out.a = json->string(names.items[0], "a name in `materials`");
    out.b = json->string(names.items[1], "a name in `materials`");
    if (json->ok() && out.a == out.b && out.a != "*")
        json->fail(names, fmt::format(messages::kBleedsIntoItself, out.a),
                   messages::kBleedsIntoItselfHelp);
    out.sigma_um = read_sigma(value.find("sigma_um")->value, json);
    return out;
}

Bleed read_bleed(const JsonValue& value, JsonReader* json) {
    static const KeySet keys = {"bleed", {"sigma_um", "pairs", "steps"}, {}};
    constexpr int kMostSteps = 8;
    constexpr size_t kMostPairs = 10'000;
    Bleed out;
    if (!json->object(value, keys, "`bleed`")) return out;
    if (const JsonMember* p = value.find("sigma_um")) out.sigma_um = read_sigma(p->value, json);
    if (const JsonMember* p = value.find("steps"))
        out.steps = json->integer(p->value, "`steps` of `bleed`", 0, kMostSteps);
    const JsonMember* pairs = value.find("pairs");
    if (pairs == nullptr) return out;
    if (!pairs->value.is(JsonValue::Kind::kArray) || pairs->value.items.size() > kMostPairs) {
        json->fail(pairs->value, fmt::format(messages::kPairsNoArray, pairs->value.kind_name()),
                   fmt::format(messages::kPairsNoArrayHelp, kMostPairs));
        return out;
    }
    for (const JsonValue& item : pairs->value.items) {
        if (!json->ok()) break;
        out.pairs.push_back(read_pair(item, json));
    }
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

void read_process(const JsonValue& value, const std::filesystem::path& folder, JsonReader* json,
                  Process* out) {
    static const KeySet keys = {
        "process", {"scale", "about_mm", "field", "dead", "cost", "bleed", "checks"}, {}};
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
        out->field = folder / name;
    }
    if (const JsonMember* p = value.find("dead")) out->dead = read_dead_list(p->value, json);
    if (const JsonMember* p = value.find("cost")) out->cost = read_cost(p->value, json);
    if (const JsonMember* p = value.find("bleed")) out->bleed = read_bleed(p->value, json);
    if (const JsonMember* p = value.find("checks")) out->checks = read_checks(p->value, json);
}

Result<Process> load_process(const std::filesystem::path& file, const Process& profile) {
    const Result<std::string> text = read_text_file(file.string(), kLargestProcess);
    if (!text) return text.error();
    const Result<JsonValue> root = parse_json(*text, file.string());
    if (!root) return root.error();
    JsonReader json(file.string());
    Process out = profile;
    read_process(*root, file.parent_path(), &json, &out);
    if (!json.ok()) return json.error();
    return out;
}

Result<std::vector<DeadNozzles>> load_dead_nozzles(const std::filesystem::path& file) {
    const Result<std::string> text = read_text_file(file.string(), kLargestProcess);
    if (!text) return text.error();
    const Result<JsonValue> root = parse_json(*text, file.string());
    if (!root) return root.error();
    JsonReader json(file.string());
    std::vector<DeadNozzles> out = read_dead_list(*root, &json);
    if (!json.ok()) return json.error();
    return out;
}

}  // namespace openfab::world

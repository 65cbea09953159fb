// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/process/nozzles/dead_nozzles.h"

#include <fmt/format.h>

#include "runtime/process/nozzles/messages.h"
#include "world/process.h"

namespace openfab::process {

using world::JsonReader;

namespace {

constexpr int32_t kMostNozzles = 1'000'000;

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
    static const world::KeySet keys = {
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

}  // namespace

std::vector<DeadNozzles> read_dead_nozzles(const JsonValue& value, JsonReader* json) {
    std::vector<DeadNozzles> out;
    if (!value.is(JsonValue::Kind::kArray)) {
        json->fail(value, fmt::format(messages::kDeadNoArray, value.kind_name()),
                   messages::kDeadNoArrayHelp);
        return out;
    }
    constexpr size_t kMost = 10'000;
    if (value.items.size() > kMost)
        json->fail(value, fmt::format(messages::kTooManyDead, value.items.size()),
                   fmt::format(messages::kTooManyDeadHelp, kMost));
    for (const JsonValue& item : value.items) {
        if (!json->ok()) break;
        out.push_back(read_dead(item, json));
    }
    return out;
}

Result<std::vector<DeadNozzles>> load_dead_nozzles(const std::filesystem::path& file) {
    const Result<std::string> text = read_text_file(file.string(), world::kLargestProcess);
    if (!text) return text.error();
    const Result<JsonValue> root = parse_json(*text, file.string());
    if (!root) return root.error();
    JsonReader json(file.string());
    std::vector<DeadNozzles> out = read_dead_nozzles(*root, &json);
    if (!json.ok()) return json.error();
    return out;
}

}  // namespace openfab::process

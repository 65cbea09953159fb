// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/pieces_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/json_text.h"

namespace openfab::tools {

namespace {

using JsonKind = JsonValue::Kind;

constexpr size_t kLine = 110;

std::string on_one_line(const JsonValue& value) {
    switch (value.kind) {
        case JsonKind::kNull:
            return "null";
        case JsonKind::kBool:
            return value.boolean ? "true" : "false";
        case JsonKind::kNumber:
            return fmt::format("{}", value.number);
        case JsonKind::kString:
            return json_string(value.text);
        case JsonKind::kArray: {
            std::string out = "[";
            for (size_t i = 0; i < value.items.size(); ++i)
                out += (i > 0 ? ", " : "") + on_one_line(value.items[i]);
            return out + "]";
        }
        case JsonKind::kObject: {
            std::string out = "{";
            for (size_t i = 0; i < value.members.size(); ++i)
                out += (i > 0 ? ", " : "") + json_string(value.members[i].key) + ": " +
                       on_one_line(value.members[i].value);
            return out + "}";
        }
    }
    return {};
}

void append(const JsonValue& value, size_t indent, size_t before, std::string* out) {
    const std::string line = on_one_line(value);
    const bool array = value.is(JsonKind::kArray);
    const bool many = array ? !value.items.empty() : !value.members.empty();
    if (!many || (indent > 0 && indent + before + line.size() <= kLine)) {
        *out += line;
        return;
    }
    const std::string inner(indent + 4, ' ');
    *out += array ? "[" : "{";
    for (size_t i = 0; i < (array ? value.items.size() : value.members.size()); ++i) {
        *out += (i > 0 ? ",\n" : "\n") + inner;
        if (array) {
            append(value.items[i], indent + 4, 0, out);
        } else {
            const std::string key = json_string(value.members[i].key) + ": ";
            *out += key;
            append(value.members[i].value, indent + 4, key.size(), out);
        }
    }
    *out += "\n" + std::string(indent, ' ') + (array ? "]" : "}");
}

JsonValue object() {
    JsonValue out;
    out.kind = JsonKind::kObject;
    return out;
}

JsonValue json_of_connector(const pieces::Connector& c) {
    static constexpr const char* kKinds[] = {"peg", "dowel", "dovetail", "magnet"};
    JsonValue out = object();
    set_member(&out, kKinds[static_cast<size_t>(c.kind)], tools::json_of(c.at_mm));
    set_member(&out, "diameter_mm", tools::json_of(c.diameter_mm));
    set_member(&out, "length_mm", tools::json_of(c.length_mm));
    set_member(&out, "clearance_mm", tools::json_of(c.clearance_mm));
    set_member(&out, "skin_mm", tools::json_of(c.skin_mm));
    if (!c.material.empty()) set_member(&out, "material", tools::json_of(c.material));
    return out;
}

JsonValue node(const pieces::Tree& tree, int32_t at) {
    if (at < 0) return tools::json_of(tree.pieces[static_cast<size_t>(~at)]);
    const pieces::Cut& cut = tree.cuts[static_cast<size_t>(at)];
    JsonValue out = object();
    set_member(&out, "normal", tools::json_of(cut.normal));
    set_member(&out, "at_mm", tools::json_of(cut.offset_mm));
    JsonValue connectors, numbers;
    connectors.kind = numbers.kind = JsonKind::kArray;
    for (const pieces::Connector& c : cut.connectors)
        connectors.items.push_back(json_of_connector(c));
    for (const pieces::Number& n : cut.numbers) {
        JsonValue one = object();
        set_member(&one, "at_mm", tools::json_of(n.at_mm));
        set_member(&one, "height_mm", tools::json_of(n.height_mm));
        set_member(&one, "depth_mm", tools::json_of(n.depth_mm));
        numbers.items.push_back(std::move(one));
    }
    if (!connectors.items.empty()) set_member(&out, "connectors", std::move(connectors));
    if (!numbers.items.empty()) set_member(&out, "numbers", std::move(numbers));
    set_member(&out, "back", node(tree, cut.back));
    set_member(&out, "front", node(tree, cut.front));
    return out;
}

}  // namespace

JsonValue json_of(double number) {
    JsonValue out;
    out.kind = JsonKind::kNumber;
    // A millionth of a millimetre.
    out.number = std::round(number * 1e6) / 1e6;
    if (out.number == 0) out.number = 0;
    return out;
}

JsonValue json_of(const std::string& text) {
    JsonValue out;
    out.kind = JsonKind::kString;
    out.text = text;
    return out;
}

JsonValue json_of(const Vec3d& v) {
    JsonValue out;
    out.kind = JsonKind::kArray;
    for (int a = 0; a < 3; ++a)
        out.items.push_back(json_of(v[a]));
    return out;
}

void set_member(JsonValue* object, const std::string& key, JsonValue value) {
    for (JsonMember& m : object->members) {
        if (m.key == key) return void(m.value = std::move(value));
    }
    object->members.push_back({key, 0, 0, std::move(value)});
    object->by_key.clear();
}

JsonValue json_of(const pieces::Tree& tree) {
    return node(tree, 0);
}

std::string text_of(const JsonValue& value) {
    std::string out;
    append(value, 0, 0, &out);
    return out + "\n";
}

std::string text_in_world(const JsonValue& value, size_t key, size_t indent) {
    std::string out;
    constexpr size_t kQuotesAndColon = 4;
    append(value, indent, key + kQuotesAndColon, &out);
    return out;
}

}  // namespace openfab::tools

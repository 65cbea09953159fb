// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/json_text.h"

#include <cmath>

#include "base/text.h"

namespace openfab {

JsonText::JsonText(Layout layout) {
    if (layout == Layout::kCompact) return;
    indented_.emplace(buffer_).SetIndent(' ', 2);
    if (layout == Layout::kIndentedLists)
        indented_->SetFormatOptions(rapidjson::kFormatSingleLineArray);
}

JsonText& JsonText::begin_object() {
    return put([](auto& writer) { writer.StartObject(); });
}
JsonText& JsonText::end_object() {
    return put([](auto& writer) { writer.EndObject(); });
}
JsonText& JsonText::begin_array() {
    return put([](auto& writer) { writer.StartArray(); });
}
JsonText& JsonText::end_array() {
    return put([](auto& writer) { writer.EndArray(); });
}
JsonText& JsonText::key(std::string_view name) {
    return value(name);  // a text in the place of a key is one
}
JsonText& JsonText::value(std::string_view text) {
    const std::string valid = valid_utf8(text);
    return put([&](auto& writer) {
        writer.String(valid.data(), static_cast<rapidjson::SizeType>(valid.size()));
    });
}
JsonText& JsonText::value(double number) {
    if (!std::isfinite(number)) return null();
    // What is whole looks so: 3, not 3.0.
    constexpr double kExact = 9e15;
    if (number == std::floor(number) && std::abs(number) < kExact)
        return value(static_cast<int64_t>(number));
    return put([&](auto& writer) { writer.Double(number); });
}
JsonText& JsonText::value(int64_t number) {
    return put([&](auto& writer) { writer.Int64(number); });
}
JsonText& JsonText::value(bool truth) {
    return put([&](auto& writer) { writer.Bool(truth); });
}
JsonText& JsonText::null() {
    return put([](auto& writer) { writer.Null(); });
}
JsonText& JsonText::value(const JsonValue& read) {
    switch (read.kind) {
        case JsonValue::Kind::kNull:
            return null();
        case JsonValue::Kind::kBool:
            return value(read.boolean);
        case JsonValue::Kind::kNumber:
            return value(read.number);
        case JsonValue::Kind::kString:
            return value(read.text);
        case JsonValue::Kind::kArray:
            begin_array();
            for (const JsonValue& item : read.items)
                value(item);
            return end_array();
        case JsonValue::Kind::kObject:
            begin_object();
            for (const JsonMember& member : read.members)
                key(member.key).value(member.value);
            return end_object();
    }
    return *this;
}

const JsonValue* member_of(const JsonValue& object, std::string_view key) {
    const JsonMember* found = object.find(key);
    return found == nullptr ? nullptr : &found->value;
}

std::string json_string(std::string_view text) {
    return JsonText().value(text).take();
}

std::string error_json(std::string_view message) {
    JsonText out;
    out.begin_object().member("error", message).end_object();
    return out.take();
}

}  // namespace openfab

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/json_text.h"

#include <cmath>

#include "base/text.h"

namespace openfab {

JsonText& JsonText::begin_object() {
    writer_.StartObject();
    return *this;
}
JsonText& JsonText::end_object() {
    writer_.EndObject();
    return *this;
}
JsonText& JsonText::begin_array() {
    writer_.StartArray();
    return *this;
}
JsonText& JsonText::end_array() {
    writer_.EndArray();
    return *this;
}
JsonText& JsonText::key(std::string_view name) {
    const std::string text = valid_utf8(name);
    writer_.Key(text.data(), static_cast<rapidjson::SizeType>(text.size()));
    return *this;
}
JsonText& JsonText::value(std::string_view text) {
    const std::string valid = valid_utf8(text);
    writer_.String(valid.data(), static_cast<rapidjson::SizeType>(valid.size()));
    return *this;
}
JsonText& JsonText::value(double number) {
    if (!std::isfinite(number)) return null();
    // What is whole looks so: 3, not 3.0.
    constexpr double kExact = 9e15;
    if (number == std::floor(number) && std::abs(number) < kExact)
        return value(static_cast<int64_t>(number));
    writer_.Double(number);
    return *this;
}
JsonText& JsonText::value(int64_t number) {
    writer_.Int64(number);
    return *this;
}
JsonText& JsonText::value(bool truth) {
    writer_.Bool(truth);
    return *this;
}
JsonText& JsonText::null() {
    writer_.Null();
    return *this;
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

std::string error_json(std::string_view message) {
    JsonText out;
    out.begin_object().member("error", message).end_object();
    return out.take();
}

}  // namespace openfab

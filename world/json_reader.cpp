// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/json_reader.h"

#include <algorithm>
#include <cmath>

#include "base/near_miss.h"
#include "world/messages.h"

namespace openfab::world {

void JsonReader::fail_at(int32_t line, int32_t column, const std::string& what,
                         const std::string& help) {
    if (!error_) error_ = error_at({file_, line, column}, what, help);
}

void JsonReader::fail_with(const Error& error) {
    if (!error_) error_ = error;
}

bool JsonReader::object(const JsonValue& value, const KeySet& set, const std::string& what) {
    if (!value.is(JsonValue::Kind::kObject)) {
        fail(value, fmt::format("{} is {}", what, value.kind_name()), messages::kMustObject);
        return false;
    }
    const std::vector<std::string> known(set.keys.begin(), set.keys.end());
    for (const JsonMember& member : value.members) {
        if (std::find(known.begin(), known.end(), member.key) != known.end()) continue;
        fail_at(member.line, member.column, fmt::format(messages::kUnknownKey, member.key, what),
                suggest(member.key, known));
        return false;
    }
    for (std::string_view key : set.required) {
        if (value.find(key) != nullptr) continue;
        fail(value, fmt::format(messages::kKeyMissing, what, key), messages::kIsRequired);
        return false;
    }
    return true;
}

bool JsonReader::named_things(const JsonValue& value, const std::string& key) {
    if (!value.is(JsonValue::Kind::kObject)) {
        fail(value, fmt::format("`{}` is {}", key, value.kind_name()), messages::kMustObjectNames);
        return false;
    }
    for (const JsonMember& member : value.members) {
        if (member.key.empty()) {
            fail_at(member.line, member.column, fmt::format(messages::kEmptyName, key),
                    messages::kEmptyNameHelp);
            return false;
        }
        // Messages and stored locations repeat it.
        constexpr size_t kLongest = 1000;
        if (member.key.size() > kLongest) {
            fail_at(member.line, member.column,
                    fmt::format(messages::kNameTooLong, member.key.size(), key, kLongest));
            return false;
        }
    }
    return true;
}

std::string JsonReader::string(const JsonValue& value, const std::string& what) {
    if (value.is(JsonValue::Kind::kString)) return value.text;
    fail(value, fmt::format("{} is {}", what, value.kind_name()), messages::kMustString);
    return {};
}

bool JsonReader::boolean(const JsonValue& value, const std::string& what) {
    if (value.is(JsonValue::Kind::kBool)) return value.boolean;
    fail(value, fmt::format("{} is {}", what, value.kind_name()), messages::kMustTrueFalse);
    return false;
}

double JsonReader::number(const JsonValue& value, const std::string& what, double least,
                          double most) {
    if (!value.is(JsonValue::Kind::kNumber)) {
        fail(value, fmt::format("{} is {}", what, value.kind_name()), messages::kMustNumber);
        return least;
    }
    if (!(value.number >= least && value.number <= most)) {
        fail(value, fmt::format("{} is {:.6g}", what, value.number),
             fmt::format(messages::kMustBetween, least, most));
        return least;
    }
    return value.number;
}

int32_t JsonReader::integer(const JsonValue& value, const std::string& what, int32_t least,
                            int32_t most) {
    const double number = this->number(value, what, least, most);
    if (number != std::floor(number)) {
        fail(value, fmt::format("{} is {:.6g}", what, number), messages::kMustWholeNumber);
        return least;
    }
    return static_cast<int32_t>(number);
}

std::vector<double> JsonReader::numbers(const JsonValue& value, const std::string& what,
                                        size_t count, double most) {
    std::vector<double> out(count);
    if (!value.is(JsonValue::Kind::kArray) || value.items.size() != count) {
        const std::string found = value.is(JsonValue::Kind::kArray)
                                      ? fmt::format(messages::kArrayOf, value.items.size())
                                      : value.kind_name();
        fail(value, fmt::format("{} is {}", what, found),
             fmt::format(messages::kMustArrayNumbers, count));
        return out;
    }
    for (size_t i = 0; i < count; ++i) {
        out[i] = number(value.items[i], fmt::format("{}[{}]", what, i), 0 - most, most);
    }
    return out;
}

std::array<uint8_t, 4> JsonReader::color(const JsonValue& value, const std::string& what,
                                         bool alpha) {
    std::array<uint8_t, 4> out{0, 0, 0, 255};
    const std::string text = string(value, what);
    if (!ok()) return out;
    const bool length_fits = text.size() == 7 || (alpha && text.size() == 9);
    const bool digits = length_fits && text[0] == '#' &&
                        text.find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos;
    if (!digits) {
        fail(value, fmt::format("{} is `{}`", what, text),
             fmt::format(messages::kWriteItAs,
                         alpha ? messages::kColourForms : messages::kOpaqueColourForm));
        return out;
    }
    for (size_t i = 0; i * 2 + 1 < text.size(); ++i) {
        out[i] = static_cast<uint8_t>(std::stoi(text.substr(1 + i * 2, 2), nullptr, 16));
    }
    return out;
}

size_t JsonReader::choice(const JsonValue& value, const std::string& what,
                          const std::vector<std::string>& choices) {
    const std::string text = string(value, what);
    const auto it = std::find(choices.begin(), choices.end(), text);
    if (it != choices.end()) return static_cast<size_t>(it - choices.begin());
    if (value.is(JsonValue::Kind::kString)) {
        fail(value, fmt::format("{} is `{}`", what, text), suggest(text, choices));
    }
    return 0;
}

}  // namespace openfab::world

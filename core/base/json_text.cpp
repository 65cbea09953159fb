// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/json_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/text.h"

namespace openfab {

namespace {

void append_string(std::string_view text, std::string* into) {
    constexpr std::string_view kNamed = "\b\t\n\f\r\"\\", kLetters = "btnfr\"\\";
    *into += '"';
    for (const char c : text) {
        if (const size_t which = kNamed.find(c); which != std::string_view::npos)
            (*into += '\\') += kLetters[which];
        else if (static_cast<unsigned char>(c) < 0x20)
            fmt::format_to(std::back_inserter(*into), "\\u{:04X}", int{c});
        else
            *into += c;
    }
    *into += '"';
}

/// Decimal where that is short, else with an exponent; the digits are the fewest that read back alike.
std::string fraction_text(double number, int most_decimals) {
    constexpr int kLongest = 21, kSmallest = -6;
    char shortest[32];
    const auto [end, error] = std::to_chars(std::begin(shortest), std::end(shortest),
                                            std::abs(number), std::chars_format::scientific);
    const std::string_view scientific(shortest, static_cast<size_t>(end - shortest));
    const size_t e = scientific.find('e');
    std::string digits(scientific.substr(0, e));
    std::erase(digits, '.');
    int exponent = 0;
    const std::string_view power = scientific.substr(e + (scientific[e + 1] == '+' ? 2 : 1));
    std::from_chars(power.data(), power.data() + power.size(), exponent);
    const std::string sign = std::signbit(number) ? "-" : "";
    const int point = exponent + 1, count = static_cast<int>(digits.size());
    if (number == 0) return sign + "0.0";
    if (point > kLongest || (point <= kSmallest && point >= -most_decimals)) {
        if (count > 1) digits.insert(1, ".");
        return fmt::format("{}{}e{}", sign, digits, exponent);
    }
    if (point < -most_decimals) return sign + "0.0";
    if (point <= 0) digits.insert(0, static_cast<size_t>(1 - point), '0');
    const auto before = static_cast<size_t>(std::max(point, 1));
    if (digits.size() <= before) {
        digits.resize(before, '0');
        return sign + digits + ".0";
    }
    digits.insert(before, ".");
    const size_t decimals = digits.size() - before - 1;
    if (decimals > static_cast<size_t>(most_decimals)) {
        digits.resize(before + 1 + static_cast<size_t>(most_decimals));
        while (digits.back() == '0' && digits[digits.size() - 2] != '.')
            digits.pop_back();
    }
    return sign + digits;
}

}  // namespace

void JsonText::break_line() {
    constexpr size_t kIndent = 2;
    (text_ += '\n').append(levels_.size() * kIndent, ' ');
}

/// Writes what stands between the value before and the next one.
void JsonText::separate() {
    if (levels_.empty()) return;
    Level& level = levels_.back();
    const bool compact = layout_ == Layout::kCompact;
    const bool after_key = level.is_object && level.count % 2 == 1;
    if (after_key)
        text_ += compact ? ":" : ": ";
    else if (level.count > 0)
        text_ += ',';
    if (!compact && !after_key) {
        if (!level.one_line)
            break_line();
        else if (level.count > 0)
            text_ += ' ';
    }
    ++level.count;
}

JsonText& JsonText::put(std::string_view token) {
    separate();
    text_ += token;
    return *this;
}

void JsonText::begin(char mark, Level level) {
    separate();
    text_ += mark;
    levels_.push_back(level);
}

JsonText& JsonText::end(char mark) {
    const Level level = levels_.back();
    levels_.pop_back();
    if (layout_ != Layout::kCompact && level.count > 0 && !level.one_line) break_line();
    text_ += mark;
    return *this;
}

JsonText& JsonText::begin_object() {
    begin('{', {.is_object = true});
    return *this;
}
JsonText& JsonText::end_object() {
    return end('}');
}
JsonText& JsonText::begin_array() {
    begin('[', {.one_line = layout_ == Layout::kIndentedLists});
    return *this;
}
JsonText& JsonText::begin_list() {
    begin('[', {.one_line = true});
    return *this;
}
JsonText& JsonText::end_array() {
    return end(']');
}
JsonText& JsonText::key(std::string_view name) {
    return value(name);  // a text in the place of a key is one
}
JsonText& JsonText::value(std::string_view text) {
    separate();
    append_string(valid_utf8(text), &text_);
    return *this;
}
JsonText& JsonText::value(double number) {
    // What is whole looks so: 3, not 3.0.
    constexpr double kExact = 9e15;
    if (number == std::floor(number) && std::abs(number) < kExact)
        return value(static_cast<int64_t>(number));
    return fraction(number);
}
JsonText& JsonText::fraction(double number, int most_decimals) {
    if (!std::isfinite(number)) return null();
    return put(fraction_text(number, most_decimals));
}
JsonText& JsonText::value(int64_t number) {
    return put(std::to_string(number));
}
JsonText& JsonText::value(bool truth) {
    return put(truth ? "true" : "false");
}
JsonText& JsonText::null() {
    return put("null");
}
JsonText& JsonText::value(const JsonValue& read) {
    switch (read.kind) {
        case JsonValue::Kind::kNull:
            return null();
        case JsonValue::Kind::kBool:
            return value(read.boolean);
        case JsonValue::Kind::kNumber:
            return read.is_whole ? value(read.number) : fraction(read.number);
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

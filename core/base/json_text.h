// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// JSON that programs write: an API's answers, reports for people and programs.

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "base/json.h"

namespace openfab {

/// Writes JSON; text that is not UTF-8 is made so.
class JsonText {
  public:
    enum class Layout {
        kCompact,
        kIndented,      ///< a line for each item
        kIndentedLists  ///< likewise, but lists are on one line
    };
    explicit JsonText(Layout layout = Layout::kCompact) : layout_(layout) {}

    JsonText& begin_object();
    JsonText& end_object();
    JsonText& begin_array();
    /// Begins an array that is on one line in any layout.
    JsonText& begin_list();
    JsonText& end_array();
    JsonText& key(std::string_view name);
    JsonText& value(std::string_view text);
    JsonText& value(const char* text) { return value(std::string_view(text)); }
    JsonText& value(const std::string& text) { return value(std::string_view(text)); }
    /// Writes the shortest number that reads back alike: 3 for 3.0, null for what is not finite.
    JsonText& value(double number);
    JsonText& value(int64_t number);
    JsonText& value(int32_t number) { return value(int64_t{number}); }
    JsonText& value(bool truth);
    JsonText& null();
    /// Writes a value that was read, with numbers to the last bit.
    JsonText& value(const JsonValue& read);
    /// Writes a number with a fraction, 3.0 for 3, which is cut after so many decimals.
    JsonText& fraction(double number, int most_decimals = std::numeric_limits<int>::max());
    template <typename T>
    JsonText& member(std::string_view name, const T& what) {
        return key(name).value(what);
    }
    const std::string& text() const { return text_; }
    std::string take() { return std::move(text_); }

  private:
    struct Level {
        bool is_object = false, one_line = false;
        size_t count = 0;  ///< of values, keys among them
    };
    void begin(char mark, Level level);
    JsonText& end(char mark);
    void separate();
    void break_line();
    JsonText& put(std::string_view token);

    Layout layout_;
    std::string text_;
    std::vector<Level> levels_;
};

/// Returns text as JSON has it, in quotes.
std::string json_string(std::string_view text);

/// Returns the value of a member, or null.
const JsonValue* member_of(const JsonValue& object, std::string_view key);

/// `{"error": "…"}`
std::string error_json(std::string_view message);

}  // namespace openfab

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// JSON that programs write: an API's answers, reports for people and programs.

#include <rapidjson/prettywriter.h>
#include <rapidjson/stringbuffer.h>

#include <optional>
#include <string>
#include <string_view>

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
    explicit JsonText(Layout layout = Layout::kCompact);

    JsonText& begin_object();
    JsonText& end_object();
    JsonText& begin_array();
    JsonText& end_array();
    JsonText& key(std::string_view name);
    JsonText& value(std::string_view text);
    JsonText& value(const char* text) { return value(std::string_view(text)); }
    JsonText& value(const std::string& text) { return value(std::string_view(text)); }
    JsonText& value(double number);
    JsonText& value(int64_t number);
    JsonText& value(int32_t number) { return value(int64_t{number}); }
    JsonText& value(bool truth);
    JsonText& null();
    /// Writes a value that was read, with numbers to the last bit.
    JsonText& value(const JsonValue& read);
    template <typename T>
    JsonText& member(std::string_view name, const T& what) {
        return key(name).value(what);
    }
    std::string take() const { return {buffer_.GetString(), buffer_.GetSize()}; }

  private:
    template <typename Write>
    JsonText& put(const Write& write) {
        indented_ ? write(*indented_) : write(compact_);
        return *this;
    }

    rapidjson::StringBuffer buffer_;
    rapidjson::Writer<rapidjson::StringBuffer> compact_{buffer_};
    std::optional<rapidjson::PrettyWriter<rapidjson::StringBuffer>> indented_;
};

/// Returns text as JSON has it, in quotes.
std::string json_string(std::string_view text);

/// Returns the value of a member, or null.
const JsonValue* member_of(const JsonValue& object, std::string_view key);

/// `{"error": "…"}`
std::string error_json(std::string_view message);

}  // namespace openfab

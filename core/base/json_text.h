// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// JSON that programs write and do not keep: an API's answers.

#include <rapidjson/stringbuffer.h>
#include <rapidjson/writer.h>

#include <string>
#include <string_view>

#include "base/json.h"

namespace openfab {

/// Writes JSON; text that is not UTF-8 is made so.
class JsonText {
  public:
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
    std::string take() const { return buffer_.GetString(); }

  private:
    rapidjson::StringBuffer buffer_;
    rapidjson::Writer<rapidjson::StringBuffer> writer_{buffer_};
};

/// Returns the value of a member, or null.
const JsonValue* member_of(const JsonValue& object, std::string_view key);

/// `{"error": "…"}`
std::string error_json(std::string_view message);

}  // namespace openfab

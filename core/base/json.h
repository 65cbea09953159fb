// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// JSON with positions: a small tree in which every key and value knows its line and column. Keys
// keep their order in the file. Strict JSON: no comments, no trailing commas, no duplicate keys,
// UTF-8.

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace openfab {

struct JsonMember;

struct JsonValue {
    enum class Kind { kNull, kBool, kNumber, kString, kArray, kObject };
    Kind kind = Kind::kNull;
    bool boolean = false;
    bool is_whole = false;  ///< a number without fraction and exponent
    double number = 0;
    std::string text;
    std::vector<JsonValue> items;
    std::vector<JsonMember> members;
    std::vector<int32_t> by_key;  ///< member indices sorted by key; large objects only
    int32_t line = 0;
    int32_t column = 0;  ///< one-based, in code points

    bool is(Kind wanted) const { return kind == wanted; }
    /// "a number", "an object", …
    const char* kind_name() const;
    /// Returns a number that is written without fraction and exponent, where a double holds it.
    std::optional<int64_t> whole() const;
    /// Returns the member of this key, or null. Large objects are searched by bisection.
    const JsonMember* find(std::string_view key) const;
};

struct JsonMember {
    std::string key;
    int32_t line = 0;
    int32_t column = 0;
    JsonValue value;
};

/// Returns the memory that a tree takes, the value itself included.
int64_t json_bytes(const JsonValue& value);

constexpr size_t kMostJsonValues = 1'000'000;

/// Parses `text`; errors are located in `name`. At most 32 levels deep and so many values, and a
/// tree that with the text takes no more than `memory_bytes`. Numbers are the nearest doubles.
Result<JsonValue> parse_json(std::string_view text, const std::string& name,
                             int64_t memory_bytes = std::numeric_limits<int64_t>::max(),
                             size_t most_values = kMostJsonValues);

/// Reads a whole file of at most `limit` bytes.
Result<std::string> read_text_file(const std::filesystem::path& file, size_t limit,
                                   const std::vector<std::filesystem::path>& roots = {});

}  // namespace openfab

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads typed values out of a JSON tree. The first error is stored with its location; after it,
// reading continues with harmless values, so that callers need no error path until the end.

#include <fmt/format.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/check.h"
#include "base/json.h"
#include "base/result.h"
#include "world/world.h"
#include "world/world_keys.h"

namespace openfab::world {

class JsonReader {
  public:
    explicit JsonReader(std::string file) : file_(std::move(file)) {}

    bool ok() const { return !error_.has_value(); }
    const Error& error() const {
        OPENFAB_CHECK(!ok());
        return *error_;
    }

    SourceLocation location(const JsonValue& value) const {
        return {file_, value.line, value.column};
    }
    void fail(const JsonValue& value, const std::string& what, const std::string& help = {}) {
        fail_at(value.line, value.column, what, help);
    }
    void fail_at(int32_t line, int32_t column, const std::string& what,
                 const std::string& help = {});
    /// Stores an error whose message already names its location.
    void fail_with(const Error& error);

    /// Checks that `value` is an object whose keys are in `set` and that required ones are there.
    /// `what` names it in messages: "material `red`".
    bool object(const JsonValue& value, const KeySet& set, const std::string& what);
    /// Checks that `value` is an object of named things.
    bool named_things(const JsonValue& value, const std::string& key);

    std::string string(const JsonValue& value, const std::string& what);
    bool boolean(const JsonValue& value, const std::string& what);
    double number(const JsonValue& value, const std::string& what, double least, double most);
    /// Reads `#rrggbb`, or with an alpha `#rrggbbaa`; opaque black after an error.
    std::array<uint8_t, 4> color(const JsonValue& value, const std::string& what, bool alpha);
    int32_t integer(const JsonValue& value, const std::string& what, int32_t least, int32_t most);
    /// Reads an array of `count` numbers.
    std::vector<double> numbers(const JsonValue& value, const std::string& what, size_t count,
                                double most);
    /// Returns the index of the string in `choices`; 0 after an error.
    size_t choice(const JsonValue& value, const std::string& what,
                  const std::vector<std::string>& choices);

  private:
    std::string file_;
    std::optional<Error> error_;
};

}  // namespace openfab::world

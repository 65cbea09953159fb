// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Members of what our programs write as JSON; what is not there is empty, or 0.

#include <cstdint>
#include <string>
#include <string_view>

#include "base/json_text.h"

namespace openfab::client {

inline std::string text_member(const JsonValue& object, std::string_view key) {
    const JsonValue* const member = member_of(object, key);
    return member != nullptr ? member->text : std::string();
}

inline double number_member(const JsonValue& object, std::string_view key) {
    const JsonValue* const member = member_of(object, key);
    return member != nullptr ? member->number : 0;
}

}  // namespace openfab::client

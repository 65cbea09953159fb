// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Words of other shading languages, and what to write for them here. An answer is the text of a
// help line, empty where the word is none.

#include <string>
#include <string_view>

namespace openfab::sema {

/// What simply has another name here: that name, else empty.
std::string renamed_type(std::string_view name);
std::string renamed_function(std::string_view name);

std::string habit_of_type(std::string_view name);
std::string habit_of_function(std::string_view name);
std::string habit_of_attribute(std::string_view name, bool surface);
std::string habit_of_name(std::string_view name);

}  // namespace openfab::sema

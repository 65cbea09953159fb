// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What people write who come from another language, where the grammar has no place for it: GLSL,
// C++, Python, Rust. Words that are known but wrong are in compiler/check/habits.h.

#include <string>
#include <string_view>

namespace openfab::syntax {

/// The tokens about a place where something else was expected; empty where there is none.
struct Surroundings {
    std::string_view first;     ///< of the statement or declaration
    std::string_view previous;  ///< before the one that was found
    std::string_view found;
    std::string_view next;
};

/// A line of help, or "".
std::string habit_of_syntax(const Surroundings& at);

/// The form of the varyings, for what stands in their place.
extern const char* const kVaryingsForm;
extern const char* const kSurfaceVaryingsForm;

}  // namespace openfab::syntax

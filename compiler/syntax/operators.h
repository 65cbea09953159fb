// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the parser and the formatter both know of operators.

#include <string_view>

#include "compiler/syntax/token.h"

namespace openfab::syntax {

/// The levels of binary operators: `||` has the first, `*` the last.
constexpr int kLastPrecedence = 10;

/// Returns the level of a binary operator, higher where it binds tighter; 0 for other tokens.
int precedence(const Token& token);

/// True for `=`, `+=` and the like.
bool is_assignment(const Token& token);

/// True for `float`, `int3`, `bool2x2`, `Material` and the like: `(name)` then starts a cast.
bool is_builtin_type_name(std::string_view name);

/// True if `(name)` and the token after it begin a cast.
bool starts_cast(const Token& open, const Token& name, const Token& close, const Token& next);

}  // namespace openfab::syntax

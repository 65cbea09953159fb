// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the parser and the formatter both know of operators.

#include <functional>
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

/// Returns the number of tokens of `(name)` or `(name[2][3])` if that begins a cast, else 0. `peek(i)` is the i-th
/// token from here on; behind the last it may be any that ends a file.
size_t cast_length(const std::function<const Token&(size_t)>& peek);

}  // namespace openfab::syntax

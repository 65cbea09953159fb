// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Halide.h>

#include <cstdint>
#include <optional>

namespace openfab::lower {

/// Returns the value of an expression that is an integer constant. Halide's own function returns a
/// pointer into the expression, and a value since version 19.
inline std::optional<int64_t> integer_constant(const Halide::Expr& e) {
    if (!e.defined()) return std::nullopt;
    const auto value = Halide::Internal::as_const_int(e);
    return value ? std::optional<int64_t>(*value) : std::nullopt;
}

}  // namespace openfab::lower

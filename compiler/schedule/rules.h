// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The directives of schedules: their arguments, and why Halide's others are not among them.

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace openfab::schedule {

/// The number that every schedule has: floats in a vector of the target.
constexpr const char* kVectorLanes = "vector_lanes";

/// What an argument of a directive is.
enum class ArgKind {
    kVar,     ///< a loop of the line's Func, or of the Func before it (compute_at, store_at)
    kNewVar,  ///< the name of a loop that the directive makes
    kFunc,
    kNumber,
    kMemory,     ///< `heap` or `stack`
    kCondition,  ///< the whole of the arguments: `n >= 16`, `n % 4 == 0`
};

/// What a directive is about: loops of one definition of a Func, or the Func as a whole.
enum class Scope { kLoops, kFunc };

struct DirectiveRule {
    const char* name;
    std::vector<ArgKind> args;
    size_t least_args;
    bool any_number;   ///< the last argument may be repeated
    const char* form;  ///< for messages
};

/// Returns the rule of a directive, or null.
const DirectiveRule* find_rule(std::string_view name);
std::vector<std::string> directive_names();

/// Returns why a directive of Halide's is not allowed; empty if it has none of that name.
std::string why_refused(std::string_view name);

/// How to mend an unknown word: "did you mean `x`?", else "it has x, y", where `all` is "it has".
std::string near_or_all(std::string_view word, std::span<const std::string> names, const char* all);

}  // namespace openfab::schedule

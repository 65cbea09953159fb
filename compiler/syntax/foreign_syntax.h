// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Help for syntax of other languages (GLSL, C++, Python, Rust) that OpenFL does not have. Names of
// other languages are in compiler/check/foreign_names.h.

#include <cstdint>
#include <string>
#include <string_view>

#include "compiler/syntax/ast.h"

namespace openfab::syntax {

/// The tokens around an unexpected one; empty where there is none.
struct Surroundings {
    std::string_view first;     ///< of the statement or declaration
    std::string_view previous;  ///< before the unexpected one
    std::string_view found;
    std::string_view next;
    bool same_line = true;  ///< `previous` and `found` stand on one line
};

/// What OpenFL has instead.
struct ForeignSyntax {
    /// What its `ours` replaces.
    enum class Fix : uint8_t {
        kNone,
        kFound,
        kPrevious,
        kFirst,
        kBoth,        ///< the previous token and the unexpected one
        kNamespace,   ///< `name::`
        kDefinition,  ///< `:=`
        kPercent,     ///< `50 %`
        kBrackets,    ///< `[` and the `]` that matches it
    };
    std::string help;  ///< empty if nothing is known
    Fix fix = Fix::kNone;
    std::string ours;
};

ForeignSyntax foreign_syntax(const Surroundings& at);

/// Returns the syntax of a stage's varyings, for messages.
const char* varyings_form(ast::StageKind stage);

}  // namespace openfab::syntax

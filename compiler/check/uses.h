// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the names in a source refer to and what types its expressions have, as the checker finds out: for editors.

#include <string>
#include <vector>

#include "compiler/check/tree.h"
#include "compiler/source/span.h"

namespace openfab::check {

enum class UseKind : uint8_t { kSymbol, kFunction, kMember };

/// A name in the source. It outlives the checker; types and functions belong to the Program.
struct Use {
    source::Span span;      ///< of the name
    source::Span declared;  ///< of the name where it is declared; file 0 if that is nowhere
    UseKind kind = UseKind::kSymbol;
    SymbolKind symbol = SymbolKind::kLocal;  ///< of a symbol
    std::string name;
    Type type;
    bool is_const = false;
    const Function* function = nullptr;
};

struct Uses {
    std::vector<Use> names;
    struct Typed {
        source::Span span;
        Type type;
    };
    std::vector<Typed> expressions;
};

/// Returns the members of a stage's attributes: Type::is_attributes().
std::vector<StructMember> attribute_members(const Type& attributes);

}  // namespace openfab::check

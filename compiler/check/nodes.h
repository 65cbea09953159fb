// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Nodes of the checked tree, and what several classes of the checker ask of them.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/check/tree.h"
#include "compiler/diag/sink.h"
#include "compiler/syntax/ast.h"

namespace openfab::check {

ExprPtr make(ExprKind kind, const Type& type, const source::Span& span);
/// Returns a node with an error, which reports nothing more.
ExprPtr poison(const source::Span& span);

/// Returns the bits of a scalar if they are known at this point: without functions and uniforms.
std::optional<uint32_t> known_bits(const Expr& expr);
/// Returns the common type of an operator's operands; the shorter vector wins, with a warning.
Type common_type(const Type& a, const Type& b);
/// Returns `(float2, int)`, for messages.
std::string type_list(const std::vector<ExprPtr>& args);
/// Returns the first part of an expression that has a side effect, or null.
const Expr* side_effect(const Expr& expr);
/// True if an error was reported for one of them.
bool any_error(const std::vector<ExprPtr>& args);
/// Reports that a call has `count` arguments where `right` is right.
void wrong_count(diag::Sink* sink, const ast::Expr& call, std::string_view name,
                 const std::string& right, size_t count);

/// Checks any expression in the current scopes: what the classes that check one kind of them ask for its parts.
class Expressions {
  public:
    virtual ExprPtr expression(const ast::Expr& expr) = 0;
    /// Checks the arguments of a call, from number `first` on.
    std::vector<ExprPtr> arguments(const ast::Expr& call, size_t first = 1) {
        std::vector<ExprPtr> out;
        for (size_t i = first; i < call.args.size(); ++i)
            out.push_back(expression(*call.args[i]));
        return out;
    }

  protected:
    Expressions() = default;
    Expressions(const Expressions&) = default;
    Expressions& operator=(const Expressions&) = default;
    ~Expressions() = default;
};

}  // namespace openfab::check

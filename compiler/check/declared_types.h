// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/check/conversions.h"
#include "compiler/check/names.h"
#include "compiler/check/nodes.h"

namespace openfab::check {

/// The types that declarations name, and those that they declare.
class DeclaredTypes {
  public:
    DeclaredTypes(diag::Sink* sink, Names* names, const Conversions& conversions,
                  Expressions* expressions, std::vector<std::unique_ptr<StructType>>* structs)
        : sink_(sink),
          names_(*names),
          conversions_(conversions),
          expressions_(*expressions),
          structs_(*structs) {}

    Type declared_type(const ast::TypeRef& ref);
    /// Returns the type of a variable with its array extents; an error type after a message.
    Type declared_type(const ast::Variable& v);
    /// The same of a type's name and its extents; `init` counts an outermost one that is left out, if it is a list.
    Type array_type(const ast::TypeRef& of, std::string_view name,
                    std::span<const ast::ExprPtr> extents, const source::Span& brackets,
                    const ast::Expr* init);
    std::optional<int32_t> constant_int(const ast::Expr& expr, const char* what);
    void declare_struct(const ast::Struct& from);
    /// Keeps the name of a type that is declared.
    void keep(std::unique_ptr<Symbol> name) { declared_.push_back(std::move(name)); }

  private:
    std::optional<int> extent(const ast::Expr* written, std::string_view name,
                              const source::Span& brackets, const ast::Expr* counted);

    diag::Sink* sink_;
    Names& names_;
    const Conversions& conversions_;
    Expressions& expressions_;
    std::vector<std::unique_ptr<StructType>>& structs_;
    std::vector<std::unique_ptr<Symbol>> declared_;  ///< the names
};

}  // namespace openfab::check

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/check/statement_checker.h"

namespace openfab::check {

/// Returns a text without what separates names and labels of enums.
std::string one_line(std::string_view text);
/// Reports the calls that close a cycle.
void check_recursion(const std::vector<std::unique_ptr<Function>>& functions, diag::Sink* sink);

/// Structs, enums, constants and functions of a file or a fablet; private to compiler/check.
class Declarations {
  public:
    Declarations(diag::Sink* sink, Names* names, Place* place, UnknownNames* unknown,
                 ExpressionChecker* expressions, StatementChecker* statements)
        : sink_(sink),
          names_(*names),
          place_(*place),
          unknown_(*unknown),
          expressions_(*expressions),
          statements_(*statements) {}

    /// Declares what a scope has, `uniforms` too, in the order in which it may be used.
    void scope(const ast::Scope& from, const std::vector<ast::Variable>& uniforms,
               const std::function<void(const ast::Variable&)>& check_uniform,
               std::vector<std::unique_ptr<Symbol>>* constants,
               std::vector<std::unique_ptr<Function>>* functions);

  private:
    void declare_enum(const ast::Enum& from, std::vector<std::unique_ptr<Symbol>>* constants);
    void constant(const ast::Variable& v, std::vector<std::unique_ptr<Symbol>>* to);
    void declare_functions(const std::vector<ast::Function>& from,
                           std::vector<std::unique_ptr<Function>>* to);
    void check_bodies(const std::vector<ast::Function>& from,
                      const std::vector<std::unique_ptr<Function>>& to);
    std::unique_ptr<Symbol> parameter(const ast::Variable& v);

    diag::Sink* sink_;
    Names& names_;
    Place& place_;
    UnknownNames& unknown_;
    ExpressionChecker& expressions_;
    StatementChecker& statements_;
};

}  // namespace openfab::check

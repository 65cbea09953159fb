// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Expressions, the lowest of three layers, private to compiler/check: statements (statement_checker.h) and declarations
// (checker.h) build on it. Each kind of expression is checked by a class of its own.

#include <memory>
#include <vector>

#include "compiler/check/assignments.h"
#include "compiler/check/calls.h"
#include "compiler/check/operators.h"
#include "compiler/check/parts.h"

namespace openfab::check {

class ExpressionChecker final : public Expressions {
  public:
    ExpressionChecker(diag::Sink* sink, Names* names, const Place& place, UnknownNames* unknown,
                      std::vector<std::unique_ptr<StructType>>* structs)
        : sink_(sink),
          names_(*names),
          place_(place),
          unknown_(*unknown),
          conversions_(sink),
          rules_(sink, place),
          targets_(sink, place),
          types_(sink, names, conversions_, this, structs),
          initializers_(sink, conversions_, this),
          conditions_(sink, conversions_, this),
          constructors_(sink, conversions_, &types_, initializers_, this),
          operators_(sink, *names, *unknown, conversions_, this),
          assignments_(sink, *names, unknown, conversions_, targets_, initializers_, this),
          parts_(sink, names, place, *unknown, conversions_, this),
          calls_(sink, names, place, rules_, *unknown, conversions_, targets_, conditions_,
                 constructors_, this) {}
    ExpressionChecker(const ExpressionChecker&) = delete;
    ExpressionChecker& operator=(const ExpressionChecker&) = delete;
    ~ExpressionChecker() = default;

    ExprPtr expression(const ast::Expr& expr) override;

    const Conversions& conversions() const { return conversions_; }
    DeclaredTypes& types() { return types_; }
    const Initializers& initializers() const { return initializers_; }
    const Conditions& conditions() const { return conditions_; }

  private:
    ExprPtr of_kind(const ast::Expr& expr);
    ExprPtr name(const ast::Expr& expr);
    ExprPtr comma(const ast::Expr& expr);

    diag::Sink* sink_;
    Names& names_;
    const Place& place_;
    UnknownNames& unknown_;
    const Conversions conversions_;
    const StageRules rules_;
    const Targets targets_;
    DeclaredTypes types_;
    const Initializers initializers_;
    const Conditions conditions_;
    const Constructors constructors_;
    const Operators operators_;
    const Assignments assignments_;
    const Parts parts_;
    const Calls calls_;
};

}  // namespace openfab::check

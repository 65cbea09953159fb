// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/check/expression_checker.h"

namespace openfab::check {

/// The uniforms of fablets; private to compiler/check.
class Uniforms {
  public:
    Uniforms(diag::Sink* sink, Names* names, Place* place, ExpressionChecker* expressions)
        : sink_(sink), names_(*names), place_(*place), expressions_(*expressions) {}
    void check(const ast::Variable& v, Fablet* to);

  private:
    bool assign_index(const ast::Variable& v, const Type& type, ir::Uniform* uniform, Fablet* to);
    void annotations(const ast::Variable& v, Symbol* symbol, ir::Uniform* uniform);
    void add_choices(const ast::Variable& v, const Type& element, ir::Uniform* uniform) const;

    diag::Sink* sink_;
    Names& names_;
    Place& place_;
    ExpressionChecker& expressions_;
};

}  // namespace openfab::check

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/check/expression_checker.h"

namespace openfab::check {

/// The varyings of stages; private to compiler/check.
class Varyings {
  public:
    Varyings(diag::Sink* sink, Names* names, Place* place, ExpressionChecker* expressions)
        : sink_(sink), names_(*names), place_(*place), expressions_(*expressions) {}
    void check(const ast::Variable& v, const ast::Stage& stage, Fablet* to);

  private:
    void of_surface(const ast::Variable& v, const Type& type, Fablet* to);
    void nearest(const ast::Variable& v, const Type& type, Fablet* to);
    void of_shape(const ast::Variable& v, const Type& type, Fablet* to);
    void parent(const ast::Variable& v, const Type& type, Fablet* to);
    void check_against_shape(const ast::Variable& v, const Type& type, const Fablet& to);
    void add(Stage* stage, SymbolKind kind, const ast::Variable& v, const Type& type, size_t index);

    diag::Sink* sink_;
    Names& names_;
    Place& place_;
    ExpressionChecker& expressions_;
};

}  // namespace openfab::check

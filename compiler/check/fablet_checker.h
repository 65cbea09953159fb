// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/check/declarations.h"
#include "compiler/check/uniforms.h"
#include "compiler/check/varyings.h"

namespace openfab::check {

/// Fablets and their stages; private to compiler/check.
class FabletChecker {
  public:
    FabletChecker(diag::Sink* sink, Names* names, Place* place, UnknownNames* unknown,
                  ExpressionChecker* expressions, StatementChecker* statements,
                  Declarations* declarations)
        : sink_(sink),
          names_(*names),
          place_(*place),
          unknown_(*unknown),
          statements_(*statements),
          declarations_(*declarations),
          uniforms_(sink, names, place, expressions),
          varyings_(sink, names, place, expressions) {}
    void check(const ast::Fablet& from, Fablet* to);
    /// Gives fablets without `@Dither` a rule.
    void set_rule(const Function* rule) { rule_ = rule; }

  private:
    void stages(const ast::Fablet& from, Fablet* to);
    void check_shape(const ast::Stage& from, Fablet* to);
    void check_grow(const ast::Stage& from, const ast::Stage* shape, Fablet* to);
    void body(const ast::Stage& from, Stage* to, StageContext context, const Type& result);

    diag::Sink* sink_;
    Names& names_;
    Place& place_;
    UnknownNames& unknown_;
    StatementChecker& statements_;
    Declarations& declarations_;
    Uniforms uniforms_;
    Varyings varyings_;
    const Function* rule_ = nullptr;  ///< may be null
};

}  // namespace openfab::check

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "compiler/check/nodes.h"
#include "compiler/check/overloads.h"
#include "compiler/check/unknown_names.h"

namespace openfab::check {

/// Calls that differentiate a function of the program.
class Fields {
  public:
    Fields(diag::Sink* sink, Names* names, const UnknownNames& unknown, const Overloads& overloads,
           Expressions* expressions)
        : sink_(sink),
          names_(*names),
          unknown_(unknown),
          overloads_(overloads),
          expressions_(*expressions) {}
    static bool takes(std::string_view name);
    ExprPtr call(const ast::Expr& expr) const;

  private:
    diag::Sink* sink_;
    Names& names_;
    const UnknownNames& unknown_;
    const Overloads& overloads_;
    Expressions& expressions_;
};

}  // namespace openfab::check

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is translated for its value: the classes that translate one kind of expressions ask for its parts.

#include "compiler/check/tree.h"
#include "compiler/translate/formulas.h"

namespace openfab::translate {

class Expressions {
  public:
    virtual Value expression(const check::Expr& expr) = 0;
    ir::ValueId scalar(const check::Expr& expr) { return expression(expr)[0]; }

  protected:
    Expressions() = default;
    Expressions(const Expressions&) = default;
    Expressions& operator=(const Expressions&) = default;
    ~Expressions() = default;
};

}  // namespace openfab::translate

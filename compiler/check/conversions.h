// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/check/tree.h"
#include "compiler/diag/sink.h"

namespace openfab::check {

/// Conversions of values, written out in the tree.
class Conversions {
  public:
    explicit Conversions(diag::Sink* sink) : sink_(sink) {}
    /// Converts as an assignment does, with warnings.
    ExprPtr implicit(ExprPtr value, const Type& to) const;
    /// Converts as a cast does.
    ExprPtr explicitly(ExprPtr value, const Type& to) const;
    /// Warns about `1 / 2` where a float is expected: it is 0. Constants only; `i / 4` may be intended.
    void check_division(const Expr& value, const Type& to) const;
    /// Adds what to write instead of an invalid conversion.
    static void help(const Type& from, const Type& to, diag::Diagnostic* d);

  private:
    void check_fits(const Expr& value, const Type& to) const;

    diag::Sink* sink_;
};

}  // namespace openfab::check

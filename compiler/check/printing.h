// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "compiler/check/conditions.h"
#include "compiler/check/stage_rules.h"

namespace openfab::check {

class Printing {
  public:
    Printing(diag::Sink* sink, const Place& place, const StageRules& rules,
             const Conversions& conversions, const Conditions& conditions, Expressions* expressions)
        : sink_(sink),
          place_(place),
          rules_(rules),
          conversions_(conversions),
          conditions_(conditions),
          expressions_(*expressions) {}
    ExprPtr call(const ast::Expr& expr) const;

  private:
    bool prints(const Type& type, Base wanted, const source::Span& at,
                std::string_view conversion) const;
    ExprPtr flattened(ExprPtr value, Base to) const;
    bool match_format(const ast::Expr& literal, std::vector<ExprPtr>* values, size_t first,
                      std::string* out) const;

    diag::Sink* sink_;
    const Place& place_;
    const StageRules& rules_;
    const Conversions& conversions_;
    const Conditions& conditions_;
    Expressions& expressions_;
};

}  // namespace openfab::check

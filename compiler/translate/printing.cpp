// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/printing.h"

#include <utility>

#include "compiler/check/check.h"

namespace openfab::translate {

using ir::ValueId;

/// The values are those of the path that reaches the call.
Value Printing::call(const check::Expr& expr) {
    if (rules_.refuse_in_dither(expr, expr.is_assert ? "assert" : "printf")) return {};
    if (!enabled || budget_.gave_up) return {};
    if (rules_.refuse_in_shape(expr, expr.is_assert ? "assert" : "printf", check::kNoPrintsInShape))
        return {};
    ValueId guard = paths_.live;
    std::vector<ValueId> args = {guard};
    for (size_t i = 0; i < expr.args.size(); ++i) {
        const Value part = expressions_.expression(*expr.args[i]);
        if (expr.is_assert && i == 0) {
            args[0] = emit_.logical_and(guard, emit_.logical_not(part[0]));
        } else {
            args.insert(args.end(), part.begin(), part.end());
        }
    }
    if (budget_.gave_up || emit_.is_false(args[0])) return {};
    emit_.set_span(expr.span);
    emit_.printf(static_cast<int32_t>(stage_->printfs.size()), std::move(args));
    stage_->printfs.push_back({expr.text, expr.is_assert, expr.span, {}, 0, 0});
    return {};
}

}  // namespace openfab::translate

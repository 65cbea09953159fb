// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "compiler/translate/translate_state.h"

namespace openfab::sema {

using ir::ValueId;

/// Nothing at all unless printing was asked for; the values then belong to the path that gets here.
Value StageTranslator::print(const Expr& expr) {
    if (!options_.prints || gave_up_) return {};
    ValueId guard = live_;
    std::vector<ValueId> args = {guard};
    for (size_t i = 0; i < expr.args.size(); ++i) {
        const Value part = expression(*expr.args[i]);
        if (expr.is_assert && i == 0) {
            args[0] = emit_.logical_and(guard, emit_.logical_not(part[0]));
        } else {
            args.insert(args.end(), part.begin(), part.end());
        }
    }
    if (gave_up_ || emit_.is_false(args[0])) return {};
    emit_.set_span(expr.span);
    emit_.print(static_cast<int32_t>(stage_->prints.size()), std::move(args));
    stage_->prints.push_back({expr.text, expr.is_assert, expr.span, {}, 0, 0});
    return {};
}

}  // namespace openfab::sema

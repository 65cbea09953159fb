// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "compiler/translate/stage_translator.h"

namespace openfab::translate {

using ir::ValueId;

/// Emits nothing unless printf is enabled. The values are those of the path that reaches the call.
Value StageTranslator::printf_call(const check::Expr& expr) {
    if (refuse_in_dither(expr, expr.is_assert ? "assert" : "printf")) return {};
    if (!options_.enable_printf || gave_up_) return {};
    if (refuse_in_shape(expr, expr.is_assert ? "assert" : "printf", check::kNoPrintsInShape))
        return {};
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
    emit_.printf(static_cast<int32_t>(stage_->printfs.size()), std::move(args));
    stage_->printfs.push_back({expr.text, expr.is_assert, expr.span, {}, 0, 0});
    return {};
}

}  // namespace openfab::translate

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/budget.h"

#include <fmt/format.h>

namespace openfab::translate {

namespace {

constexpr int kMaxInlineDepth = 64;

}  // namespace

bool Budget::too_complex(const source::Span& span) {
    if (gave_up) return true;
    const bool long_run = ++steps > step_limit;
    const bool operations = emit_.operations_by_steps() > check::kMaxOperations;
    if (!long_run && !operations && emit_.operations() <= check::kMaxChoices) return false;
    sink_
        ->report(span, diag::kTooComplex,
                 fmt::format("the stage has more than {} {}",
                             long_run     ? check::kMaxSteps
                             : operations ? check::kMaxOperations
                                          : check::kMaxChoices,
                             long_run     ? "statements"
                             : operations ? "operations"
                                          : "choices among elements of arrays"))
        .help(
            long_run || operations
                ? "functions are inlined and short loops unrolled: make the innermost ones smaller"
                : "write accesses that are repeated as a loop, or take a smaller array");
    gave_up = true;
    return true;
}

Value Budget::nested(const source::Span& span, const std::function<Value()>& body) {
    Value out;
    if (++inline_depth > kMaxInlineDepth) {
        sink_->report(span, diag::kTooComplex,
                      fmt::format("calls nested deeper than {} levels", kMaxInlineDepth));
        gave_up = true;
    } else {
        out = body();
    }
    --inline_depth;
    return out;
}

}  // namespace openfab::translate

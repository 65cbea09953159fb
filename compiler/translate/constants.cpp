// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/constants.h"

#include <algorithm>
#include <utility>

namespace openfab::translate {

using ir::ValueId;

Value Constants::expression(const check::Expr& expr) {
    const size_t before = budget_.steps;
    const size_t outer = std::exchange(budget_.step_limit, check::kMaxSteps);
    const size_t unroll = std::exchange(budget_.unroll_limit, check::kMaxUnrolledStepsOfConstant);
    Value out = expressions_.expression(expr);
    budget_.unroll_limit = unroll;
    budget_.step_limit = std::min(outer + budget_.steps - before, check::kMaxSteps);
    return out;
}

/// A table is computed once; constant results are cached.
Value Constants::value(const check::Symbol& symbol) {
    const std::vector<ir::Type> types = layout_.components(symbol.type);
    const auto known = known_.find(&symbol);
    if (known != known_.end()) {
        Value out;
        for (size_t i = 0; i < types.size(); ++i)
            out.push_back(emit_.constant(types[i], known->second[i]));
        return out;
    }
    Value out = expression(*symbol.init);
    std::vector<uint32_t> bits;
    for (ValueId value : out) {
        if (!emit_.is_constant(value)) return out;
        bits.push_back(emit_.instr(value).bits);
    }
    known_.emplace(&symbol, std::move(bits));
    return out;
}

}  // namespace openfab::translate

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "compiler/check/limits.h"
#include "compiler/diag/sink.h"
#include "compiler/translate/formulas.h"

namespace openfab::translate {

/// How large a stage may get. Once one of its limits is reached, translation gives up.
class Budget {
  public:
    Budget(Emitter* emit, diag::Sink* sink) : emit_(*emit), sink_(sink) {}
    /// Counts a step; true after a message.
    bool too_complex(const source::Span& span);
    /// Returns what `body` does one call deeper; empty if that is too deep.
    Value nested(const source::Span& span, const std::function<Value()>& body);

    bool gave_up = false;
    size_t steps = 0;                      ///< statements and calls that were translated
    size_t step_limit = check::kMaxSteps;  ///< lower while a loop is unrolled
    size_t unroll_limit = check::kMaxUnrolledSteps;
    int inline_depth = 0;

  private:
    Emitter& emit_;
    diag::Sink* sink_;
};

}  // namespace openfab::translate

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is translated, and what its stage cannot use: functions are checked where they are called.

#include <string_view>

#include "compiler/check/tree.h"
#include "compiler/diag/sink.h"

namespace openfab::translate {

/// What is translated.
struct Place {
    const check::Fablet& fablet;
    ir::StageKind kind;
    bool alone = false;  ///< an isolated function, whose calls are not inlined

    /// Of attributes alone: the stage is a @Grow.
    bool grows() const { return kind == ir::StageKind::kShapeAttributes; }
};

class StageRules {
  public:
    StageRules(diag::Sink* sink, const Place& place) : sink_(sink), place_(place) {}
    bool refuse_in_dither(const check::Expr& expr, std::string_view what);
    bool refuse_in_shape(const check::Expr& expr, std::string_view what, const char* help);
    bool asks_in_volume(const check::Expr& expr, const char* name);
    bool asks_of_object(const check::Expr& expr);

  private:
    diag::Sink* sink_;
    const Place& place_;
};

}  // namespace openfab::translate

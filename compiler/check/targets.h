// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/check/stage_rules.h"

namespace openfab::check {

/// What a value can be assigned to.
class Targets {
  public:
    Targets(diag::Sink* sink, const Place& place) : sink_(sink), place_(place) {}
    /// Returns whether one can; else says why not.
    bool assignable(const Expr& target) const;

  private:
    void refuse(const Expr& target) const;

    diag::Sink* sink_;
    const Place& place_;
};

}  // namespace openfab::check

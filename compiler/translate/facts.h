// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/translate/paths.h"

namespace openfab::translate {

/// What holds at the current point, by folding or by proof.
class Facts {
  public:
    Facts(Emitter* emit, const Paths& paths, const ir::Stage& stage)
        : emit_(*emit), paths_(paths), stage_(stage) {}
    /// Returns whether a condition holds on every path.
    bool always(ir::ValueId condition) const;
    /// Returns whether `fact` holds whenever the current point is reached.
    bool is_implied(ir::ValueId fact, ir::ValueId and_where) const;
    ir::ValueId assigned_by_a_trip(ir::ValueId assigned, int32_t which);
    bool unassigned_in_first_trip(ir::ValueId assigned) const;
    bool first_trip_comes_here() const;

  private:
    Emitter& emit_;
    const Paths& paths_;
    const ir::Stage& stage_;
};

}  // namespace openfab::translate

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/translate/formulas.h"
#include "compiler/translate/stage_rules.h"

namespace openfab::translate {

/// What a stage reads: attributes, and the frame of the part.
class StageInputs {
  public:
    StageInputs(Emitter* emit, Formulas* formulas, const Place& place)
        : emit_(*emit), formulas_(*formulas), place_(place) {}
    Value attribute(const check::Expr& expr);
    Value voxel_center();
    Value shape_point();
    Value frame_vector(int32_t first);

  private:
    Emitter& emit_;
    Formulas& formulas_;
    const Place& place_;
};

}  // namespace openfab::translate

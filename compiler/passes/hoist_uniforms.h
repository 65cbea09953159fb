// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// Collects what the stages of one fablet compute from uniforms alone, so that it is computed once
/// per object (openfab_fablet::derived) and not once per block.
class UniformHoister {
  public:
    /// `uniform_value_count` as of ir::Fablet: derived values are uniforms from there on.
    explicit UniformHoister(int32_t uniform_value_count);

    /// Replaces in `stage` what follows from uniforms by inputs of derived values; what computed it
    /// is left dead. Equal values of several stages are one.
    void hoist(ir::Stage* stage);

    /// One output DERIVED for each derived value; no outputs where there is none.
    const ir::Stage& derived() const { return derived_; }

  private:
    ir::ValueId add(ir::Instr instr);
    int32_t place_of(ir::ValueId value);

    int32_t uniform_value_count_;
    ir::Stage derived_;
};

}  // namespace openfab::passes

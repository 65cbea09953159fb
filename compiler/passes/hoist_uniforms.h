// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <tuple>
#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// Returns which values of a stage depend on uniforms and constants alone, by id.
std::vector<bool> uniform_values(const ir::Stage& stage);

/// Collects the values that the stages of a fablet compute from uniforms alone, so that they are
/// computed once per object (openfab_fablet::derived) and not once per block.
class UniformHoister {
  public:
    /// `uniform_value_count` as in ir::Fablet: derived values are the uniforms from there on.
    explicit UniformHoister(int32_t uniform_value_count);

    /// Replaces values in `stage` that depend on uniforms alone by inputs of derived values; the
    /// instructions that computed them are left dead. Equal values of several stages are shared.
    void hoist(ir::Stage* stage);

    /// The stage that computes derived values: one output DERIVED each; none without derived
    /// values.
    const ir::Stage& derived() const { return derived_; }

  private:
    using Key =
        std::tuple<ir::Op, ir::Type, uint32_t, int32_t, int32_t, int32_t, std::vector<ir::ValueId>>;

    ir::ValueId add(ir::Instr instr);
    int32_t index_of(ir::ValueId value);

    int32_t uniform_value_count_;
    ir::Stage derived_;
    std::map<Key, ir::ValueId> known_;
    std::map<ir::ValueId, int32_t> indices_;
};

}  // namespace openfab::passes

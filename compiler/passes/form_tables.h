// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// Makes Picks loads from the values of an object. The elements of an array of uniforms lie there
/// already, evenly apart. Those of any other array, with constants and derived values among them, are
/// copied behind the derived values (openfab_fablet::table_values).
class TableFormer {
  public:
    /// `first`: the number of values that an object has without tables.
    explicit TableFormer(int32_t first) : first_(first) {}

    /// Replaces the Picks of a stage; what they read of uniforms is left dead. One whose elements are
    /// computed, since they were not hoisted, chooses one after the other.
    void form(ir::Stage* stage);

    const std::vector<openfab_table_value>& values() const { return values_; }

  private:
    bool make_table(const ir::Stage& stage, ir::Instr* pick);
    int32_t index_of(const std::vector<std::pair<int32_t, uint32_t>>& table);

    int32_t first_;
    std::vector<openfab_table_value> values_;
    std::map<std::vector<std::pair<int32_t, uint32_t>>, int32_t> known_;
};

}  // namespace openfab::passes

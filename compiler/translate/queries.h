// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Queries of surfaces, and lookups. A query of the part's own surface at the voxel's centre becomes inputs,
// which the runtime computes for whole blocks; any other is a Query under the condition that the
// call is reached.

#include <cstdint>
#include <functional>

#include "compiler/diag/sink.h"
#include "compiler/translate/budget.h"
#include "compiler/translate/expressions.h"
#include "compiler/translate/layout.h"
#include "compiler/translate/paths.h"
#include "compiler/translate/stage_inputs.h"

namespace openfab::translate {

class Queries {
  public:
    Queries(diag::Sink* sink, const Place& place, Emitter* emit, Formulas* formulas,
            const Paths& paths, Layout* layout, const Budget& budget, StageRules* rules,
            StageInputs* inputs, Expressions* expressions)
        : sink_(sink),
          place_(place),
          emit_(*emit),
          formulas_(*formulas),
          paths_(paths),
          layout_(*layout),
          budget_(budget),
          rules_(*rules),
          inputs_(*inputs),
          expressions_(*expressions) {}
    Value distance(const check::Expr& expr);
    Value nearest_point(const check::Expr& expr);
    Value distance_to(const check::Expr& expr);
    Value walk_end(const check::Expr& expr);
    Value sample(const check::Expr& expr);
    Value numbered(const check::Expr& expr, int32_t kind, int32_t count);

  private:
    Value local_point(const Value& point);
    Value of_selected(const check::Expr& expr, ir::ValueId object,
                      const std::function<Value(int32_t index, ir::ValueId guard)>& ask);
    ir::ValueId query(int32_t object, ir::ValueId guard, const Value& point);

    diag::Sink* sink_;
    const Place& place_;
    Emitter& emit_;
    Formulas& formulas_;
    const Paths& paths_;
    Layout& layout_;
    const Budget& budget_;
    StageRules& rules_;
    StageInputs& inputs_;
    Expressions& expressions_;
};

}  // namespace openfab::translate

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/stage_translator.h"

#include <utility>

#include "abi/grow_table.h"
#include "compiler/translate/outputs.h"

namespace openfab::translate {

using ir::ValueId;

std::vector<uint32_t> StageTranslator::constant_bits(const check::Expr& expr) {
    paths_.live = emit_.constant(true);
    std::vector<uint32_t> bits;
    for (ValueId value : expressions_.constants().expression(expr)) {
        if (!emit_.is_constant(value)) return {};
        bits.push_back(emit_.instr(value).bits);
    }
    return bits;
}

void StageTranslator::run(const check::Stage& stage, const TranslateOptions& options) {
    stage_->kind = place_.kind;
    expressions_.printing().enabled = options.enable_printf;
    paths_.live = emit_.constant(true);
    for (const auto& symbol : stage.symbols)
        add_symbol(*symbol);
    const bool surface = place_.kind == ir::StageKind::kSurface;
    const bool dither = place_.kind == ir::StageKind::kDither;
    const bool shape = place_.kind == ir::StageKind::kShape;
    const check::Type result = surface          ? check::kFloat3Type
                               : dither         ? check::kIntType
                               : shape          ? check::kFloatType
                               : place_.grows() ? place_.fablet.node
                                                : check::Type{check::Base::kComposition, 1};
    paths_.frame.returned = paths_.add_flag();
    paths_.frame.result = paths_.add_variable({layout_.zero(result), {}});
    statements_.list(stage.body->body);
    expressions_.calls().check_returned(stage.span,
                                        surface          ? "the `@Surface` stage"
                                        : dither         ? "the `@Dither` stage"
                                        : shape          ? "the `@Shape` stage"
                                        : place_.grows() ? "the `@Grow` stage"
                                                         : "the `@Volume` stage",
                                        result, *stage.body);
    Outputs outputs(sink_, place_, stage_, paths_, &expressions_.calls());
    if (surface) {
        outputs.surface(stage);
    } else if (shape) {
        outputs.shape(stage);
    } else if (place_.grows()) {
        outputs.grow();
    } else if (dither) {
        outputs.dither(stage);
    } else {
        outputs.volume();
    }
    if (!budget_.gave_up) ir::drop_dead_values(stage_);
}

void StageTranslator::add_symbol(const check::Symbol& symbol) {
    if (symbol.kind == check::SymbolKind::kAttributes) return;
    emit_.set_span(symbol.span);
    Variable v;
    if (symbol.kind == check::SymbolKind::kSurfaceOutput ||
        symbol.kind == check::SymbolKind::kShapeOutput) {
        v.value = layout_.zero(symbol.type);
        v.assigned.assign(v.value.size(), emit_.constant(false));
    } else if (symbol.kind == check::SymbolKind::kGrowParent) {
        const std::vector<ir::Varying>& members = place_.fablet.ir.shape_outputs;
        for (size_t m = 0; m < members.size(); ++m) {
            for (int32_t i = 0; i < members[m].components; ++i)
                v.value.push_back(emit_.input(members[m].type, OPENFAB_ARG_GROW_PARENT,
                                              static_cast<int32_t>(m), i));
        }
    } else {
        const int32_t kind = symbol.kind == check::SymbolKind::kNearest ? OPENFAB_ARG_NEAREST
                                                                        : OPENFAB_ARG_SURFACE_IN;
        for (int32_t i = 0; i < symbol.type.size; ++i) {
            v.value.push_back(
                emit_.input(check::component_type(symbol.type), kind, symbol.index, i));
        }
    }
    paths_.frame.variables[&symbol] = paths_.add_variable(std::move(v));
}

void StageTranslator::run(const check::Function& function) {
    place_.alone = true;
    paths_.live = emit_.constant(true);
    std::vector<Variable> arguments;
    for (const auto& p : function.parameters) {
        Variable v;
        for (const ir::Type type : layout_.components(p->type)) {
            v.value.push_back(p->is_in ? emit_.input(type, kArgument, emit_.next_unknown(), 0)
                                       : emit_.constant(type, 0));
        }
        if (!p->is_in) v.assigned = layout_.unassigned(p->type);
        arguments.push_back(std::move(v));
    }
    std::vector<Value> results;
    expressions_.calls().run_body(function, std::move(arguments), &results);
}

}  // namespace openfab::translate

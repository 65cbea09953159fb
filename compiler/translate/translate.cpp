// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/translate.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "abi/grow_table.h"
#include "compiler/ir/arithmetic.h"
#include "compiler/translate/stage_translator.h"

namespace openfab::translate {

using ir::ValueId;

namespace {

std::string component_name(const std::string& name, int32_t components, int32_t i) {
    return components == 1 ? name : fmt::format("{}.{}", name, "xyzw"[i]);
}

/// The input that all components of output `index` copy in order, or -1.
int32_t copied_input(const ir::Fablet& fablet, int32_t index) {
    const ir::Varying& output = fablet.surface_outputs[index];
    int32_t source = -1;
    for (const ir::Output& out : fablet.surface.outputs) {
        if (out.kind != OPENFAB_ARG_SURFACE_OUT || out.a != index) continue;
        const ir::Instr& instr = fablet.surface.instrs[out.value];
        const bool copy = instr.op == ir::Op::kInput && instr.kind == OPENFAB_ARG_SURFACE_IN &&
                          instr.b == out.b && (out.b == 0 || instr.a == source);
        if (!copy) return -1;
        source = instr.a;
    }
    if (source < 0) return -1;
    const ir::Varying& input = fablet.surface_inputs[source];
    return input.type == output.type && input.components == output.components ? source : -1;
}

std::vector<uint32_t> default_bits(const check::Fablet& fablet, const check::Symbol& symbol,
                                   diag::Sink* sink) {
    if (symbol.init == nullptr) return {};
    ir::Stage scratch;
    StageTranslator translator(fablet, ir::StageKind::kVolume, &scratch, sink);
    std::vector<uint32_t> bits = translator.constant_bits(*symbol.init);
    if (bits.empty()) sink->report(symbol.init->span, diag::kNotConstant, "a default");
    return bits;
}

std::string number_text(ir::Type type, double value) {
    if (std::isnan(value)) return "nan";  // of either sign
    return type == ir::Type::kFloat ? fmt::format("{}", static_cast<float>(value))
                                    : fmt::format("{:.0f}", value);
}

/// Replaces annotations that are expressions by their values.
void compute_annotations(const check::Fablet& fablet, const check::Symbol& symbol,
                         ir::Uniform* uniform, diag::Sink* sink) {
    for (size_t i = 0; i < symbol.annotations.size(); ++i) {
        const check::ExprPtr& value = symbol.annotations[i].value;
        if (value == nullptr) continue;
        ir::Stage scratch;
        StageTranslator translator(fablet, ir::StageKind::kVolume, &scratch, sink);
        const std::vector<uint32_t> bits = translator.constant_bits(*value);
        if (bits.empty()) {
            sink->report(value->span, diag::kNotConstant, "an annotation");
            continue;
        }
        auto& [name, text] = uniform->annotations[i];
        const float limit = ir::as_float(bits[0]);
        if (!std::isfinite(limit)) {
            sink->report(value->span, diag::kBadDeclaration,
                         fmt::format("the `{}` of `{}` is {}, not a finite number", name,
                                     uniform->name, number_text(ir::Type::kFloat, limit)))
                .help(fmt::format("without a `{}` there is no such limit", name));
            continue;
        }
        text = fmt::format("{}", limit);
    }
}

double as_number(ir::Type type, uint32_t bits) {
    if (type == ir::Type::kInt) return ir::as_int(bits);
    return type == ir::Type::kFloat ? static_cast<double>(ir::as_float(bits)) : bits;
}

/// Checks that something lies between the limits, and that the default does. A float is compared
/// with limits that are rounded as it is.
void check_limits(const check::Symbol& symbol, const ir::Uniform& uniform, diag::Sink* sink) {
    std::optional<std::array<double, 2>> limits = ir::limits(uniform);
    if (!limits) return;
    if (uniform.type == ir::Type::kFloat) {
        for (double& limit : *limits)
            limit = static_cast<double>(static_cast<float>(limit));
    }
    const auto span_of = [&](const char* name) {
        size_t i = 0;
        while (i < uniform.annotations.size() && uniform.annotations[i].first != name)
            ++i;
        return i < uniform.annotations.size() ? symbol.annotations[i].span : symbol.span;
    };
    const auto limit_text = [&](size_t which) {
        return number_text(uniform.type, (*limits)[which]);
    };
    if ((*limits)[0] > (*limits)[1]) {
        sink->report(span_of("max"), diag::kBadDeclaration,
                     fmt::format("the `max` of `{}`, {}, is below its `min`, {}", uniform.name,
                                 limit_text(1), limit_text(0)))
            .note(span_of("min"), "the `min` is here");
        return;
    }
    for (const uint32_t bits : uniform.default_bits) {
        const double value = as_number(uniform.type, bits);
        const bool high = value > (*limits)[1];
        if (!high && value >= (*limits)[0]) continue;
        diag::Diagnostic& d =
            sink->report(symbol.init->span, diag::kBadDeclaration,
                         fmt::format("the default of `{}`, {}, is not within its limits",
                                     uniform.name, number_text(uniform.type, value)));
        const char* name = high ? "max" : "min";
        if (!std::isnan(value))
            d.note(span_of(name), fmt::format("its `{}` is {}", name, limit_text(high ? 1 : 0)));
        return;
    }
}

using Functions = std::vector<std::unique_ptr<check::Function>>;

/// Returns whether a diagnostic is due to a function's own text, whatever its arguments; unassigned
/// variables are diagnosed better where the arguments are known.
bool is_of_text(diag::Id id, bool called) {
    return id == diag::Id::kMissingReturn || id == diag::Id::kOutputUnassigned ||
           id == diag::Id::kUninitialized || (id == diag::Id::kMaybeUninitialized && !called);
}

/// Translates each function in isolation, so that it is checked even if nothing calls it. `steps`
/// counts the steps of all of them.
void check_functions(const check::Fablet& fablet, const Functions& functions,
                     const std::set<const check::Function*>& called, size_t* steps,
                     diag::Sink* sink) {
    for (const auto& f : functions) {
        if (*steps > check::kMaxSteps) {
            sink->report(f->span, diag::kTooComplex,
                         fmt::format("the functions up to here come to more than {} statements",
                                     check::kMaxSteps))
                .help("short loops are unrolled: make the innermost ones smaller");
            return;
        }
        ir::Stage scratch;
        diag::Sink found;
        StageTranslator translator(fablet, ir::StageKind::kVolume, &scratch, &found);
        translator.run(*f);
        *steps += translator.steps();
        for (diag::Diagnostic& d : found.sorted()) {
            if (is_of_text(d.id, called.count(f.get()) != 0)) sink->take(std::move(d));
        }
    }
}

/// What functions outside fablets see: one placeholder of each kind.
check::Fablet no_fablet() {
    check::Fablet out;
    out.ir.slot_count = out.ir.texture_count = out.ir.object_count = 1;
    out.ir.void_slot = 0;
    out.point_members = check::common_point_members();
    return out;
}

ir::Fablet translate_fablet(const check::Fablet& fablet, const TranslateOptions& options,
                            std::set<const check::Function*>* called, diag::Sink* sink) {
    const auto run = [&](ir::StageKind kind, const check::Stage& stage, ir::Stage* to) {
        StageTranslator translator(fablet, kind, to, sink);
        translator.run(stage, options);
        called->insert(translator.inlined().begin(), translator.inlined().end());
    };
    ir::Fablet out = fablet.ir;
    for (size_t i = 0; i < fablet.uniforms.size(); ++i) {
        out.uniforms[i].default_bits = default_bits(fablet, *fablet.uniforms[i], sink);
        compute_annotations(fablet, *fablet.uniforms[i], &out.uniforms[i], sink);
        check_limits(*fablet.uniforms[i], out.uniforms[i], sink);
    }
    for (size_t i = 0; i < fablet.surface_inputs.size(); ++i) {
        out.surface_inputs[i].default_bits = default_bits(fablet, *fablet.surface_inputs[i], sink);
    }
    const ir::StageKind shape =
        !fablet.node.is_error() ? ir::StageKind::kShapeAttributes : ir::StageKind::kShape;
    if (out.has_shape) run(shape, fablet.shape, &out.shape);
    if (out.has_surface) {
        run(ir::StageKind::kSurface, fablet.surface, &out.surface);
        for (size_t i = 0; i < out.surface_outputs.size(); ++i) {
            out.surface_outputs[i].source = copied_input(out, static_cast<int32_t>(i));
        }
    }
    run(ir::StageKind::kVolume, fablet.volume, &out.volume);
    if (out.has_dither) run(ir::StageKind::kDither, fablet.dither, &out.dither);
    return out;
}

}  // namespace

ir::Module translate(const check::Program& program, const TranslateOptions& options,
                     diag::Sink* sink) {
    ir::Module module;
    std::set<const check::Function*> called;
    for (const check::Fablet& fablet : program.fablets) {
        module.fablets.push_back(translate_fablet(fablet, options, &called, sink));
    }
    size_t steps = 0;
    for (const check::Fablet& fablet : program.fablets)
        check_functions(fablet, fablet.functions, called, &steps, sink);
    check_functions(no_fablet(), program.functions, called, &steps, sink);
    return module;
}

std::vector<uint32_t> StageTranslator::constant_bits(const check::Expr& expr) {
    live_ = emit_.constant(true);
    std::vector<uint32_t> bits;
    for (ValueId value : constant_expression(expr)) {
        if (!emit_.is_constant(value)) return {};
        bits.push_back(emit_.instr(value).bits);
    }
    return bits;
}

void StageTranslator::run(const check::Stage& stage, const TranslateOptions& options) {
    stage_->kind = kind_;
    options_ = options;
    live_ = emit_.constant(true);
    for (const auto& symbol : stage.symbols)
        add_stage_symbol(*symbol);
    const bool surface = kind_ == ir::StageKind::kSurface;
    const bool dither = kind_ == ir::StageKind::kDither;
    const bool shape = kind_ == ir::StageKind::kShape;
    const check::Type result = surface   ? check::kFloat3Type
                               : dither  ? check::kIntType
                               : shape   ? check::kFloatType
                               : grows() ? fablet_.node
                                         : check::Type{check::Base::kComposition, 1};
    frame_.returned = add_flag();
    frame_.result = add_variable({zero(result), {}});
    statements(stage.body->body);
    check_returned(stage.span,
                   surface   ? "the `@Surface` stage"
                   : dither  ? "the `@Dither` stage"
                   : shape   ? "the `@Shape` stage"
                   : grows() ? "the `@Grow` stage"
                             : "the `@Volume` stage",
                   result, *stage.body);
    if (surface) {
        finish_surface(stage);
    } else if (shape) {
        add_output("value", OPENFAB_ARG_SHAPE_VALUE, 0, 0, variables_[frame_.result].value[0]);
        finish_varyings(stage, check::SymbolKind::kShapeOutput, OPENFAB_ARG_SHAPE_OUT);
    } else if (grows()) {
        finish_grow();
    } else if (dither) {
        finish_dither(stage);
    } else {
        finish_volume();
    }
    if (!gave_up_) ir::drop_dead_values(stage_);
}

void StageTranslator::add_stage_symbol(const check::Symbol& symbol) {
    if (symbol.kind == check::SymbolKind::kAttributes) return;
    emit_.set_span(symbol.span);
    Variable v;
    if (symbol.kind == check::SymbolKind::kSurfaceOutput ||
        symbol.kind == check::SymbolKind::kShapeOutput) {
        v.value = zero(symbol.type);
        v.assigned.assign(v.value.size(), emit_.constant(false));
    } else if (symbol.kind == check::SymbolKind::kGrowParent) {
        const std::vector<ir::Varying>& members = fablet_.ir.shape_outputs;
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
    frame_.variables[&symbol] = add_variable(std::move(v));
}

void StageTranslator::add_output(std::string name, int32_t kind, int32_t a, int32_t b,
                                 ValueId value) {
    stage_->outputs.push_back({std::move(name), kind, a, b, value});
}

void StageTranslator::finish_surface(const check::Stage& stage) {
    const Value& displacement = variables_[frame_.result].value;
    for (int32_t axis = 0; axis < 3; ++axis) {
        add_output(component_name("displacement", 3, axis), OPENFAB_ARG_POSITION, 0, axis,
                   displacement[axis]);
    }
    finish_varyings(stage, check::SymbolKind::kSurfaceOutput, OPENFAB_ARG_SURFACE_OUT);
}

void StageTranslator::finish_varyings(const check::Stage& stage, check::SymbolKind which,
                                      int32_t kind) {
    for (const auto& symbol : stage.symbols) {
        if (symbol->kind != which) continue;
        const Variable& v = variables_[variable_of(*symbol)];
        check_assigned(v, *symbol);
        for (int32_t i = 0; i < symbol->type.size; ++i) {
            add_output(component_name(symbol->name, symbol->type.size, i), kind, symbol->index, i,
                       v.value[i]);
        }
    }
}

void StageTranslator::finish_grow() {
    const Value& node = variables_[frame_.result].value;
    const std::vector<ir::Varying>& members = fablet_.ir.shape_outputs;
    size_t at = 0;
    for (size_t m = 0; m < members.size(); ++m) {
        for (int32_t i = 0; i < members[m].components; ++i)
            add_output(fmt::format("{}.{}", members[m].name, i), OPENFAB_ARG_SHAPE_OUT,
                       static_cast<int32_t>(m), i, node[at++]);
    }
}

void StageTranslator::finish_dither(const check::Stage& stage) {
    add_output("choice", OPENFAB_ARG_CHOICE, 0, 0, variables_[frame_.result].value[0]);
    for (const ir::Instr& instr : stage_->instrs) {
        if (instr.op != ir::Op::kLoop) continue;
        sink_->report(instr.span, diag::kTooComplex, "a loop of a dither rule that is not unrolled")
            .note(stage.span, "stage declared `@Dither` here")
            .help(fmt::format("a loop over the fractions, `for (int i = 0; i < attr.count; ++i)`, "
                              "is unrolled: here they are {}",
                              fablet_.ir.slot_count + 1));
        return;
    }
}

void StageTranslator::finish_volume() {
    const Value& amounts = variables_[frame_.result].value;
    for (const ir::Uniform& u : fablet_.ir.uniforms) {
        if (u.kind != OPENFAB_UNIFORM_MATERIAL) continue;
        for (int32_t i = 0; i < u.array_length; ++i) {
            const int32_t slot = u.first_index + i;
            add_output(u.array_length == 1 ? u.name : fmt::format("{}[{}]", u.name, i),
                       OPENFAB_ARG_WEIGHT, slot, 0, amounts[slot]);
        }
    }
    const int32_t slot = fablet_.ir.void_slot;
    if (slot >= 0) add_output("VOID", OPENFAB_ARG_WEIGHT, slot, 0, amounts[slot]);
}

}  // namespace openfab::translate

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

#include "compiler/ir/arithmetic.h"
#include "compiler/translate/stage_translator.h"

namespace openfab::translate {

namespace {

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
        diag::Sink diagnostics;
        StageTranslator translator(fablet, ir::StageKind::kVolume, &scratch, &diagnostics);
        translator.run(*f);
        *steps += translator.steps();
        for (diag::Diagnostic& d : diagnostics.sorted()) {
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

}  // namespace openfab::translate

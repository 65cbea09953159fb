// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/uniforms.h"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "compiler/check/declarations.h"
#include "compiler/ir/choices.h"

namespace openfab::check {

namespace {

constexpr int32_t kMaxSlots = 256;  // a world has 254 materials

std::string annotation_text(const ast::Expr& expr) {
    if (expr.kind == ast::ExprKind::kStringLiteral) return std::string(expr.text);
    if (expr.kind == ast::ExprKind::kUnary) {
        return std::string(expr.text) + annotation_text(*expr.args[0]);
    }
    return std::string(expr.text);
}

/// Returns whether an annotation is a limit that must be computed, such as a constant's: any but a
/// decimal number.
bool is_computed(const ast::Annotation& annotation) {
    if (annotation.value == nullptr || (annotation.name != "min" && annotation.name != "max"))
        return false;
    const ast::Expr* number = annotation.value.get();
    if (number->kind == ast::ExprKind::kUnary && number->text == "-")
        number = number->args[0].get();
    const bool is_number =
        number->kind == ast::ExprKind::kIntLiteral || number->kind == ast::ExprKind::kFloatLiteral;
    return !is_number || number->text.starts_with("0x") || number->text.starts_with("0X");
}

}  // namespace

/// Assigns a uniform its index among those of its kind; false if its type is not allowed.
bool Uniforms::assign_index(const ast::Variable& v, const Type& type, ir::Uniform* uniform,
                            Fablet* to) {
    Type element = type;
    if (type.is_array()) {
        uniform->array_length = type.length();
        element = type.element();
    }
    const auto assign = [&](openfab_uniform_kind kind, int32_t* count) {
        uniform->kind = kind;
        uniform->first_index = *count;
        *count += uniform->array_length;
    };
    if (element.is(Base::kTexture2D)) {
        assign(OPENFAB_UNIFORM_TEXTURE2D, &to->ir.texture_count);
    } else if (element.is(Base::kTexture3D)) {
        assign(OPENFAB_UNIFORM_TEXTURE3D, &to->ir.texture_count);
    } else if (element.is(Base::kObject)) {
        assign(OPENFAB_UNIFORM_OBJECT, &to->ir.object_count);
    } else if (element.is(Base::kMaterial)) {
        const bool fitted = to->ir.slot_count <= kMaxSlots;
        assign(OPENFAB_UNIFORM_MATERIAL, &to->ir.slot_count);
        if (fitted && to->ir.slot_count > kMaxSlots) {
            sink_->report(v.span, diag::kTooComplex,
                          fmt::format("more than {} uniforms of type `Material`", kMaxSlots));
        }
    } else if (type.is_curve()) {
        uniform->kind = OPENFAB_UNIFORM_CURVE;
        uniform->components = static_cast<int32_t>(min_components(type));
        uniform->first_index = to->ir.uniform_value_count;
        to->ir.uniform_value_count += uniform->components;
    } else if (element.is_arithmetic()) {
        uniform->type = component_type(element);
        uniform->components = static_cast<int32_t>(min_components(element));
        uniform->first_index = to->ir.uniform_value_count;
        to->ir.uniform_value_count += uniform->components * uniform->array_length;
    } else {
        diag::Diagnostic& d =
            sink_->report(v.type.span, diag::kBadDeclaration,
                          fmt::format("a uniform cannot have type `{}`", type_name(type)));
        if (element.is_array()) d.help("a uniform array has one dimension");
        if (element.is_curve()) d.help("give each a name of its own");
        if (element.is(Base::kStruct)) d.help("declare the members as uniforms of their own");
        return false;
    }
    return true;
}

void Uniforms::annotations(const ast::Variable& v, Symbol* symbol, ir::Uniform* uniform) {
    for (const ast::Annotation& a : v.annotations) {
        for (size_t i = 0; i < symbol->annotations.size(); ++i) {
            if (uniform->annotations[i].first != a.name) continue;
            sink_->report(a.span, diag::kRedeclared, a.name)
                .note(symbol->annotations[i].span, "the first one is here");
        }
        Symbol::Annotation& kept = symbol->annotations.emplace_back();
        kept.span = a.span;
        std::string text;
        if (is_computed(a)) {
            place_.context = StageContext::kGlobal;
            kept.value = expressions_.initializers().of(*a.value, kFloatType);
        } else if (a.value != nullptr) {
            text = annotation_text(*a.value);
        }
        uniform->annotations.emplace_back(a.name, std::move(text));
    }
}

void Uniforms::check(const ast::Variable& v, Fablet* to) {
    ir::Uniform uniform;
    uniform.name = v.name;
    uniform.type_name = v.type.text;
    uniform.span = v.span;
    auto symbol = std::make_unique<Symbol>();
    symbol->kind = SymbolKind::kUniform;
    symbol->name = v.name;
    symbol->span = v.span;
    symbol->type = expressions_.types().declared_type(v);
    symbol->index = static_cast<int32_t>(to->uniforms.size());
    if (!symbol->type.is_error() && !assign_index(v, symbol->type, &uniform, to)) {
        symbol->type = {};
    }
    Type element = symbol->type;
    if (element.is_array()) element = element.element();
    if (v.init != nullptr && element.is_arithmetic()) {
        place_.context = StageContext::kGlobal;
        symbol->init = expressions_.initializers().of(*v.init, symbol->type);
    } else if (v.init != nullptr && !symbol->type.is_error()) {
        sink_->report(
            v.init->span, diag::kBadDeclaration,
            fmt::format("a uniform of type `{}` has no default: the world binds it", v.type.text));
    }
    annotations(v, symbol.get(), &uniform);
    add_choices(v, symbol->type, &uniform);
    names_.declare(symbol.get());
    to->ir.uniforms.push_back(std::move(uniform));
    to->uniforms.push_back(std::move(symbol));
}

/// Gives a uniform the names that its values have: those of its enum, or the labels `on` and `off` of a bool.
void Uniforms::add_choices(const ast::Variable& v, const Type& element,
                           ir::Uniform* uniform) const {
    const Symbol* type = names_.find(v.type.text);
    std::vector<Choice> choices;
    if (type != nullptr && type->kind == SymbolKind::kType) choices = type->choices;
    if (element == kBoolType) {
        std::string off = "off", on = "on";
        bool labelled = false;
        for (const ast::Annotation& a : v.annotations) {
            const bool text = a.value != nullptr && a.value->kind == ast::ExprKind::kStringLiteral;
            if (!text || (a.name != "off" && a.name != "on")) continue;
            (a.name == "on" ? on : off) = one_line(a.value->text);
            labelled = true;
        }
        if (labelled) choices = {{"false", off, 0}, {"true", on, 1}};
    }
    if (choices.empty()) return;
    std::string text;
    for (const Choice& one : choices)
        text +=
            fmt::format("{}{}\t{}\t{}", text.empty() ? "" : "\n", one.name, one.value, one.label);
    uniform->annotations.emplace_back(ir::kChoices, std::move(text));
}

}  // namespace openfab::check

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/nodes.h"

#include <fmt/format.h>

#include <algorithm>

#include "compiler/check/own_functions.h"
#include "compiler/check/signatures.h"
#include "compiler/ir/arithmetic.h"

namespace openfab::check {

namespace {

std::optional<uint32_t> known_choice(const Expr& expr) {
    const std::optional<uint32_t> test = known_bits(*expr.args[0]);
    if (!test) return std::nullopt;
    return known_bits(*expr.args[*test != 0 ? 1 : 2]);
}

std::optional<uint32_t> own_bits(const Expr& expr) {
    if (expr.kind == ExprKind::kConstant) return expr.bits;
    return expr.kind == ExprKind::kVariable ? expr.symbol->known : known_choice(expr);
}

bool writes_an_argument(const Expr& call) {
    if (call.kind == ExprKind::kIntrinsic) return writes_an_argument(call.intrinsic);
    return std::any_of(call.function->parameters.begin(), call.function->parameters.end(),
                       [](const auto& parameter) { return parameter->is_out; });
}

}  // namespace

ExprPtr make(ExprKind kind, const Type& type, const source::Span& span) {
    auto out = std::make_unique<Expr>();
    out->kind = kind;
    out->type = type;
    out->span = span;
    return out;
}

ExprPtr poison(const source::Span& span) {
    return make(ExprKind::kError, {}, span);
}

Type common_type(const Type& a, const Type& b) {
    Type out;
    out.base = std::max(a.base, b.base);  // bool < int < uint < float
    if (a.is_matrix() || b.is_matrix()) {
        out.rows = a.is_matrix() ? a.rows : b.rows;
        out.size = a.is_matrix() ? a.size : b.size;
        return out;
    }
    out.size = a.size == 1 || b.size == 1 ? std::max(a.size, b.size) : std::min(a.size, b.size);
    return out;
}

std::string type_list(const std::vector<ExprPtr>& args) {
    std::string out;
    for (const ExprPtr& arg : args)
        out += (out.empty() ? "" : ", ") + type_name(arg->type);
    return out;
}

bool any_error(const std::vector<ExprPtr>& args) {
    return std::any_of(args.begin(), args.end(),
                       [](const ExprPtr& arg) { return arg->type.is_error(); });
}

std::optional<uint32_t> known_bits(const Expr& expr) {
    if (!expr.type.is_scalar()) return std::nullopt;
    switch (traits(expr.kind).folding) {
        case Folding::kNever:
            return std::nullopt;
        case Folding::kOwn:
            return own_bits(expr);
        case Folding::kOperands:
            break;
    }
    const std::optional<uint32_t> a = known_bits(*expr.args[0]);
    if (!a) return std::nullopt;
    const ir::Type type = component_type(expr.args[0]->type);
    if (expr.kind == ExprKind::kConvert) {
        return ir::eval_convert(type, component_type(expr.type), *a);
    }
    if (expr.kind == ExprKind::kUnary) return ir::eval(expr.op, type, *a, 0, 0);
    if (expr.kind == ExprKind::kAndThen && *a == 0) return 0u;
    if (expr.kind == ExprKind::kOrElse && *a != 0) return 1u;
    const std::optional<uint32_t> b = known_bits(*expr.args[1]);
    if (!b || expr.kind != ExprKind::kBinary) return b;
    return ir::eval(expr.op, type, *a, *b, 0);
}

const Expr* side_effect(const Expr& expr) {
    switch (traits(expr.kind).effect) {
        case Effect::kOwn:
            return &expr;
        case Effect::kCallee:
            if (writes_an_argument(expr)) return &expr;
            break;
        case Effect::kNone:
            break;
    }
    for (const ExprPtr& arg : expr.args) {
        if (const Expr* effect = side_effect(*arg)) return effect;
    }
    return nullptr;
}

void wrong_count(diag::Sink* sink, const ast::Expr& call, std::string_view name,
                 const std::string& right, size_t count) {
    diag::Diagnostic& d = sink->report(call.args[0]->text_span, diag::kArgumentCount, name, right,
                                       static_cast<int>(count));
    const std::vector<Signature> forms = signatures_of(name);
    std::string list;
    for (const Signature& one : forms)
        list += fmt::format("{}`{}`", list.empty() ? "" : ", ", one.form);
    if (!forms.empty()) d.help((forms.size() == 1 ? "it is " : "there are ") + list);
}

}  // namespace openfab::check

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Warnings about code that is valid but probably unintended, and help with invalid conversions.
#include <fmt/format.h>

#include <utility>

#include "compiler/check/expression_checker.h"

namespace openfab::check {

namespace {

bool is_order(std::string_view op) {
    return op == "<" || op == "<=" || op == ">" || op == ">=";
}

}  // namespace

/// Returns whether an expression is an assignment like `k = 2` without its own parentheses, which
/// would mark it as intended.
bool ExpressionChecker::is_bare_assignment(const ast::Expr& expr) {
    return expr.kind == ast::ExprKind::kAssign && expr.text == "=" &&
           expr.span.begin == expr.args[0]->span.begin;
}

/// Warns about an expression statement without effect; a call is assumed to be intended.
void ExpressionChecker::check_used(const ast::Expr& from, const Expr& expr) {
    if (expr.type.is_error() || from.kind == ast::ExprKind::kComma ||
        from.kind == ast::ExprKind::kCall || side_effect(expr) != nullptr) {
        return;
    }
    diag::Diagnostic& d = sink_->report(from.span, diag::kUnusedValue);
    if (from.kind == ast::ExprKind::kBinary && from.text == "==") {
        d.help("`=` assigns").replace(from.text_span, "=");
    }
}

/// The value of `a, b` is `b`: `a` is useless without an effect.
ExprPtr ExpressionChecker::comma(const ast::Expr& expr) {
    std::vector<const ast::Expr*> parts;  // from the last to the first
    const ast::Expr* at = &expr;
    for (; at->kind == ast::ExprKind::kComma; at = at->args[0].get())
        parts.push_back(at->args[1].get());
    ExprPtr out = expression(*at);
    bool numbers = out->type.is_numeric();
    const bool unused = !out->type.is_error() && side_effect(*out) == nullptr;
    for (auto part = parts.rbegin(); part != parts.rend(); ++part) {
        ExprPtr second = expression(**part);
        numbers = numbers && second->type.is_numeric();
        ExprPtr both = make(ExprKind::kComma, second->type, expr.span);
        both->args.push_back(std::move(out));
        both->args.push_back(std::move(second));
        out = std::move(both);
    }
    if (unused) {
        diag::Diagnostic& d = sink_->report(at->span, diag::kUnusedValue);
        const size_t count = parts.size() + 1;
        if (numbers && count <= 4) {
            d.help(fmt::format("`a, b` evaluates to `b`; a vector is written `float{}(…)`", count));
        } else {
            d.help("`a, b` evaluates to `b`");
        }
    }
    return out;
}

/// Warns about notation that means something else in mathematics: `2^3`, `0 < x < 1`.
void ExpressionChecker::check_foreign_operators(const ast::Expr& expr, const Expr& left,
                                                const Expr& right) {
    const auto literal = [](const ast::Expr& part) {
        return part.kind == ast::ExprKind::kIntLiteral && part.text.find('x') == std::string::npos;
    };
    if (expr.text == "^" && literal(*expr.args[0]) && literal(*expr.args[1])) {
        sink_->report(expr.text_span, diag::kXorPower, static_cast<int>(left.bits ^ right.bits))
            .help(fmt::format("a power is written `pow({}, {})`", expr.args[0]->text,
                              expr.args[1]->text))
            .replace(expr.span, fmt::format("pow({}, {})", expr.args[0]->text, expr.args[1]->text));
    }
    const ast::Expr& inner = *expr.args[0];
    const bool chained = is_order(expr.text) && inner.kind == ast::ExprKind::kBinary &&
                         is_order(inner.text) && inner.span.begin == inner.args[0]->span.begin;
    if (!chained) return;
    sink_->report(expr.text_span, diag::kChainedComparison, expr.text)
        .help(
            fmt::format("`a {0} b {1} c` compares the result of `a {0} b`, 0 or 1, with `c`; write "
                        "`a {0} b && b {1} c`",
                        inner.text, expr.text));
}

/// Warns about `float3x3(1)`, which is the identity in GLSL. `(float3x3)1` says that all components are meant.
void ExpressionChecker::check_matrix_of(const ast::Expr& expr, const Type& type,
                                        const Expr& value) {
    if (!type.is_matrix() || !value.type.is_scalar() || type.rows != type.size) return;
    const std::optional<uint32_t> bits = known_bits(value);
    if (bits && (*bits & 0x7fffffffu) == 0) return;
    const std::string name = type_name(type);
    std::string identity;
    for (int i = 0; i < type.matrix_components(); ++i)
        identity += fmt::format("{}{}", i == 0 ? "" : ", ", i % (type.size + 1) == 0 ? 1 : 0);
    const bool one = value.kind == ExprKind::kConstant && bits &&
                     *bits == (value.type.base == Base::kFloat ? 0x3f800000u : 1u);
    diag::Diagnostic& d =
        sink_->report(expr.span, diag::kMatrixOfOne, name, type.matrix_components());
    d.help(fmt::format("the identity is `{0}({1})`; write `({0})x` if all components are meant",
                       name, identity));
    if (one) d.replace(expr.span, fmt::format("{}({})", name, identity));
}

void ExpressionChecker::help_with_conversion(const Type& from, const Type& to,
                                             diag::Diagnostic* d) const {
    if (to.is(Base::kComposition)) {
        d->help(from.is(Base::kMaterial)
                    ? "use a composition: `MaterialComposition mc; mc.Set(material, 1);`"
                    : "declare a `MaterialComposition mc`, fill it with `mc.Set(material, "
                      "amount)`, and use that");
    } else if (from.is_vector() && to.is_vector() && from.size < to.size) {
        const char* rest = to.size - from.size == 1 ? "0" : "0, 0";
        d->help(fmt::format("add the missing components: `{}(v, {})`", type_name(to), rest));
    } else if (from.is(Base::kMaterial) && to.is_arithmetic()) {
        d->help("a material is not a number: `mc.Get(m)` is how much of it a composition holds");
    } else if (to.is_array() && from.is_scalar()) {
        d->help(fmt::format("the same for all elements is `({})…`, a value for each `{{a, b, …}}`",
                            type_name(to)));
    } else if (to == kVoidType) {
        d->help("a function that gives something back has its type: `float f(…)`");
    } else if (from.is(Base::kSurfacePoint)) {
        d->help("use one of its members, such as `.position`, `.normal` or `.distance`");
    }
}

/// Warns about a constant that an `int` or `uint` does not hold. A minus before a `uint` is read as
/// it is meant: `-2147483648` is an int.
void ExpressionChecker::check_fits(const Expr& value, const Type& to) {
    if (!value.type.is_scalar() || !value.type.is_integer() || !to.is_integer()) return;
    const bool negated = value.kind == ExprKind::kUnary && value.op == ir::Op::kNeg &&
                         value.type.base == Base::kUint;
    const std::optional<uint32_t> bits = known_bits(negated ? *value.args[0] : value);
    if (!bits) return;
    const int64_t read =
        value.type.base == Base::kInt ? static_cast<int32_t>(*bits) : static_cast<int64_t>(*bits);
    const int64_t x = negated ? -read : read;
    const auto cut = static_cast<uint32_t>(x);
    const int64_t becomes = to.base == Base::kInt ? static_cast<int32_t>(cut) : int64_t{cut};
    if (x == becomes) return;
    const std::string type = type_name(to.base == Base::kInt ? kIntType : kUintType);
    sink_->report(value.span, diag::kNarrowing, std::to_string(x), type)
        .help(fmt::format("it becomes {}; write the conversion if that is intended: `{}(…)`",
                          becomes, type))
        .insert_before(value.span, type + "(")
        .insert_after(value.span, ")");
}

/// Warns about `1 / 2` where a float is expected: it is 0. Constants only; `i / 4` may be intended.
void ExpressionChecker::check_division(const Expr& value, const Type& to) {
    const bool division = value.kind == ExprKind::kBinary && value.op == ir::Op::kDiv &&
                          value.type.is_scalar() && value.type.is_integer();
    if (!division || to.base != Base::kFloat) return;
    const std::optional<uint32_t> a = known_bits(*value.args[0]);
    const std::optional<uint32_t> b = known_bits(*value.args[1]);
    if (!a || !b) return;
    const bool is_signed = value.type.base == Base::kInt;
    const int64_t x = is_signed ? static_cast<int32_t>(*a) : int64_t{*a};
    const int64_t y = is_signed ? static_cast<int32_t>(*b) : int64_t{*b};
    if (y != 0 && x % y == 0) return;
    sink_
        ->report(value.span, diag::kIntegerDivision, static_cast<int>(x), static_cast<int>(y),
                 y == 0 ? 0 : static_cast<int>(x / y))
        .help(fmt::format("write `{0}.0 / {1}`, or `float({0} / {1})` if that is intended", x, y))
        .insert_after(value.args[0]->span,
                      value.args[0]->kind == ExprKind::kConstant ? ".0" : " * 1.0");
}

}  // namespace openfab::check

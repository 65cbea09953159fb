// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Implicit conversions, which warn of what they lose, and those that are written.
#include "compiler/check/conversions.h"

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

#include "compiler/check/nodes.h"

namespace openfab::check {

namespace {

/// Returns whether a value can be converted to a type, possibly with loss.
bool converts(const Type& from, const Type& to) {
    if (!from.is_arithmetic() || !to.is_arithmetic()) return false;
    if (from.is_scalar()) return true;
    if (from.is_matrix() != to.is_matrix()) return false;
    return from.size >= to.size && from.rows >= to.rows;
}

}  // namespace

ExprPtr Conversions::explicitly(ExprPtr value, const Type& to) const {
    const Type from = value->type;
    if (from.is_error() || from == to) return value;
    if (!converts(from, to)) {
        diag::Diagnostic& d =
            sink_->report(value->span, diag::kNoConversion, type_name(from), type_name(to));
        help(from, to, &d);
        return poison(value->span);
    }
    ExprPtr out = make(ExprKind::kConvert, to, value->span);
    out->args.push_back(std::move(value));
    return out;
}

ExprPtr Conversions::implicit(ExprPtr value, const Type& to) const {
    const Type from = value->type;
    if (from.is_error() || to.is_error() || from == to) return value;
    const source::Span span = value->span;
    check_division(*value, to);
    check_fits(*value, to);
    ExprPtr out = explicitly(std::move(value), to);
    if (out->type.is_error()) return out;
    if (from.is_matrix()) {
        if (from.size == to.size && from.rows == to.rows) return out;
        sink_->report(span, diag::kNarrowing, type_name(from), type_name(to))
            .help(fmt::format("write the conversion: `({})`", type_name(to)))
            .insert_before(span, type_name(to) + "(")
            .insert_after(span, ")");
    } else if (from.base == Base::kBool && to.base == Base::kBool && to.is_scalar()) {
        sink_->report(span, diag::kNarrowing, type_name(from), type_name(to))
            .help("write `all(…)` or `any(…)`");
    } else if (from.size > to.size) {
        const std::string_view lanes =
            std::string_view("xyzw").substr(0, static_cast<size_t>(to.size));
        sink_->report(span, diag::kNarrowing, type_name(from), type_name(to))
            .help(fmt::format("write which components are meant: `.{}`", lanes))
            .insert_before(span, "(")
            .insert_after(span, fmt::format(").{}", lanes));
    } else if (from.base == Base::kFloat && to.is_integer()) {
        sink_->report(span, diag::kNarrowing, type_name(from), type_name(to))
            .help(fmt::format("write the conversion: `{}(…)`", type_name(to)))
            .insert_before(span, type_name(to) + "(")
            .insert_after(span, ")");
    }
    return out;
}

void Conversions::help(const Type& from, const Type& to, diag::Diagnostic* d) {
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
void Conversions::check_fits(const Expr& value, const Type& to) const {
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

void Conversions::check_division(const Expr& value, const Type& to) const {
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

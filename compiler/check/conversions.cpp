// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Conversions: implicit ones, which warn of what they lose, and casts.
#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "compiler/check/expression_checker.h"

namespace openfab::check {

namespace {

/// Returns whether a type is made of numbers alone.
bool is_of_numbers(const Type& type) {
    if (type.base != Base::kStruct) return is_number(type.base);
    return std::all_of(type.record->members.begin(), type.record->members.end(),
                       [](const StructMember& member) { return is_of_numbers(member.type); });
}

/// Returns whether a value can be converted to a type, possibly with loss.
bool converts(const Type& from, const Type& to) {
    if (!from.is_arithmetic() || !to.is_arithmetic()) return false;
    if (from.is_scalar()) return true;
    if (from.is_matrix() != to.is_matrix()) return false;
    return from.size >= to.size && from.rows >= to.rows;
}

}  // namespace

/// Returns the type that a cast names: `(float2)`, `(Hit[3])`.
Type ExpressionChecker::cast_type(const ast::Expr& expr) {
    const ast::TypeRef name{expr.text, expr.text_span};
    const std::span<const ast::ExprPtr> extents(expr.args.begin() + 1, expr.args.end());
    return extents.empty() ? declared_type(name)
                           : array_type(name, expr.text, extents, expr.text_span, nullptr);
}

ExprPtr ExpressionChecker::cast(const ast::Expr& expr) {
    const Type type = cast_type(expr);
    ExprPtr value = expression(*expr.args[0]);
    if (type.is_error() || value->type.is_error()) return poison(expr.span);
    const Type from = value->type;
    const bool aggregate = type.is(Base::kStruct) || type.is_array();
    // `(Pair)0`, `(Pair[3])0`: every component. Arrays of one shape: element by element.
    const bool same_shape = from.is_array() && type.is_array() && from.rows == type.rows &&
                            from.size == type.size && from.extents == type.extents &&
                            is_of_numbers(from) && from.record == nullptr && type.record == nullptr;
    if (aggregate && is_of_numbers(type) && (from.is_scalar() || same_shape)) {
        if (from == type) return value;
        ExprPtr out = make(ExprKind::kConvert, type, expr.span);
        out->args.push_back(std::move(value));
        return out;
    }
    return convert_explicitly(std::move(value), type);
}

ExprPtr ExpressionChecker::convert_explicitly(ExprPtr value, const Type& to) {
    const Type from = value->type;
    if (from.is_error() || from == to) return value;
    if (!converts(from, to)) {
        diag::Diagnostic& d =
            sink_->report(value->span, diag::kNoConversion, type_name(from), type_name(to));
        help_with_conversion(from, to, &d);
        return poison(value->span);
    }
    ExprPtr out = make(ExprKind::kConvert, to, value->span);
    out->args.push_back(std::move(value));
    return out;
}

ExprPtr ExpressionChecker::convert(ExprPtr value, const Type& to) {
    const Type from = value->type;
    if (from.is_error() || to.is_error() || from == to) return value;
    const source::Span span = value->span;
    check_division(*value, to);
    check_fits(*value, to);
    ExprPtr out = convert_explicitly(std::move(value), to);
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

}  // namespace openfab::check

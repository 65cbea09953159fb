// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/constructors.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string>
#include <utility>

namespace openfab::check {

namespace {

std::string plural(int count, const char* word) {
    return fmt::format("{} {}{}", count, word, count == 1 ? "" : "s");
}

/// Returns whether a type is made of numbers alone.
bool is_of_numbers(const Type& type) {
    if (type.base != Base::kStruct) return is_number(type.base);
    return std::all_of(type.record->members.begin(), type.record->members.end(),
                       [](const StructMember& member) { return is_of_numbers(member.type); });
}

}  // namespace

ExprPtr Constructors::construct(const ast::Expr& expr, const Type& type,
                                std::vector<ExprPtr> args) const {
    const ast::Expr& callee = *expr.args[0];
    if (any_error(args)) return poison(expr.span);
    if (!type.is_arithmetic()) {
        sink_->report(callee.span, diag::kNotAFunction, callee.text);
        return poison(expr.span);
    }
    const bool four = type.is_matrix() && args.size() == 1 && args[0]->type.is_vector();
    if (args.size() == 1 && !four) {
        check_matrix_of(expr, type, *args[0]);
        ExprPtr out = conversions_.explicitly(std::move(args[0]), type);
        out->span = expr.span;
        return out;
    }
    int components = 0;
    const int wanted = static_cast<int>(min_components(type));
    for (ExprPtr& arg : args) {
        if (!arg->type.is_numeric()) {
            sink_->report(arg->span, diag::kNoConversion, type_name(arg->type), type_name(type));
            return poison(expr.span);
        }
        const int size = arg->type.size;
        components += size;
        conversions_.check_division(*arg, type);
        arg = conversions_.explicitly(std::move(arg), {type.base, size});
    }
    if (components != wanted) {
        wrong_count(sink_, expr, callee.text, plural(wanted, "component"),
                    static_cast<size_t>(components));
        return poison(expr.span);
    }
    ExprPtr out = make(ExprKind::kConstruct, type, expr.span);
    out->args = std::move(args);
    return out;
}

/// `Pair(1, 2)` is equivalent to a list of the members.
ExprPtr Constructors::construct_struct(const ast::Expr& expr, const Type& type) const {
    const std::vector<StructMember>& members = type.record->members;
    if (expr.args.size() - 1 != members.size()) {
        wrong_count(sink_, expr, expr.args[0]->text,
                    plural(static_cast<int>(members.size()), "argument"), expr.args.size() - 1);
        return poison(expr.span);
    }
    ExprPtr out = make(ExprKind::kConstruct, type, expr.span);
    for (size_t i = 0; i < members.size(); ++i) {
        out->args.push_back(initializers_.of(*expr.args[i + 1], members[i].type));
    }
    return any_error(out->args) ? poison(expr.span) : std::move(out);
}

/// Returns the type that a cast names: `(float2)`, `(Hit[3])`.
Type Constructors::cast_type(const ast::Expr& expr) const {
    const ast::TypeRef name{expr.text, expr.text_span};
    const std::span<const ast::ExprPtr> extents(expr.args.begin() + 1, expr.args.end());
    return extents.empty() ? types_.declared_type(name)
                           : types_.array_type(name, expr.text, extents, expr.text_span, nullptr);
}

ExprPtr Constructors::cast(const ast::Expr& expr) const {
    const Type type = cast_type(expr);
    ExprPtr value = expressions_.expression(*expr.args[0]);
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
    return conversions_.explicitly(std::move(value), type);
}

/// Warns about `float3x3(1)`, which is the identity in GLSL. `(float3x3)1` says that all components are meant.
void Constructors::check_matrix_of(const ast::Expr& expr, const Type& type,
                                   const Expr& value) const {
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

}  // namespace openfab::check

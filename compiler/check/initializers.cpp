// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/initializers.h"

#include <fmt/format.h>

namespace openfab::check {

namespace {

/// Returns the element types that an initializer list for type `to` expects; empty where it has
/// none.
std::vector<Type> parts_of(const Type& to, size_t count) {
    if (to.is(Base::kStruct)) {
        std::vector<Type> out;
        for (const StructMember& member : to.record->members)
            out.push_back(member.type);
        return out;
    }
    if (to.is_matrix() && count == static_cast<size_t>(to.matrix_components())) {
        return std::vector<Type>(count, to.element().element());
    }
    if (to.is_array() || to.is_matrix() || to.is_vector()) {
        return std::vector<Type>(static_cast<size_t>(to.length()), to.element());
    }
    return {};
}

/// Appends the scalars of a value in order; false if it holds anything but numbers.
bool scalars_of(const Type& type, std::vector<Type>* out) {
    if (type.is_error()) return false;
    if (type.is_scalar()) {
        out->push_back(type);
        return true;
    }
    if (!type.is(Base::kStruct) && !type.is_array() && !type.is_arithmetic()) return false;
    for (const Type& part : parts_of(type, 0)) {
        if (!scalars_of(part, out)) return false;
    }
    return true;
}

}  // namespace

ExprPtr Initializers::of(const ast::Expr& expr, const Type& to) const {
    if (expr.kind == ast::ExprKind::kInitList) return list(expr, to);
    return conversions_.implicit(expressions_.expression(expr), to);
}

ExprPtr Initializers::list(const ast::Expr& expr, const Type& to) const {
    if (to.is_error()) return poison(expr.span);
    if (expr.args.empty()) {
        // Zero in all components, or an empty composition; materials and textures have no such
        // value.
        for (Base base : {Base::kMaterial, Base::kTexture2D, Base::kTexture3D, Base::kObject,
                          Base::kSurfaceAttributes, Base::kVolumeAttributes,
                          Base::kDitherAttributes, Base::kShapeAttributes, Base::kGrowAttributes}) {
            if (!contains(to, base)) continue;
            sink_->report(expr.span, diag::kNoConversion, "{ }", type_name(to));
            return poison(expr.span);
        }
        return make(ExprKind::kConstruct, to, expr.span);
    }
    if (to.is_scalar() && expr.args.size() == 1) return of(*expr.args[0], to);
    const std::vector<Type> parts = parts_of(to, expr.args.size());
    if (parts.size() == expr.args.size()) return list_of(expr, to, parts);
    // A list may also hold all components, flattened, as in HLSL.
    std::vector<ExprPtr> values;
    std::vector<Type> wanted;
    size_t given = 0;
    if (!flatten(expr, to, &values)) return poison(expr.span);
    bool numbers = scalars_of(to, &wanted);
    for (const ExprPtr& value : values) {
        std::vector<Type> scalars;
        numbers = scalars_of(value->type, &scalars) && numbers;
        given += scalars.size();
    }
    const bool one_base = numbers && contains(to, wanted[0].base) && !contains(to, Base::kStruct);
    if (!one_base || given != wanted.size() || parts.empty()) {
        if (parts.empty()) {
            sink_->report(expr.span, diag::kNoConversion, "{ … }", type_name(to));
        } else {
            sink_->report(expr.span, diag::kArgumentCount, type_name(to),
                          fmt::format("a list of {} values", parts.size()),
                          static_cast<int>(expr.args.size()));
        }
        return poison(expr.span);
    }
    ExprPtr out = make(ExprKind::kConstruct, to, expr.span);
    for (ExprPtr& value : values) {
        Type type = value->type;
        type.base = wanted[0].base;
        out->args.push_back(conversions_.implicit(std::move(value), type));
        if (out->args.back()->type.is_error()) return poison(expr.span);
    }
    return out;
}

ExprPtr Initializers::list_of(const ast::Expr& expr, const Type& to,
                              const std::vector<Type>& parts) const {
    ExprPtr out = make(ExprKind::kConstruct, to, expr.span);
    bool ok = true;
    for (size_t i = 0; i < parts.size(); ++i) {
        out->args.push_back(of(*expr.args[i], parts[i]));
        ok = ok && !out->args.back()->type.is_error();
    }
    return ok ? std::move(out) : poison(expr.span);
}

bool Initializers::flatten(const ast::Expr& expr, const Type& to, std::vector<ExprPtr>* out) const {
    for (const ast::ExprPtr& item : expr.args) {
        if (item->kind == ast::ExprKind::kInitList) {
            if (!flatten(*item, to, out)) return false;
            continue;
        }
        out->push_back(expressions_.expression(*item));
        if (out->back()->type.is_error()) return false;
    }
    return true;
}

}  // namespace openfab::check

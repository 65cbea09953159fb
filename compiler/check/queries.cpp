// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Queries of surfaces: `distance(p)`, `nearest(p)`, `distance_to(object, p)`, `walk_end(p, stop, seed)`.
#include "compiler/check/queries.h"

#include <utility>

#include "compiler/check/check.h"
#include "compiler/check/nodes.h"

namespace openfab::check {

namespace {

bool is_point(const Type& type) {
    return type.is_numeric() && type.size == 3;
}

}  // namespace

bool Queries::asks(std::string_view name) {
    return name == "nearest" || name == "distance_to" || name == "distanceTo" || name == "walk_end";
}

/// Reports a query outside the volume stage; a shape may ask for the distance to an object.
bool Queries::is_in_volume(const ast::Expr& callee, const char* help) const {
    const bool of_object = callee.text == "distance_to" || callee.text == "distanceTo";
    if (place_.context == StageContext::kShape && of_object) return true;
    if (rules_.refuse_in_dither(callee.span, callee.text) ||
        rules_.refuse_in_shape(callee.span, callee.text, shape_query_help(callee.text)))
        return false;
    if (place_.context == StageContext::kSurface) {
        diag::Diagnostic& d = sink_->report(callee.span, diag::kStageMismatch, callee.text,
                                            "called in a surface stage");
        d.note(place_.stage, "stage declared `@Surface` here");
        if (help != nullptr) d.help(help);
    } else if (place_.context == StageContext::kGlobal) {
        sink_->report(callee.span, diag::kStageMismatch, callee.text, "called outside a stage");
    }
    return place_.context == StageContext::kVolume || place_.context == StageContext::kFunction;
}

ExprPtr Queries::distance(const ast::Expr& expr, std::vector<ExprPtr> args) const {
    const ast::Expr& callee = *expr.args[0];
    if (!is_in_volume(callee,
                      "with one argument it asks for the distance to the surface; with two "
                      "it is the distance between points")) {
        return poison(expr.span);
    }
    if (!is_point(args[0]->type)) {
        sink_->report(callee.span, diag::kNoOverload, "distance", type_list(args))
            .help(
                "with one argument it takes a point, a `float3`; the distance between two points "
                "takes both");
        return poison(expr.span);
    }
    ExprPtr out = make(ExprKind::kDistance, kFloatType, expr.span);
    out->args.push_back(conversions_.implicit(std::move(args[0]), kFloat3Type));
    return any_error(out->args) ? poison(expr.span) : std::move(out);
}

ExprPtr Queries::surface(const ast::Expr& expr, std::vector<ExprPtr> args) const {
    const ast::Expr& callee = *expr.args[0];
    if (callee.text == "walk_end") return walk(expr, std::move(args));
    if (!is_in_volume(callee, nullptr)) return poison(expr.span);
    const bool nearest = callee.text == "nearest";
    const size_t count = nearest ? 1 : 2;
    if (args.size() != count) {
        wrong_count(sink_, expr, callee.text,
                    nearest ? "1 argument, a point" : "2 arguments, an object and a point",
                    args.size());
        return poison(expr.span);
    }
    if (!is_point(args.back()->type) || (!nearest && !args[0]->type.is(Base::kObject))) {
        sink_->report(callee.span, diag::kNoOverload, callee.text, type_list(args))
            .help(nearest ? "it takes a point, a `float3`"
                          : "it takes an `Object` and a point, a `float3`");
        return poison(expr.span);
    }
    ExprPtr out = make(nearest ? ExprKind::kNearestPoint : ExprKind::kDistanceTo,
                       nearest ? Type{Base::kSurfacePoint} : kFloatType, expr.span);
    args.back() = conversions_.implicit(std::move(args.back()), kFloat3Type);
    out->args = std::move(args);
    return any_error(out->args) ? poison(expr.span) : std::move(out);
}

ExprPtr Queries::walk(const ast::Expr& expr, std::vector<ExprPtr> args) const {
    const ast::Expr& callee = *expr.args[0];
    if (!is_in_volume(callee, nullptr)) return poison(expr.span);
    const size_t object = args.size() == 4 ? 1 : 0;
    if (args.size() != 3 + object) {
        wrong_count(sink_, expr, callee.text,
                    "3 arguments, a point, where to stop and a seed, or an object before them",
                    args.size());
        return poison(expr.span);
    }
    const auto is_number = [](const Type& type) { return type.is_numeric() && type.size == 1; };
    if (!is_point(args[object]->type) || (object != 0 && !args[0]->type.is(Base::kObject)) ||
        !is_number(args[object + 1]->type) || !is_number(args[object + 2]->type)) {
        sink_->report(callee.span, diag::kNoOverload, callee.text, type_list(args))
            .help(
                "it takes a point, a `float3`, a `float` and an `int`, or an `Object` before them");
        return poison(expr.span);
    }
    ExprPtr out = make(ExprKind::kWalkEnd, Type{Base::kFloat, 4}, expr.span);
    args[object] = conversions_.implicit(std::move(args[object]), kFloat3Type);
    args[object + 1] = conversions_.implicit(std::move(args[object + 1]), kFloatType);
    args[object + 2] = conversions_.implicit(std::move(args[object + 2]), kIntType);
    out->args = std::move(args);
    return any_error(out->args) ? poison(expr.span) : std::move(out);
}

}  // namespace openfab::check

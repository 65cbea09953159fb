// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/intrinsic_calls.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

namespace openfab::check {

ExprPtr Intrinsics::call(const ast::Expr& expr, const IntrinsicInfo& info,
                         std::vector<ExprPtr> args) const {
    if (info.shape == Shape::kOwn) return own_.call(expr, info, std::move(args));
    if (info.shape == Shape::kBits) return bits(expr, info, std::move(args));
    if (static_cast<int>(args.size()) != info.arity) {
        const std::string right =
            info.id == Intrinsic::kAtan && args.size() == 2
                ? "1 argument (`atan2` takes y and x)"
                : fmt::format("{} argument{}", info.arity, info.arity == 1 ? "" : "s");
        wrong_count(sink_, expr, info.name, right, args.size());
        return poison(expr.span);
    }
    if (info.shape == Shape::kBool) return conditions_.bools(expr, info, std::move(args));
    if (info.shape == Shape::kSelect)
        return conditions_.choose(expr, expr.args[0]->span, info.name, std::move(args));
    const bool mixture = info.id == Intrinsic::kLerp && args[0]->type.is(Base::kComposition) &&
                         args[1]->type == args[0]->type && args[2]->type.is_scalar();
    const bool numbers = std::all_of(args.begin(), args.end(),
                                     [](const ExprPtr& arg) { return arg->type.is_numeric(); });
    if (!numbers && !mixture) {
        diag::Diagnostic& d =
            sink_->report(expr.args[0]->span, diag::kNoOverload, info.name, type_list(args));
        if (args[0]->type.is(Base::kMaterial)) {
            d.help("mix materials in a composition: `mc.Set(a, 1 - t); mc.Set(b, t);`");
        }
        return poison(expr.span);
    }
    ExprPtr out = make(ExprKind::kIntrinsic, args[0]->type, expr.span);
    out->intrinsic = info.id;
    if (mixture) {
        args[2] = conversions_.implicit(std::move(args[2]), kFloatType);
        out->args = std::move(args);
        return out;
    }
    Type type = args[0]->type;
    for (const ExprPtr& arg : args)
        type = common_type(type, arg->type);
    const bool makes_float =
        info.shape == Shape::kFloat || info.shape == Shape::kToBool || info.shape == Shape::kReduce;
    if (makes_float) type.base = Base::kFloat;
    if (info.shape == Shape::kFloat3) type = kFloat3Type;
    if (type.base == Base::kBool && info.shape != Shape::kReduceBool) type.base = Base::kInt;
    for (ExprPtr& arg : args)
        arg = conversions_.implicit(std::move(arg), type);
    if (any_error(args)) return poison(expr.span);
    out->type = type;
    if (info.shape == Shape::kToInt) out->type.base = Base::kInt;
    if (info.shape == Shape::kToBool) out->type.base = Base::kBool;
    if (info.shape == Shape::kReduceBool) out->type = kBoolType;
    if (info.shape == Shape::kDot || info.shape == Shape::kReduce) out->type.size = 1;
    out->args = std::move(args);
    return out;
}

/// asfloat and the like take any number; bit counts take integers.
ExprPtr Intrinsics::bits(const ast::Expr& expr, const IntrinsicInfo& info,
                         std::vector<ExprPtr> args) const {
    const ast::Expr& callee = *expr.args[0];
    if (args.size() != 1) {
        wrong_count(sink_, expr, info.name, "1 argument", args.size());
        return poison(expr.span);
    }
    const Type type = args[0]->type;
    const bool casts = info.id == Intrinsic::kAsFloat || info.id == Intrinsic::kAsInt ||
                       info.id == Intrinsic::kAsUint;
    const bool fits = casts ? type.is_numeric() && type.base != Base::kBool
                            : type.is_numeric() && type.is_integer();
    if (!fits) {
        sink_->report(callee.span, diag::kNoOverload, info.name, type_name(type))
            .help(casts ? "it takes the bits of an `int`, a `uint` or a `float`"
                        : "it takes an `int` or a `uint`");
        return poison(expr.span);
    }
    ExprPtr out = make(ExprKind::kIntrinsic, {Base::kUint, type.size}, expr.span);
    if (info.id == Intrinsic::kAsFloat) out->type.base = Base::kFloat;
    if (info.id == Intrinsic::kAsInt) out->type.base = Base::kInt;
    out->intrinsic = info.id;
    out->args = std::move(args);
    return out;
}

}  // namespace openfab::check

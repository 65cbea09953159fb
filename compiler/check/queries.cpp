// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Queries of surfaces: `distance(p)`, `nearest(p)`, `distance_to(object, p)`; and lookups in
// pictures and volumes.

#include <fmt/format.h>

#include <algorithm>

#include "compiler/check/expression_checker.h"

namespace openfab::check {

namespace {

bool is_point(const Type& type) {
    return type.is_numeric() && type.size == 3;
}

}  // namespace

bool ExpressionChecker::is_lookup(std::string_view name) {
    return name.size() == 7 && name.substr(0, 6) == "Sample" && name[6] >= '1' && name[6] <= '4';
}

bool ExpressionChecker::is_query(std::string_view name) {
    return name == "nearest" || name == "distance_to" || name == "distanceTo";
}

/// Reports what a dither rule cannot use; false elsewhere.
bool ExpressionChecker::refuse_in_dither(const source::Span& span, std::string_view what) {
    if (context_ != StageContext::kDither) return false;
    sink_->report(span, diag::kStageMismatch, what, "called in a dither stage")
        .note(stage_span_, "stage declared `@Dither` here")
        .help("a dither rule looks at the voxel's fractions and its index");
    return true;
}

/// Reports what a shape, or a rule that grows, cannot use; false elsewhere.
bool ExpressionChecker::refuse_in_shape(const source::Span& span, std::string_view what,
                                        const char* help) {
    if (context_ != StageContext::kShape && context_ != StageContext::kGrow) return false;
    const bool grows = context_ == StageContext::kGrow;
    sink_
        ->report(span, diag::kStageMismatch, what,
                 grows ? "called in a grow stage" : "called in a shape stage")
        .note(stage_span_, grows ? "stage declared `@Grow` here" : "stage declared `@Shape` here")
        .help(grows ? kNoQueriesInGrow : help);
    return true;
}

/// Reports a query outside the volume stage; a shape may ask for the distance to an object.
bool ExpressionChecker::query_is_in_volume(const ast::Expr& callee, const char* help) {
    const bool of_object = callee.text == "distance_to" || callee.text == "distanceTo";
    if (context_ == StageContext::kShape && of_object) return true;
    if (refuse_in_dither(callee.span, callee.text) ||
        refuse_in_shape(callee.span, callee.text, shape_query_help(callee.text)))
        return false;
    if (context_ == StageContext::kSurface) {
        diag::Diagnostic& d = sink_->report(callee.span, diag::kStageMismatch, callee.text,
                                            "called in a surface stage");
        d.note(stage_span_, "stage declared `@Surface` here");
        if (help != nullptr) d.help(help);
    } else if (context_ == StageContext::kGlobal) {
        sink_->report(callee.span, diag::kStageMismatch, callee.text, "called outside a stage");
    }
    return context_ == StageContext::kVolume || context_ == StageContext::kFunction;
}

ExprPtr ExpressionChecker::distance_query(const ast::Expr& expr, std::vector<ExprPtr> args) {
    const ast::Expr& callee = *expr.args[0];
    if (!query_is_in_volume(callee,
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
    out->args.push_back(convert(std::move(args[0]), kFloat3Type));
    return any_error(out->args) ? poison(expr.span) : std::move(out);
}

/// `nearest(p)` or `distance_to(object, p)`.
ExprPtr ExpressionChecker::surface_query(const ast::Expr& expr, std::vector<ExprPtr> args) {
    const ast::Expr& callee = *expr.args[0];
    if (!query_is_in_volume(callee, nullptr)) return poison(expr.span);
    const bool nearest = callee.text == "nearest";
    const size_t count = nearest ? 1 : 2;
    if (args.size() != count) {
        wrong_count(expr, callee.text,
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
    args.back() = convert(std::move(args.back()), kFloat3Type);
    out->args = std::move(args);
    return any_error(out->args) ? poison(expr.span) : std::move(out);
}

/// Sample1 to Sample4 of a picture, (u, v, channel) or (uv, channel), or of a volume, (p, channel);
/// each with an optional width at the end.
ExprPtr ExpressionChecker::lookup(const ast::Expr& expr, ExprPtr texture,
                                  std::vector<ExprPtr> args) {
    const ast::Expr& callee = *expr.args[0];
    const std::string_view name = callee.text;
    if (context_ == StageContext::kGlobal) {
        sink_->report(callee.text_span, diag::kStageMismatch, name, "called outside a stage");
        return poison(expr.span);
    }
    if (refuse_in_dither(callee.text_span, name)) return poison(expr.span);
    const bool volume = texture->type.is(Base::kTexture3D);
    const int axes = volume ? 3 : 2;
    const bool numbers = std::all_of(args.begin(), args.end(),
                                     [](const ExprPtr& arg) { return arg->type.is_numeric(); });
    const bool vector = !args.empty() && args[0]->type.size == axes;
    const bool scalars =
        !volume && args.size() >= 2 && args[0]->type.is_scalar() && args[1]->type.is_scalar();
    if (!args.empty() && (!numbers || (!vector && !scalars))) {
        sink_->report(callee.text_span, diag::kNoOverload, name, type_list(args))
            .help(volume ? fmt::format("`{0}(p, channel)` of a point `float3 p` in mm, with a last "
                                       "`width` or without",
                                       name)
                         : fmt::format("`{0}(u, v, channel)` or `{0}(uv, channel)`, with a last "
                                       "`width` or without",
                                       name));
        return poison(expr.span);
    }
    const size_t coordinates = volume || vector ? 1 : 2;
    if (args.size() != coordinates + 1 && args.size() != coordinates + 2) {
        wrong_count(expr, name,
                    volume   ? "a point, a channel and perhaps a width: 2 or 3 arguments"
                    : vector ? "uv, a channel and perhaps a width: 2 or 3 arguments"
                             : "u, v, a channel and perhaps a width: 3 or 4 arguments",
                    args.size());
        return poison(expr.span);
    }
    ExprPtr out = make(ExprKind::kSample, {Base::kFloat, name[6] - '0'}, expr.span);
    ExprPtr width = make(ExprKind::kConstant, kFloatType, expr.span);
    width->bits = 0x3f800000u;  // 1
    if (args.size() == coordinates + 2) width = convert(std::move(args.back()), kFloatType);
    out->args.push_back(std::move(texture));
    out->args.push_back(convert(std::move(args[coordinates]), kIntType));
    out->args.push_back(std::move(width));
    for (size_t i = 0; i < coordinates; ++i)
        out->args.push_back(convert(std::move(args[i]), {Base::kFloat, vector ? axes : 1}));
    return any_error(out->args) ? poison(expr.span) : std::move(out);
}

ExprPtr ExpressionChecker::unknown_lookup(const ast::Expr& expr, const Type& texture) {
    const ast::Expr& callee = *expr.args[0];
    const std::vector<std::string> names = {"Sample1", "Sample2", "Sample3", "Sample4"};
    diag::Diagnostic& d =
        sink_->report(callee.text_span, diag::kUnknownMember, type_name(texture), callee.text);
    // `picture.Sample(uv)`, `picture.Sample(sampler, uv)`, `picture.SampleLevel(sampler, uv, 0)` of HLSL.
    if (callee.text == "Sample" || callee.text == "SampleLevel" || callee.text == "Load") {
        d.help(fmt::format(
            "`Sample1` to `Sample4` read that many channels, without a sampler: "
            "`{}.Sample4({}, 0)`",
            callee.args[0]->kind == ast::ExprKind::kName ? callee.args[0]->text : "picture",
            texture.is(Base::kTexture3D) ? "p" : "uv"));
        const size_t count = expr.args.size() - 1;
        const size_t point = callee.text == "Sample" ? count : callee.text == "SampleLevel" ? 2 : 0;
        if (point == 0 || point > 2 || point >= expr.args.size()) return poison(expr.span);
        const source::Span& at = expr.args[point]->span;
        d.replace({at.file, callee.text_span.begin, at.begin}, "Sample4(")
            .replace({at.file, at.end, expr.args.back()->span.end}, ", 0");
        return poison(expr.span);
    }
    d.suggest(callee.text_span, callee.text, names,
              "it has `Sample1` to `Sample4`, which read that many channels");
    return poison(expr.span);
}

}  // namespace openfab::check

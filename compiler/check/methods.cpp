// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Methods: of pictures and volumes, of curves, of mixtures, and of the attributes of a dither rule.
#include "compiler/check/methods.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

namespace openfab::check {

namespace {

bool is_lookup(std::string_view name) {
    return name.size() == 7 && name.substr(0, 6) == "Sample" && name[6] >= '1' && name[6] <= '4';
}

}  // namespace

ExprPtr Methods::call(const ast::Expr& expr) const {
    const ast::Expr& callee = *expr.args[0];
    ExprPtr object = expressions_.expression(*callee.args[0]);
    if (object->type.is_error()) return poison(expr.span);
    const Type& type = object->type;
    if (!type.is(Base::kTexture2D) && !type.is(Base::kTexture3D) && !type.is(Base::kComposition) &&
        !type.is(Base::kDitherAttributes) && !type.is_curve()) {
        return unknown_.method(expr, callee, type);
    }
    const bool texture = type.is(Base::kTexture2D) || type.is(Base::kTexture3D);
    if (texture && !is_lookup(callee.text)) return unknown_lookup(expr, type);
    std::vector<ExprPtr> args = expressions_.arguments(expr);
    if (any_error(args)) return poison(expr.span);
    if (type.is_curve()) return of_curve(expr, std::move(object), std::move(args));
    if (type.is(Base::kDitherAttributes)) return of_dither(expr, std::move(args));
    return type.is(Base::kComposition) ? of_composition(expr, std::move(object), std::move(args))
                                       : lookup(expr, std::move(object), std::move(args));
}

/// Sample1 to Sample4 of a picture, (u, v, channel) or (uv, channel), or of a volume, (p, channel);
/// each with an optional width at the end.
ExprPtr Methods::lookup(const ast::Expr& expr, ExprPtr texture, std::vector<ExprPtr> args) const {
    const ast::Expr& callee = *expr.args[0];
    const std::string_view name = callee.text;
    if (place_.context == StageContext::kGlobal) {
        sink_->report(callee.text_span, diag::kStageMismatch, name, "called outside a stage");
        return poison(expr.span);
    }
    if (rules_.refuse_in_dither(callee.text_span, name)) return poison(expr.span);
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
        wrong_count(sink_, expr, name,
                    volume   ? "a point, a channel and perhaps a width: 2 or 3 arguments"
                    : vector ? "uv, a channel and perhaps a width: 2 or 3 arguments"
                             : "u, v, a channel and perhaps a width: 3 or 4 arguments",
                    args.size());
        return poison(expr.span);
    }
    ExprPtr out = make(ExprKind::kSample, {Base::kFloat, name[6] - '0'}, expr.span);
    ExprPtr width = make(ExprKind::kConstant, kFloatType, expr.span);
    width->bits = 0x3f800000u;  // 1
    if (args.size() == coordinates + 2)
        width = conversions_.implicit(std::move(args.back()), kFloatType);
    out->args.push_back(std::move(texture));
    out->args.push_back(conversions_.implicit(std::move(args[coordinates]), kIntType));
    out->args.push_back(std::move(width));
    for (size_t i = 0; i < coordinates; ++i)
        out->args.push_back(
            conversions_.implicit(std::move(args[i]), {Base::kFloat, vector ? axes : 1}));
    return any_error(out->args) ? poison(expr.span) : std::move(out);
}

ExprPtr Methods::unknown_lookup(const ast::Expr& expr, const Type& texture) const {
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

ExprPtr Methods::of_curve(const ast::Expr& expr, ExprPtr curve, std::vector<ExprPtr> args) const {
    const ast::Expr& callee = *expr.args[0];
    const Type result{Base::kFloat, curve_channels(curve->type)};
    if (callee.text != "At") {
        sink_->report(callee.text_span, diag::kUnknownMember, type_name(curve->type), callee.text)
            .suggest(callee.text_span, callee.text, std::vector<std::string>{"At"},
                     "it has `At(x)`, its value at x");
        return poison(expr.span);
    }
    if (args.size() != 1) {
        wrong_count(sink_, expr, callee.text, "1 argument, where on the curve", args.size());
        return poison(expr.span);
    }
    if (!args[0]->type.is_scalar()) {
        sink_->report(args[0]->span, diag::kNoConversion, type_name(args[0]->type), "float");
        return poison(expr.span);
    }
    ExprPtr out = make(ExprKind::kCurve, result, expr.span);
    out->args.push_back(std::move(curve));
    out->args.push_back(conversions_.implicit(std::move(args[0]), kFloatType));
    return any_error(out->args) ? poison(expr.span) : std::move(out);
}

/// `attr.Fraction(i)` and `attr.BlueNoise(face)`.
ExprPtr Methods::of_dither(const ast::Expr& expr, std::vector<ExprPtr> args) const {
    struct Method {
        std::string_view name;
        ExprKind kind;
        const char* takes;
    };
    constexpr Method kMethods[] = {
        {"Fraction", ExprKind::kFraction, "1 argument, a number from 0 to `count` - 1"},
        {"BlueNoise", ExprKind::kBlueNoise, "1 argument, a face from 0 to 4"}};
    const ast::Expr& callee = *expr.args[0];
    const auto* method = std::ranges::find(kMethods, callee.text, &Method::name);
    if (method == std::end(kMethods)) {
        sink_->report(callee.text_span, diag::kUnknownMember, "DitherAttributes", callee.text)
            .suggest(callee.text_span, callee.text,
                     std::vector<std::string>{"Fraction", "BlueNoise"},
                     "it has `Fraction(i)`, of 0 to `count` - 1, and `BlueNoise(face)`, of 0 to 4");
        return poison(expr.span);
    }
    if (args.size() != 1) {
        wrong_count(sink_, expr, callee.text, method->takes, args.size());
        return poison(expr.span);
    }
    if (!args[0]->type.is_scalar()) {
        sink_->report(args[0]->span, diag::kNoConversion, type_name(args[0]->type), "int");
        return poison(expr.span);
    }
    ExprPtr out = make(method->kind, kIntType, expr.span);
    out->args.push_back(conversions_.implicit(std::move(args[0]), kIntType));
    return any_error(out->args) ? poison(expr.span) : std::move(out);
}

ExprPtr Methods::of_composition(const ast::Expr& expr, ExprPtr object,
                                std::vector<ExprPtr> args) const {
    struct Method {
        std::string_view name;
        ExprKind kind;
        size_t count;
        Type type;
    };
    const Method methods[] = {
        {"Set", ExprKind::kSet, 2, kVoidType},      {"Add", ExprKind::kAdd, 2, kVoidType},
        {"Get", ExprKind::kGet, 1, kFloatType},     {"Clear", ExprKind::kClear, 0, kVoidType},
        {"Total", ExprKind::kTotal, 0, kFloatType},
    };
    const ast::Expr& callee = *expr.args[0];
    const Method* method = nullptr;
    std::vector<std::string> names;
    for (const Method& m : methods) {
        names.emplace_back(m.name);
        if (m.name == callee.text) method = &m;
    }
    if (method == nullptr) {
        diag::Diagnostic& d = sink_->report(callee.text_span, diag::kUnknownMember,
                                            "MaterialComposition", callee.text);
        if (callee.text == "Normalize" || callee.text == "normalize") {
            d.help("the result of the stage is scaled to a sum of 1 automatically");
        } else {
            d.suggest(callee.text_span, callee.text, names,
                      "it has `Set`, `Add`, `Get`, `Clear` and `Total`");
        }
        return poison(expr.span);
    }
    if (args.size() != method->count) {
        diag::Diagnostic& d = sink_->report(
            callee.text_span, diag::kArgumentCount, callee.text,
            fmt::format("{} argument{}", method->count, method->count == 1 ? "" : "s"),
            static_cast<int>(args.size()));
        if (method->count == 2) {
            d.help(fmt::format("it takes a material and its amount: `{}(material, 0.5)`",
                               method->name));
        }
        return poison(expr.span);
    }
    if (!args.empty() && !args[0]->type.is(Base::kMaterial)) {
        diag::Diagnostic& d =
            sink_->report(args[0]->span, diag::kNoConversion, type_name(args[0]->type), "Material");
        if (args.size() == 2 && args[1]->type.is(Base::kMaterial)) {
            const auto simple = [](const ast::Expr& part) {
                return part.args.empty() && part.kind != ast::ExprKind::kStringLiteral;
            };
            const ast::Expr& amount = *expr.args[1];
            const ast::Expr& material = *expr.args[2];
            d.help(fmt::format("the material comes first, then its amount: `{}({}, {})`",
                               method->name, simple(material) ? material.text : "material",
                               simple(amount) ? amount.text : "amount"));
            if (simple(material) && simple(amount)) {
                d.replace(amount.span, std::string(material.text))
                    .replace(material.span, std::string(amount.text));
            }
        }
        return poison(expr.span);
    }
    if (args.size() == 2) args[1] = conversions_.implicit(std::move(args[1]), kFloatType);
    const bool writes = method->type == kVoidType;
    if (any_error(args) || (writes && !targets_.assignable(*object))) return poison(expr.span);
    ExprPtr out = make(method->kind, method->type, expr.span);
    out->args.push_back(std::move(object));
    for (ExprPtr& arg : args)
        out->args.push_back(std::move(arg));
    return out;
}

}  // namespace openfab::check

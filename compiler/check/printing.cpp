// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// `printf("…", values)` and `assert(condition)`, which may have a format and values too.
#include "compiler/check/printing.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "compiler/check/check.h"

namespace openfab::check {

namespace {

constexpr size_t kMaxPrintedValues = 64;

/// Returns the length of the conversion, such as `%-8.3f`, at the start of `text`, or 0.
size_t conversion_length(std::string_view text) {
    size_t at = 1;
    const auto take = [&](std::string_view set) {
        while (at < text.size() && set.find(text[at]) != std::string_view::npos)
            ++at;
    };
    constexpr std::string_view kDigits = "0123456789";
    take("-+ 0#");
    const size_t width = at;
    take(kDigits);
    size_t longest = at - width;
    if (at < text.size() && text[at] == '.') {
        ++at;
        const size_t precision = at;
        take(kDigits);
        longest = std::max(longest, at - precision);
    }
    return at < text.size() && longest <= 2 ? at + 1 : 0;
}

/// Returns the type that a conversion takes; an error type if the letter is unknown.
Type conversion_type(char letter) {
    constexpr std::string_view kIntegers = "di";
    constexpr std::string_view kUnsigned = "uxX";
    constexpr std::string_view kFloats = "fFeEgG";
    if (kIntegers.find(letter) != std::string_view::npos) return kIntType;
    if (kUnsigned.find(letter) != std::string_view::npos) return kUintType;
    if (kFloats.find(letter) != std::string_view::npos) return kFloatType;
    return {};
}

/// Returns the conversions of a value: a vector's with spaces between; in braces, with commas, the rows of a matrix, the
/// elements of an array, the members of a struct.
std::string layout(const Type& type, std::string_view conversion) {
    std::string out;
    if (type.is_numeric()) {
        for (int i = 0; i < type.size; ++i)
            out += fmt::format("{}{}", i == 0 ? "" : " ", conversion);
        return out;
    }
    const auto add = [&](const Type& part) {
        out += (out.empty() ? "{" : ", ") + layout(part, conversion);
    };
    if (type.is(Base::kStruct)) {
        for (const StructMember& member : type.record->members)
            add(member.type);
    } else {
        for (int i = 0; i < type.length(); ++i)
            add(type.element());
    }
    return out + "}";
}

char escaped(char c) {
    if (c == 'n') return '\n';
    return c == 't' ? '\t' : c;
}

}  // namespace

/// Returns whether a conversion prints all components of a type; else reports it.
bool Printing::prints(const Type& type, Base wanted, const source::Span& at,
                      std::string_view conversion) const {
    if (type.is_array()) return prints(type.element(), wanted, at, conversion);
    if (type.is(Base::kStruct)) {
        return std::all_of(
            type.record->members.begin(), type.record->members.end(),
            [&](const StructMember& m) { return prints(m.type, wanted, at, conversion); });
    }
    const bool number = type.is_arithmetic();
    if (number && (type.base != Base::kFloat || wanted == Base::kFloat)) return true;
    diag::Diagnostic& d =
        sink_->report(at, diag::kBadOperand, conversion, fmt::format("`{}`", type_name(type)));
    if (number) {
        d.help("`%g` prints a float");
    } else if (type.is(Base::kComposition)) {
        d.help("print an amount of it: `mc.Get(material)`, or `mc.Total()`");
    } else if (type.is(Base::kMaterial)) {
        d.help("a material has no number; `m == core` is true or false");
    } else if (type.is(Base::kSurfacePoint)) {
        d.help("print one of its members, such as `.position` or `.distance`");
    }
    return false;
}

/// Makes a value that is printed one of as many components of a type.
ExprPtr Printing::flattened(ExprPtr value, Base to) const {
    const Type from = value->type;
    if (from.is_numeric()) return conversions_.implicit(std::move(value), {to, from.size});
    ExprPtr out = make(ExprKind::kConvert,
                       array_of({to, 1}, static_cast<int>(min_components(from))), value->span);
    out->args.push_back(std::move(value));
    return out;
}

/// Matches a format with the values from `first` on, converting them to the types of their
/// conversions. What has components is printed one by one, with the same conversion.
bool Printing::match_format(const ast::Expr& literal, std::vector<ExprPtr>* values, size_t first,
                            std::string* out) const {
    const std::string_view text = literal.text;
    const auto span_of = [&](size_t begin, size_t count) {
        source::Span span = literal.span;
        span.begin += static_cast<uint32_t>(begin) + 1;
        span.end = span.begin + static_cast<uint32_t>(count);
        return span;
    };
    size_t next = first;
    int conversions = 0;
    for (size_t at = 0; at < text.size(); ++at) {
        if (text[at] == '\\' && at + 1 < text.size()) {
            *out += escaped(text[++at]);
            continue;
        }
        if (text[at] != '%') {
            *out += text[at];
            continue;
        }
        if (text.substr(at, 2) == "%%") {
            *out += "%%";
            ++at;
            continue;
        }
        const size_t length = conversion_length(text.substr(at));
        const std::string_view conversion = text.substr(at, std::max<size_t>(length, 1));
        const Type wanted = length == 0 ? kErrorType : conversion_type(conversion.back());
        if (wanted.is_error()) {
            sink_->report(span_of(at, conversion.size()), diag::kBadFormat, conversion)
                .help(
                    "`%d` `%u` `%x` take integers, `%f` `%e` `%g` floats; `%%` is a percent sign");
            return false;
        }
        ++conversions;
        if (next < values->size()) {
            ExprPtr& value = (*values)[next++];
            if (!prints(value->type, wanted.base, value->span, conversion)) return false;
            *out += layout(value->type, conversion);
            value = flattened(std::move(value), wanted.base);
        }
        at += length - 1;
    }
    if (static_cast<size_t>(conversions) == values->size() - first) return true;
    sink_->report(literal.span, diag::kArgumentCount, "the format",
                  fmt::format("{} value{}", conversions, conversions == 1 ? "" : "s"),
                  static_cast<int>(values->size() - first));
    return false;
}

/// `printf("…", values)` and `assert(condition)`, which may have a format and values too.
ExprPtr Printing::call(const ast::Expr& expr) const {
    const std::string_view name = expr.args[0]->text;
    const bool is_assert = name == "assert";
    const size_t format = is_assert ? 2 : 1;
    const bool has_format =
        expr.args.size() > format && expr.args[format]->kind == ast::ExprKind::kStringLiteral;
    const bool right = is_assert ? expr.args.size() == 2 || has_format : has_format;
    if (!right) {
        diag::Diagnostic& d = sink_->report(
            expr.args[0]->span, diag::kExpected,
            is_assert ? "`assert(condition)` or `assert(condition, \"format\", values)`"
                      : "`printf(\"format\", values)`",
            "other arguments");
        if (!is_assert && expr.args.size() == 2) {
            d.help("a value is printed by a format: `printf(\"%g\\n\", x)`")
                .insert_before(expr.args[1]->span, "\"%g\\n\", ");
        }
        return poison(expr.span);
    }
    if (place_.context == StageContext::kGlobal) {
        sink_->report(expr.args[0]->span, diag::kStageMismatch, name, "called outside a stage");
        return poison(expr.span);
    }
    if (rules_.refuse_in_dither(expr.args[0]->span, name) ||
        rules_.refuse_in_shape(expr.args[0]->span, name, kNoPrintsInShape))
        return poison(expr.span);
    ExprPtr out = make(ExprKind::kPrintf, kVoidType, expr.span);
    out->is_assert = is_assert;
    if (is_assert) out->args.push_back(conditions_.condition(*expr.args[1]));
    for (size_t i = format + 1; i < expr.args.size(); ++i)
        out->args.push_back(expressions_.expression(*expr.args[i]));
    for (const ExprPtr& arg : out->args) {
        if (arg->type.is_error()) return poison(expr.span);
        const Expr* effect = side_effect(*arg);
        if (effect == nullptr) continue;
        sink_->report(effect->span, diag::kSideEffect, name)
            .help("the call is compiled only when printing is on: move the side effect out of it");
        return poison(expr.span);
    }
    // Every value is buffered until the line is printed; what has components counts per component.
    size_t value_count = 0;
    for (size_t i = is_assert ? 1 : 0; i < out->args.size(); ++i)
        value_count += static_cast<size_t>(min_components(out->args[i]->type));
    if (value_count > kMaxPrintedValues) {
        sink_
            ->report(expr.args[0]->span, diag::kTooComplex,
                     fmt::format("{} values in one call; the limit is {}", value_count,
                                 kMaxPrintedValues))
            .help(fmt::format("split them over several calls of `{}`", name));
        return poison(expr.span);
    }
    if (has_format) {
        const bool ok = match_format(*expr.args[format], &out->args, is_assert ? 1 : 0, &out->text);
        return ok ? std::move(out) : poison(expr.span);
    }
    out->text = "assertion failed";
    return out;
}

}  // namespace openfab::check

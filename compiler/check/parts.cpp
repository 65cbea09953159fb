// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/parts.h"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "compiler/check/attributes.h"
#include "compiler/check/foreign_names.h"

namespace openfab::check {

namespace {

/// Returns the component, 0 to 3, or -1; sets `set` to 1 for xyzw, 2 for rgba.
int lane_of(char c, int* set) {
    constexpr std::string_view kXyzw = "xyzw";
    constexpr std::string_view kRgba = "rgba";
    if (const size_t at = kXyzw.find(c); at != std::string_view::npos) {
        *set = 1;
        return static_cast<int>(at);
    }
    *set = 2;
    const size_t at = kRgba.find(c);
    return at == std::string_view::npos ? -1 : static_cast<int>(at);
}

/// Returns a swizzle as OpenFL has it of one in capitals, of mixed sets, or with `stpq`; empty if that is none of a
/// vector of this size.
std::string foreign_swizzle(std::string_view text, int size) {
    constexpr std::string_view kSets[] = {"xyzw", "rgba", "stpq", "XYZW", "RGBA"};
    std::string out;
    for (char c : text) {
        for (std::string_view set : kSets) {
            const size_t at = set.find(c);
            if (at == std::string_view::npos || at >= static_cast<size_t>(size)) continue;
            out += "xyzw"[at];
            break;
        }
    }
    return out.size() == text.size() && text.size() <= 4 ? out : "";
}

}  // namespace

ExprPtr Parts::member(const ast::Expr& expr) const {
    ExprPtr object = expressions_.expression(*expr.args[0]);
    if (object->type.is_error()) return poison(expr.span);
    if (object->type.is_numeric()) return swizzle(expr, std::move(object));
    if (object->type.is_matrix()) return matrix_swizzle(expr, std::move(object));
    if (object->type.is_attributes()) return attribute_member(expr, object->type);
    if (object->type.is(Base::kStruct)) {
        const StructType& record = *object->type.record;
        return struct_member(expr, std::move(object), record.members);
    }
    if (object->type.is(Base::kSurfacePoint)) {
        return struct_member(
            expr, std::move(object),
            place_.fablet != nullptr ? place_.fablet->point_members : common_point_members());
    }
    if (object->type.is_array()) return unknown_.method(expr, expr, object->type);
    diag::Diagnostic& d =
        sink_->report(expr.text_span, diag::kUnknownMember, type_name(object->type), expr.text);
    if (object->type.is(Base::kComposition)) {
        d.help("`mc.Get(m)` is the amount of a material, `mc.Set(m, x)` sets it");
    }
    return poison(expr.span);
}

ExprPtr Parts::struct_member(const ast::Expr& expr, ExprPtr object,
                             const std::vector<StructMember>& members) const {
    std::vector<std::string> names;
    std::string all;
    for (size_t i = 0; i < members.size(); ++i) {
        if (members[i].name == expr.text) {
            names_.record_use(expr.text_span, members[i]);
            if (members[i].type.is_error()) return poison(expr.span);
            ExprPtr out = make(ExprKind::kMember, members[i].type, expr.span);
            out->bits = static_cast<uint32_t>(i);
            out->args.push_back(std::move(object));
            return out;
        }
        names.push_back(members[i].name);
        all += fmt::format("{}`{}`", all.empty() ? "" : ", ", members[i].name);
    }
    diag::Diagnostic& d =
        sink_->report(expr.text_span, diag::kUnknownMember, type_name(object->type), expr.text)
            .suggest(expr.text_span, expr.text, names, "it has " + all);
    if (d.fix.empty() && object->type.is(Base::kSurfacePoint)) {
        d.help(
            "the volume stage's `@nearest` varyings are members too, in functions of the fablet");
    }
    return poison(expr.span);
}

ExprPtr Parts::index(const ast::Expr& expr) const {
    ExprPtr object = expressions_.expression(*expr.args[0]);
    ExprPtr at = expressions_.expression(*expr.args[1]);
    if (object->type.is_error() || at->type.is_error()) return poison(expr.span);
    const Type type = object->type;
    if (!type.is_array() && !type.is_matrix() && !type.is_vector()) {
        diag::Diagnostic& d = sink_->report(expr.text_span, diag::kBadOperand, "[ ]",
                                            fmt::format("`{}`", type_name(type)));
        if (type.is(Base::kComposition)) {
            d.help("`mc.Get(m)` is the amount of a material, `mc.Set(m, x)` sets it");
        } else if (type.is(Base::kTexture2D) || type.is(Base::kTexture3D)) {
            d.help("a texture is read with `Sample1` to `Sample4`");
        }
        return poison(expr.span);
    }
    if (at->type != kUintType) at = conversions_.implicit(std::move(at), kIntType);
    if (at->type.is_error()) return poison(expr.span);
    if (const std::optional<uint32_t> bits = known_bits(*at)) {
        const auto index = static_cast<int32_t>(*bits);
        if (index < 0 || index >= type.length()) {
            sink_->report(expr.args[1]->span, diag::kOutOfRange, "index", index, 0,
                          type.length() - 1);
            return poison(expr.span);
        }
    }
    ExprPtr out = make(ExprKind::kIndex, type.element(), expr.span);
    out->args.push_back(std::move(object));
    out->args.push_back(std::move(at));
    return out;
}

ExprPtr Parts::attribute_member(const ast::Expr& expr, const Type& attributes) const {
    Type type;
    if (const std::optional<Attribute> id = find_attribute(expr.text, attributes, &type)) {
        ExprPtr out = make(ExprKind::kAttribute, type, expr.span);
        out->attribute = *id;
        names_.record_use(expr.text_span, StructMember{std::string(expr.text), type, {}});
        return out;
    }
    std::vector<std::string> names;
    std::string list;
    for (const StructMember& member : attribute_members(attributes)) {
        names.push_back(member.name);
        list += fmt::format("{}`{}`", list.empty() ? "" : ", ", member.name);
    }
    diag::Diagnostic& d =
        sink_->report(expr.text_span, diag::kUnknownMember, type_name(attributes), expr.text);
    if (const std::string help = foreign_attribute_help(expr.text, attributes); !help.empty()) {
        d.help(help);
    } else {
        d.suggest(expr.text_span, expr.text, names, "it has " + list);
    }
    return poison(expr.span);
}

ExprPtr Parts::swizzle(const ast::Expr& expr, ExprPtr object) const {
    ExprPtr out = make(ExprKind::kSwizzle, object->type, expr.span);
    const std::string_view text = expr.text;
    int first_set = 0;
    bool ok = text.size() <= 4;
    for (size_t i = 0; i < text.size() && ok; ++i) {
        int set = 0;
        const int lane = lane_of(text[i], &set);
        if (i == 0) first_set = set;
        ok = lane >= 0 && lane < object->type.size && set == first_set;
        out->lanes[i] = static_cast<uint8_t>(lane);
    }
    if (!ok) {
        const std::string right = foreign_swizzle(text, object->type.size);
        const std::string_view set =
            first_set == 2 && lane_of(text[0], &first_set) >= 0 ? "rgba" : "xyzw";
        const bool function = find_intrinsic(text) != nullptr || !names_.overloads(text).empty() ||
                              !renamed_function(text).empty();
        if (right.empty() && function) return unknown_.method(expr, expr, object->type);
        diag::Diagnostic& d =
            sink_->report(expr.text_span, diag::kBadSwizzle, text, type_name(object->type))
                .help(fmt::format("its components are `{}`",
                                  set.substr(0, static_cast<size_t>(object->type.size))));
        if (!right.empty()) d.replace(expr.text_span, right);
        return poison(expr.span);
    }
    out->type.size = static_cast<int>(text.size());
    out->args.push_back(std::move(object));
    return out;
}

/// `_m01` counts rows and columns from 0, `_12` from 1; up to four of them make a vector.
ExprPtr Parts::matrix_swizzle(const ast::Expr& expr, ExprPtr object) const {
    const Type matrix = object->type;
    ExprPtr out = make(ExprKind::kSwizzle, {matrix.base, 0}, expr.span);
    const bool zero_based = expr.text.substr(0, 2) == "_m";
    const std::string_view mark = zero_based ? "_m" : "_";
    const size_t step = mark.size() + 2;
    bool ok = expr.text.size() % step == 0 && expr.text.size() <= 4 * step;
    for (size_t i = 0; ok && i < expr.text.size(); i += step) {
        const int row = expr.text[i + mark.size()] - (zero_based ? '0' : '1');
        const int column = expr.text[i + mark.size() + 1] - (zero_based ? '0' : '1');
        ok = expr.text.substr(i, mark.size()) == mark && row >= 0 && row < matrix.rows &&
             column >= 0 && column < matrix.size;
        if (!ok) break;
        out->lanes[static_cast<size_t>(out->type.size++)] =
            static_cast<uint8_t>(row * matrix.size + column);
    }
    if (!ok) {
        sink_->report(expr.text_span, diag::kBadSwizzle, expr.text, type_name(matrix))
            .help("write `[row][column]`, `._m01` counted from 0, or `._12` counted from 1");
        return poison(expr.span);
    }
    out->args.push_back(std::move(object));
    return out;
}

}  // namespace openfab::check

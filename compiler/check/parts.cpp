// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Components of vectors and matrices: `v.xyz`, `m._m01`.
#include <fmt/format.h>

#include <string>

#include "compiler/check/expression_checker.h"
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

ExprPtr ExpressionChecker::swizzle(const ast::Expr& expr, ExprPtr object) {
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
        const bool function = find_intrinsic(text) != nullptr || !overloads(text).empty() ||
                              !renamed_function(text).empty();
        if (right.empty() && function) return unknown_method(expr, expr, object->type);
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
ExprPtr ExpressionChecker::matrix_swizzle(const ast::Expr& expr, ExprPtr object) {
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

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Colours: defaults of uniforms that an annotation calls a colour, and `float3(…)` or `float4(…)` of numbers from 0 to 1
// in the default of a name that does. Editors show and take sRGB; OpenFL's colours are linear, as textures give them.

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <optional>

#include "base/color.h"
#include "base/text.h"
#include "compiler/server/answers.h"

namespace openfab::server {

namespace {

bool says_color(std::string_view text) {
    const std::string low = lower_ascii(std::string(text));
    return low.find("color") != std::string::npos || low.find("colour") != std::string::npos;
}

/// The viewer's rule (tools/viewer/page/live.js) for uniforms; other names must say it themselves.
bool is_color(const ast::Variable& v) {
    if (says_color(v.name)) return true;
    return std::any_of(v.annotations.begin(), v.annotations.end(), [](const ast::Annotation& a) {
        return says_color(a.name) || (a.value != nullptr && says_color(a.value->text));
    });
}

std::optional<double> number(const ast::Expr& e) {
    if (e.kind == ast::ExprKind::kFloatLiteral) return std::bit_cast<float>(e.bits);
    if (e.kind == ast::ExprKind::kIntLiteral) return static_cast<double>(e.bits);
    return std::nullopt;
}

/// Returns the components of `float3(0.5, 0, 1)`; nothing if it is no colour.
std::vector<double> components(const ast::Expr& e) {
    std::vector<double> out;
    const bool call = e.kind == ast::ExprKind::kCall && !e.args.empty() &&
                      e.args[0]->kind == ast::ExprKind::kName;
    if (!call || (e.args[0]->text != "float3" && e.args[0]->text != "float4")) return out;
    for (size_t i = 1; i < e.args.size(); ++i) {
        const std::optional<double> value = number(*e.args[i]);
        if (!value || *value < 0 || *value > 1) return {};
        out.push_back(*value);
    }
    const size_t wanted = e.args[0]->text == "float3" ? 3 : 4;
    return out.size() == wanted ? out : std::vector<double>();
}

void write_color(const Query& query, const ast::Variable& v, JsonText* out) {
    if (v.init == nullptr || !is_color(v)) return;
    const std::vector<double> c = components(*v.init);
    if (c.empty()) return;
    out->begin_object().key("range");
    query.write_range(out, v.init->span.begin, v.init->span.end);
    out->key("color").begin_object();
    out->member("red", linear_to_srgb(c[0]))
        .member("green", linear_to_srgb(c[1]))
        .member("blue", linear_to_srgb(c[2]));
    out->member("alpha", c.size() > 3 ? c[3] : 1.0).end_object().end_object();
}

void write_statement(const Query& query, const ast::Stmt& stmt, JsonText* out) {
    for (const ast::Variable& v : stmt.variables)
        write_color(query, v, out);
    if (stmt.init != nullptr) write_statement(query, *stmt.init, out);
    for (const ast::StmtPtr& child : stmt.body)
        write_statement(query, *child, out);
}

void write_scope(const Query& query, const ast::Scope& scope, JsonText* out) {
    for (const ast::Variable& v : scope.constants)
        write_color(query, v, out);
    for (const ast::Function& f : scope.functions) {
        if (f.body != nullptr) write_statement(query, *f.body, out);
    }
}

/// Four digits, without zeros at the end.
std::string digits(double value) {
    std::string out = fmt::format("{:.4f}", std::clamp(value, 0.0, 1.0));
    while (out.back() == '0')
        out.pop_back();
    if (out.back() == '.') out.pop_back();
    return out;
}

}  // namespace

void colors(const Query& query, JsonText* out) {
    out->begin_array();
    write_scope(query, query.analysis->tree().scope, out);
    for (const ast::Fablet& fablet : query.analysis->tree().fablets) {
        for (const ast::Variable& v : fablet.uniforms)
            write_color(query, v, out);
        write_scope(query, fablet.scope, out);
        for (const ast::Stage& stage : fablet.stages) {
            if (stage.body != nullptr) write_statement(query, *stage.body, out);
        }
    }
    out->end_array();
}

void color_presentations(const Query& query, double red, double green, double blue, uint32_t begin,
                         uint32_t end, JsonText* out) {
    const std::string_view old =
        std::string_view(query.document->text.text()).substr(begin, end - begin);
    std::string label = fmt::format("{}, {}, {}", digits(srgb_to_linear(red)),
                                    digits(srgb_to_linear(green)), digits(srgb_to_linear(blue)));
    if (old.starts_with("float4")) {
        // Whatever the fourth is, it stays.
        const size_t last = old.rfind(',');
        label = fmt::format("float4({}, {}", label, old.substr(std::min(last + 2, old.size())));
    } else {
        label = fmt::format("float3({})", label);
    }
    out->begin_array()
        .begin_object()
        .member("label", label)
        .key("textEdit")
        .begin_object()
        .key("range");
    query.write_range(out, begin, end);
    out->member("newText", label).end_object().end_object().end_array();
}

}  // namespace openfab::server

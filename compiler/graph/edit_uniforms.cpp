// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "compiler/graph/editor.h"

namespace openfab::graph {

namespace {

/// A type that a uniform may have, of what is in a port: `int` of `0` in a port for floats is a `float`.
std::string uniform_type(const Port& port) {
    const check::Type wanted = check::find_type(port.wants);
    if (wanted.is_arithmetic()) return port.wants;
    return port.type == "int" && port.wants != "int" ? "float" : port.type;
}

}  // namespace

Result<const Uniform*> Editor::uniform() const {
    if (action_.uniform < 0 || static_cast<size_t>(action_.uniform) >= graph_.uniforms.size())
        return user_error("there is no such uniform");
    return &graph_.uniforms[static_cast<size_t>(action_.uniform)];
}

Result<void> Editor::set_default() {
    const Result<const Uniform*> of = uniform();
    if (!of) return of.error();
    if (const std::string why = why_no_expression(action_.text); !why.empty())
        return user_error(why);
    if ((*of)->init.file != 0) {
        rewrite_.replace((*of)->init, action_.text);
        return {};
    }
    // Behind the name and its extents.
    const std::vector<syntax::Token>& tokens = analysis_.tokens();
    size_t at = analysis_.token_at((*of)->declared.begin);
    while (at + 1 < tokens.size() && tokens[at + 1].is("[") && !tokens[at + 2].is("["))
        at = analysis_.matching(at + 1);
    rewrite_.insert(tokens[at].span.end, " = " + action_.text);
    return {};
}

Result<void> Editor::declare_uniform(int fablet, const std::string& text) {
    const std::vector<syntax::Token>& tokens = analysis_.tokens();
    if (fablet < 0 || static_cast<size_t>(fablet) >= analysis_.tree().fablets.size())
        return user_error("uniforms belong to a fablet, and this function to none");
    const ast::Fablet& of = analysis_.tree().fablets[static_cast<size_t>(fablet)];
    size_t brace = analysis_.token_at(of.span.begin);
    while (brace + 1 < tokens.size() && !tokens[brace].is("{"))
        ++brace;
    const size_t end = analysis_.matching(brace);
    for (size_t i = brace; i + 2 < end; ++i) {
        const bool block =
            tokens[i].is("@") && tokens[i + 1].text == "uniform" && tokens[i + 2].is("{");
        if (!block) continue;
        // Behind the last, with what stands behind that on its line.
        const size_t last = analysis_.matching(i + 2) - 1;
        const bool empty = last == i + 2;
        const std::string_view all = analysis_.sources().text(server::Analysis::kDocument);
        uint32_t at = tokens[last].span.end;
        const size_t comment = all.find_first_not_of(" \t", at);
        if (!empty && comment != std::string_view::npos && all.substr(comment, 2) == "//")
            at = static_cast<uint32_t>(std::min(all.find('\n', comment), all.size()));
        rewrite_.insert(at, "\n" + text + "\n");
        return {};
    }
    rewrite_.insert(tokens[brace].span.end, "\n@uniform {\n" + text + "\n}\n\n");
    return {};
}

Result<void> Editor::expose() {
    const Result<const Port*> port = find_port();
    if (!port) return port.error();
    if (!(*port)->is_plain)
        return user_error("only a value that stands in an input can become a uniform");
    const std::string type = uniform_type(**port);
    if (!check::find_type(type).is_numeric())
        return user_error(fmt::format("`{}` cannot become a uniform", source((*port)->span)));
    std::string base = action_.text;
    if (base.empty()) {
        const Node& node = **find_node(action_.node);
        const bool named = node.is_root && !node.outputs.empty() && node.kind == NodeKind::kValue;
        base = (*port)->label.size() > 1 ? (*port)->label
               : named                   ? node.outputs[0].name + "_value"
                                         : "amount";
    }
    if (!is_name(base)) return user_error(fmt::format("`{}` is not a name", base));
    const std::string name = rewrite_.fresh_name(base);
    const std::string value = source((*port)->span);
    put(**find_node(action_.node), **port, name);
    return declare_uniform(tab_->fablet_index, fmt::format("{} {} = {};", type, name, value));
}

Result<void> Editor::add_uniform() {
    const check::Type type = check::find_type(action_.type);
    if (type.is_error() || type.is(check::Base::kComposition) || type.is_attributes())
        return user_error(fmt::format("`{}` is not the type of a uniform", action_.type));
    const std::string base = action_.text.empty() ? "value" : action_.text;
    if (!is_name(base)) return user_error(fmt::format("`{}` is not a name", base));
    const std::string zero = zero_of(action_.type);
    const std::string name = rewrite_.fresh_name(base);
    return declare_uniform(action_.fablet,
                           zero.empty() ? fmt::format("{} {};", action_.type, name)
                                        : fmt::format("{} {} = {};", action_.type, name, zero));
}

Result<void> Editor::delete_uniform() {
    const Result<const Uniform*> of = uniform();
    if (!of) return of.error();
    if ((*of)->uses > 0) {
        return user_error(fmt::format("`{}` is used {} times", (*of)->name, (*of)->uses),
                          "disconnect its wires first");
    }
    // Between commas, or a declaration of its own.
    const std::vector<syntax::Token>& tokens = analysis_.tokens();
    const size_t name = analysis_.token_at((*of)->declared.begin);
    size_t end = name + 1;
    while (end + 1 < tokens.size() && !tokens[end].is(",") && !tokens[end].is(";") &&
           !tokens[end].is("}"))
        end = tokens[end].is("(") || tokens[end].is("[") || tokens[end].is("{")
                  ? analysis_.matching(end) + 1
                  : end + 1;
    const bool first = !tokens[name - 1].is(",");
    const bool last = tokens[end].is(";");
    source::Span gone = tokens[name].span;
    if (first && last) {
        gone.begin = tokens[name - 1].span.begin;
        gone.end = tokens[end].span.end;
    } else if (first) {
        gone.end = tokens[end].span.end;
    } else {
        gone.begin = tokens[name - 1].span.begin;
        gone.end = tokens[end - 1].span.end;
    }
    rewrite_.remove(gone);
    return {};
}

Result<void> Editor::rename_uniform() {
    const Result<const Uniform*> of = uniform();
    if (!of) return of.error();
    return rename((*of)->declared.begin, action_.text);
}

}  // namespace openfab::graph

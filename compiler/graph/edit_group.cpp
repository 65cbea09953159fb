// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "compiler/graph/editor.h"

namespace openfab::graph {

namespace {

/// What a function made of nodes takes: a value from outside, under a name.
struct Taken {
    Source value;
    std::string name, type, argument;
};

}  // namespace

/// The nodes become a function of the fablet: variables among them become its statements, wires from outside its
/// parameters, and the one value that is used outside its result.
Result<void> Editor::group() {
    std::set<int> chosen;
    for (const int node : action_.nodes) {
        const Result<const Node*> found = find_node(node);
        if (!found) return found.error();
        // An input stays where it is; a wire to it becomes a parameter, or it is a uniform.
        if ((*found)->kind == NodeKind::kInput) continue;
        if ((*found)->kind != NodeKind::kCall && (*found)->kind != NodeKind::kOperator &&
            (*found)->kind != NodeKind::kValue)
            return user_error(fmt::format("`{}` changes a variable: it cannot become a function",
                                          (*found)->title));
        chosen.insert(node);
    }
    if (chosen.empty()) return user_error("nothing is chosen that computes something");
    if (!is_name(action_.text)) return user_error(fmt::format("`{}` is not a name", action_.text));
    // The one that is used outside, or by nobody.
    int result = -1;
    for (const int node : chosen) {
        bool inside = false;
        bool used_outside = false;
        for (size_t other = 0; other < tab_->nodes.size(); ++other) {
            const bool in = chosen.contains(static_cast<int>(other));
            for (const Port& port : tab_->nodes[other].ports) {
                if (port.from.node != node) continue;
                inside = inside || in;
                used_outside = used_outside || !in;
            }
        }
        const bool outside = used_outside || !inside;
        if (!outside) continue;
        if (result >= 0)
            return user_error("the nodes give several values; a function has one result",
                              "choose fewer, or what joins them, too");
        result = node;
    }
    if (result < 0) return user_error("the nodes give no value");
    const Node& last = tab_->nodes[static_cast<size_t>(result)];
    if (last.outputs.empty() || !can_be_declared(last.outputs[0].type))
        return user_error("no function gives what these nodes do");
    // The text of an expression inside of the function: wires from outside are parameters.
    std::vector<Taken> taken;
    std::set<std::string> names;
    std::string trouble;
    Rewrite inner(analysis_);
    const auto parameter = [&](const Port& port) -> std::string {
        for (const Taken& one : taken) {
            if (one.value == port.from) return one.name;
        }
        const Node& from = tab_->nodes[static_cast<size_t>(port.from.node)];
        const Output& output = from.outputs[static_cast<size_t>(port.from.output)];
        Taken one{port.from, output.name, output.type, source(port.object)};
        const size_t dot = one.name.rfind('.');
        if (dot != std::string::npos) one.name = one.name.substr(dot + 1);
        if (one.name.empty()) one.name = name_for(from);
        while (!names.insert(one.name).second || !is_name(one.name))
            one.name += "_in";
        const bool handle = one.type.find("Texture") != std::string::npos || one.type == "Object" ||
                            one.type == "Spline" || one.type == "ColorRamp";
        if (one.type.empty() || one.type.find('[') != std::string::npos ||
            (handle && from.role != "uniform"))
            trouble = fmt::format("`{}` cannot be handed to a function",
                                  output.name.empty() ? from.title : output.name);
        taken.push_back(one);
        return one.name;
    };
    std::set<int> statements;
    for (const int node : chosen) {
        const Node& one = tab_->nodes[static_cast<size_t>(node)];
        for (const Port& port : one.ports) {
            if (!port.from.exists() || port.span.file != server::Analysis::kDocument) continue;
            const Node& from = tab_->nodes[static_cast<size_t>(port.from.node)];
            if (chosen.contains(port.from.node)) continue;
            const bool global =
                from.kind == NodeKind::kInput &&
                (from.role == "uniform" || from.role == "constant" || from.role == "name");
            if (global) continue;
            const std::string name = parameter(port);
            inner.replace(port.object, name);
        }
        if (one.is_root && node != result) {
            const Statement& statement = tab_->statements[static_cast<size_t>(one.statement)];
            if (!statement.is_simple)
                return user_error(
                    "a statement that declares several variables cannot be moved into a function");
            statements.insert(one.statement);
        }
    }
    if (!trouble.empty()) return user_error(trouble);
    // A nested expression must be whole: what is inside of a chosen one and not chosen is a parameter, which stands
    // in its argument. Variables that others use stay, too.
    std::string body;
    for (const int statement : statements) {
        const Statement& one = tab_->statements[static_cast<size_t>(statement)];
        const std::string text = inner.text({server::Analysis::kDocument, one.lead, one.tail});
        body += text + "\n";
    }
    const std::string name = rewrite_.fresh_name(action_.text);
    if (name != action_.text)
        return user_error(fmt::format("`{}` is the name of something else here", action_.text));
    std::string parameters;
    std::string arguments;
    for (const Taken& one : taken) {
        parameters += fmt::format("{}{} {}", parameters.empty() ? "" : ", ", one.type, one.name);
        arguments += (arguments.empty() ? "" : ", ") + one.argument;
    }
    std::string value = inner.expression(last.span);
    if (last.kind == NodeKind::kValue && !last.ports.empty())
        value = inner.expression(last.ports[0].span);
    const source::Span& span = last.span;
    const std::string function = fmt::format("{} {}({})\n{{\n{}return {};\n}}\n\n",
                                             last.outputs[0].type, name, parameters, body, value);
    rewrite_.replace(span, fmt::format("{}({})", name, arguments));
    for (const int statement : statements) {
        const Statement& one = tab_->statements[static_cast<size_t>(statement)];
        rewrite_.remove_line(one.lead, one.tail);
    }
    // Before the stage or function, above its comments.
    size_t token = analysis_.token_at(tab_->span.begin);
    while (token > 0 && !analysis_.tokens()[token - 1].is("}") &&
           !analysis_.tokens()[token - 1].is(";") && !analysis_.tokens()[token - 1].is("{"))
        --token;
    const std::string_view all = analysis_.sources().text(server::Analysis::kDocument);
    uint32_t at = token == 0 ? 0 : analysis_.tokens()[token - 1].span.end;
    while (at < all.size() && (all[at] == ' ' || all[at] == '\t'))
        ++at;
    if (all.substr(at, 2) == "//")
        at = static_cast<uint32_t>(std::min(all.find('\n', at), all.size()));
    rewrite_.insert(at, "\n" + function);
    return {};
}

}  // namespace openfab::graph

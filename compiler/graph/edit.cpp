// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/graph/edit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compiler/graph/editor.h"

namespace openfab::graph {

Result<Action> action_of(const JsonValue& json) {
    Action out;
    std::string wrong;
    const auto text = [&](const char* name, std::string* to) {
        const JsonValue* found = member_of(json, name);
        if (found == nullptr) return;
        if (!found->is(JsonValue::Kind::kString)) wrong = name;
        *to = found->text;
    };
    const auto whole = [&](const JsonValue& value, const char* name, int* to) {
        const bool fits = value.is(JsonValue::Kind::kNumber) && value.number >= -1 &&
                          value.number <= 1e6 && value.number == std::floor(value.number);
        if (!fits) wrong = name;
        if (fits) *to = static_cast<int>(value.number);
    };
    if (!json.is(JsonValue::Kind::kObject)) return user_error("an action is an object");
    text("do", &out.what);
    text("text", &out.text);
    text("signature", &out.signature);
    text("module", &out.module);
    text("type", &out.type);
    const std::pair<const char*, int*> numbers[] = {
        {"tab", &out.tab},         {"node", &out.node},     {"port", &out.port},
        {"from", &out.from},       {"output", &out.output}, {"before", &out.before},
        {"uniform", &out.uniform}, {"fablet", &out.fablet}};
    for (const auto& [name, to] : numbers) {
        const JsonValue* found = member_of(json, name);
        if (found != nullptr) whole(*found, name, to);
    }
    if (const JsonValue* nodes = member_of(json, "nodes"); nodes != nullptr) {
        for (const JsonValue& one : nodes->items) {
            int node = -1;
            whole(one, "nodes", &node);
            out.nodes.push_back(node);
        }
    }
    if (!wrong.empty()) return user_error(fmt::format("`{}` of an action has a wrong type", wrong));
    return out;
}

Result<const Tab*> Editor::find_tab() const {
    if (action_.tab < 0 || static_cast<size_t>(action_.tab) >= graph_.tabs.size())
        return user_error("there is no such stage or function");
    return &graph_.tabs[static_cast<size_t>(action_.tab)];
}

Result<const Node*> Editor::find_node(int node) const {
    if (tab_ == nullptr || node < 0 || static_cast<size_t>(node) >= tab_->nodes.size())
        return user_error("there is no such node");
    return &tab_->nodes[static_cast<size_t>(node)];
}

Result<const Port*> Editor::find_port() const {
    const Result<const Node*> node = find_node(action_.node);
    if (!node) return node.error();
    if (action_.port < 0 || static_cast<size_t>(action_.port) >= (*node)->ports.size())
        return user_error("there is no such input");
    const Port* port = &(*node)->ports[static_cast<size_t>(action_.port)];
    if (port->span.file != server::Analysis::kDocument)
        return user_error("this input is what the statement reads: change it in the text");
    return port;
}

Result<void> Editor::apply() {
    struct Row {
        const char* what;
        bool in_tab;
        Result<void> (Editor::*apply)();
    };
    constexpr Row kRows[] = {
        {"set", true, &Editor::set},
        {"connect", true, &Editor::connect},
        {"disconnect", true, &Editor::disconnect},
        {"insert", true, &Editor::insert},
        {"add", true, &Editor::add},
        {"paste", true, &Editor::paste},
        {"delete", true, &Editor::remove},
        {"name", true, &Editor::name},
        {"group", true, &Editor::group},
        {"expose", true, &Editor::expose},
        {"default", false, &Editor::set_default},
        {"add_uniform", false, &Editor::add_uniform},
        {"delete_uniform", false, &Editor::delete_uniform},
        {"rename_uniform", false, &Editor::rename_uniform},
    };
    for (const Row& row : kRows) {
        if (action_.what != row.what) continue;
        if (row.in_tab) {
            const Result<const Tab*> tab = find_tab();
            if (!tab) return tab.error();
            tab_ = *tab;
        }
        return (this->*row.apply)();
    }
    return user_error(fmt::format("there is no action `{}`", action_.what));
}

Result<std::string> edited(const server::Analysis& analysis, const Graph& graph,
                           const Action& action) {
    if (!graph.is_whole)
        return user_error("the text has errors that hide parts of the graph; mend them first");
    Editor editor(analysis, graph, action);
    if (Result<void> applied = editor.apply(); !applied) return applied.error();
    return editor.made();
}

Result<void> still_fine(const server::Analysis& before, const server::Analysis& after) {
    const std::vector<diag::Diagnostic> had = before.diagnostics();
    const std::vector<diag::Diagnostic> has = after.diagnostics();
    const auto errors = [](const std::vector<diag::Diagnostic>& list) {
        return std::count_if(list.begin(), list.end(), [](const diag::Diagnostic& one) {
            return one.severity == diag::Severity::kError;
        });
    };
    if (errors(has) <= errors(had)) return {};
    for (const diag::Diagnostic& one : has) {
        const bool is_new = std::none_of(had.begin(), had.end(), [&](const diag::Diagnostic& old) {
            return old.message == one.message;
        });
        if (one.severity != diag::Severity::kError || !is_new) continue;
        return user_error(one.message, one.helps.empty() ? "" : one.helps.front());
    }
    return user_error("this would be an error");
}

bool can_be_declared(const std::string& type) {
    return !type.empty() && type != "void" && type.find('[') == std::string::npos &&
           type.find("Attributes") == std::string::npos &&
           type.find("Texture") == std::string::npos && type != "Object" && type != "Spline" &&
           type != "ColorRamp";
}

std::string name_for(const std::string& title) {
    struct Row {
        const char* title;
        const char* name;
    };
    constexpr Row kRows[] = {
        {"+", "sum"},   {"-", "difference"}, {"*", "product"},  {"/", "ratio"},
        {"%", "rest"},  {"? :", "choice"},   {"<", "less"},     {">", "more"},
        {"<=", "less"}, {">=", "more"},      {"==", "same"},    {"!=", "other"},
        {"&&", "both"}, {"||", "either"},    {"!", "opposite"}, {"[ ]", "item"}};
    for (const Row& row : kRows) {
        if (title == row.title) return row.name;
    }
    if (title.starts_with(".")) return "sample";
    if (!check::find_type(title).is_error()) return "value";
    const size_t last = title.rfind('_');
    constexpr size_t kShort = 3;
    const std::string word = last == std::string::npos || title.size() - last - 1 < kShort
                                 ? title
                                 : title.substr(last + 1);
    if (!is_name(word)) return "value";
    // A variable of the function's own name would hide it.
    return word == title ? word + "_value" : word;
}

std::string name_for(const Node& node) {
    return node.title == "-" && node.ports.size() == 1 ? "negative" : name_for(node.title);
}

}  // namespace openfab::graph

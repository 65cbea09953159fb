// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "compiler/check/signatures.h"
#include "compiler/graph/tab_builder.h"

namespace openfab::graph {

namespace {

using ast::ExprKind;

bool is_literal(const ast::Expr& expr) {
    return expr.kind == ExprKind::kBoolLiteral || expr.kind == ExprKind::kIntLiteral ||
           expr.kind == ExprKind::kUintLiteral || expr.kind == ExprKind::kFloatLiteral ||
           expr.kind == ExprKind::kStringLiteral;
}

/// A number, a list of numbers: what stands in a port instead of a node.
bool is_plain(const ast::Expr& expr) {
    const auto all = [&](size_t first) {
        return std::all_of(expr.args.begin() + static_cast<ptrdiff_t>(first), expr.args.end(),
                           [](const ast::ExprPtr& arg) { return is_plain(*arg); });
    };
    if (is_literal(expr)) return true;
    if (expr.kind == ExprKind::kUnary) return is_literal(*expr.args[0]) && expr.text != "~";
    if (expr.kind == ExprKind::kInitList) return all(0);
    if (expr.kind == ExprKind::kCast) return expr.args.size() == 1 && is_plain(*expr.args[0]);
    const bool constructs = expr.kind == ExprKind::kCall && expr.args[0]->kind == ExprKind::kName &&
                            check::find_type(expr.args[0]->text).is_arithmetic();
    return constructs && expr.args.size() > 1 && all(1);
}

/// Returns the last word of "floatN a", and the ones before it.
std::pair<std::string, std::string> name_and_type(std::string_view parameter) {
    const size_t space = parameter.rfind(' ');
    if (space == std::string_view::npos) return {std::string(parameter), ""};
    return {std::string(parameter.substr(space + 1)), std::string(parameter.substr(0, space))};
}

/// Returns the form of a built-in function with so many parameters, the most like these types.
const check::Signature* form_of(const std::vector<check::Signature>& forms,
                                const std::vector<std::string>& types) {
    const check::Signature* best = nullptr;
    int most = -1;
    for (const check::Signature& one : forms) {
        const std::vector<std::string_view> parameters = check::parameters_of(one.form);
        if (parameters.size() != types.size()) continue;
        int fits = 0;
        for (size_t i = 0; i < types.size(); ++i)
            fits += name_and_type(parameters[i]).second == types[i] ? 1 : 0;
        if (fits > most) best = &one;
        most = std::max(most, fits);
    }
    return best;
}

}  // namespace

Known::Known(const server::Analysis& analysis) : analysis_(analysis) {
    for (const check::Use& use : analysis.names()) {
        if (use.span.file == server::Analysis::kDocument)
            uses_[{use.span.begin, use.span.end}] = &use;
    }
    for (const check::Uses::Typed& one : analysis.typed()) {
        if (one.span.file == server::Analysis::kDocument)
            types_[{one.span.begin, one.span.end}] = one.type;
    }
}

const check::Use* Known::use(const source::Span& at) const {
    const auto found = uses_.find({at.begin, at.end});
    return found == uses_.end() ? nullptr : found->second;
}

check::Type Known::type(const source::Span& at) const {
    const auto found = types_.find({at.begin, at.end});
    return found == types_.end() ? check::kErrorType : found->second;
}

std::string Known::type_name(const source::Span& at) const {
    const check::Type found = type(at);
    return found.is_error() ? "" : check::type_name(found);
}

int TabBuilder::add_node(NodeKind kind, const std::string& title, const source::Span& span) {
    Node node;
    node.kind = kind;
    node.title = title;
    node.span = span;
    node.statement = static_cast<int>(at_);
    tab_.nodes.push_back(std::move(node));
    return static_cast<int>(tab_.nodes.size()) - 1;
}

bool TabBuilder::is_attribute(const ast::Expr& member) const {
    return member.kind == ExprKind::kMember && member.args[0]->kind == ExprKind::kName &&
           known_.type(member.args[0]->span).is_attributes();
}

std::optional<uint32_t> TabBuilder::variable_of(const ast::Expr& expr) const {
    const ast::Expr* at = &expr;
    while (at->kind == ExprKind::kMember || at->kind == ExprKind::kIndex)
        at = at->args[0].get();
    const check::Use* use = at->kind == ExprKind::kName ? known_.use(at->span) : nullptr;
    if (use == nullptr || use->kind != check::UseKind::kSymbol ||
        use->declared.file != server::Analysis::kDocument)
        return std::nullopt;
    return use->declared.begin;
}

void TabBuilder::fill(Port* port, const ast::Expr& expr) {
    port->span = expr.span;
    port->type = known_.type_name(expr.span);
    if (is_plain(expr)) {
        port->is_plain = true;
        return;
    }
    const ast::Expr* inner = &expr;
    std::string suffix;
    while (inner->kind == ExprKind::kMember && !is_attribute(*inner)) {
        suffix.insert(0, "." + std::string(inner->text));
        inner = inner->args[0].get();
    }
    port->from = value_of(*inner);
    if (!port->from.exists()) return;
    port->object = inner->span;
    port->suffix = suffix;
}

void TabBuilder::add_port(int node, const std::string& label, const std::string& wants,
                          const ast::Expr& expr) {
    Port port;
    port.label = label;
    port.wants = wants;
    // Nodes that are added on the way may move this one.
    fill(&port, expr);
    tab_.nodes[static_cast<size_t>(node)].ports.push_back(std::move(port));
}

Source TabBuilder::input(const std::string& role, const std::string& title, const std::string& type,
                         const source::Span& declared, const std::string& help) {
    for (size_t i = 0; i < tab_.nodes.size(); ++i) {
        const Node& one = tab_.nodes[i];
        if (one.kind == NodeKind::kInput && one.title == title && one.declared == declared)
            return {static_cast<int>(i), 0};
    }
    const int made = add_node(NodeKind::kInput, title, declared);
    Node& node = tab_.nodes[static_cast<size_t>(made)];
    node.role = role;
    node.help = help;
    node.declared = declared;
    node.statement = -1;
    node.outputs.push_back({title, type});
    return {made, 0};
}

Source TabBuilder::name_value(const ast::Expr& name) {
    const check::Use* use = known_.use(name.span);
    if (use == nullptr || use->kind != check::UseKind::kSymbol) return {};
    const bool here = use->declared.file == server::Analysis::kDocument;
    if (here) {
        const auto held = held_.find(use->declared.begin);
        if (held != held_.end()) return held->second;
    }
    const char* role = "name";
    switch (use->symbol) {
        case check::SymbolKind::kUniform:
            role = "uniform";
            break;
        case check::SymbolKind::kConstant:
            role = "constant";
            break;
        case check::SymbolKind::kLocal:
            return {};  // of a statement that could not be made out
        case check::SymbolKind::kParameter:
            role = "parameter";
            break;
        case check::SymbolKind::kAttributes:
            role = "attribute";
            break;
        case check::SymbolKind::kVoid:
        case check::SymbolKind::kType:
            break;
        case check::SymbolKind::kSurfaceInput:
        case check::SymbolKind::kSurfaceOutput:
        case check::SymbolKind::kShapeOutput:
        case check::SymbolKind::kGrowParent:
        case check::SymbolKind::kNearest:
            role = "varying";
    }
    const std::string help =
        use->declared.file == 0 ? std::string() : server::describe(known_.analysis(), *use);
    return input(role, use->name, use->type.is_error() ? "" : check::type_name(use->type),
                 use->declared, help);
}

Source TabBuilder::value_of(const ast::Expr& expr) {
    if (expr.kind == ExprKind::kName) return name_value(expr);
    if (expr.kind == ExprKind::kBad) return {};
    if (is_attribute(expr)) {
        const check::Use* use = known_.use(expr.args[0]->span);
        return input("attribute", fmt::format("{}.{}", expr.args[0]->text, expr.text),
                     known_.type_name(expr.span), use == nullptr ? source::Span{} : use->declared,
                     "");
    }
    return node_of(expr);
}

Source TabBuilder::node_of(const ast::Expr& expr) {
    const int made = add_node(NodeKind::kOperator, std::string(expr.text), expr.span);
    tab_.nodes[static_cast<size_t>(made)].outputs.push_back({"", known_.type_name(expr.span)});
    switch (expr.kind) {
        case ExprKind::kCall:
            call_node(expr, made);
            break;
        case ExprKind::kConditional:
            tab_.nodes[static_cast<size_t>(made)].title = "? :";
            add_port(made, "if", "bool", *expr.args[0]);
            add_port(made, "then", "", *expr.args[1]);
            add_port(made, "else", "", *expr.args[2]);
            break;
        case ExprKind::kIndex:
            tab_.nodes[static_cast<size_t>(made)].title = "[ ]";
            add_port(made, "of", "", *expr.args[0]);
            add_port(made, "index", "int", *expr.args[1]);
            break;
        case ExprKind::kCast:
            tab_.nodes[static_cast<size_t>(made)].title = fmt::format("({})", expr.text);
            add_port(made, "x", "", *expr.args[0]);
            break;
        case ExprKind::kInitList:
            tab_.nodes[static_cast<size_t>(made)].title = "{ }";
            for (size_t i = 0; i < expr.args.size(); ++i)
                add_port(made, fmt::format("{}", i), "", *expr.args[i]);
            break;
        case ExprKind::kUnary:
            add_port(made, "x", "", *expr.args[0]);
            break;
        case ExprKind::kPrefix:
        case ExprKind::kPostfix:
        case ExprKind::kBinary:
        case ExprKind::kAssign:
        case ExprKind::kComma:
        case ExprKind::kMember:
            for (size_t i = 0; i < expr.args.size(); ++i)
                add_port(made, i == 0 ? "a" : "b", "", *expr.args[i]);
            break;
        case ExprKind::kBad:
        case ExprKind::kName:
        case ExprKind::kBoolLiteral:
        case ExprKind::kIntLiteral:
        case ExprKind::kUintLiteral:
        case ExprKind::kFloatLiteral:
        case ExprKind::kStringLiteral:
            break;
    }
    return {made, 0};
}

void TabBuilder::method_node(const ast::Expr& call, int node) {
    const ast::Expr& callee = *call.args[0];
    std::vector<std::string> types;
    for (size_t i = 1; i < call.args.size(); ++i)
        types.push_back(known_.type_name(call.args[i]->span));
    const std::vector<check::Signature> forms = check::signatures_of(callee.text);
    const check::Signature* form = form_of(forms, types);
    const std::vector<std::string_view> parameters =
        form == nullptr ? std::vector<std::string_view>() : check::parameters_of(form->form);
    if (form != nullptr) tab_.nodes[static_cast<size_t>(node)].help = form->text;
    add_port(node, "of", known_.type_name(callee.args[0]->span), *callee.args[0]);
    for (size_t i = 1; i < call.args.size(); ++i) {
        const auto [label, wants] = i - 1 < parameters.size()
                                        ? name_and_type(parameters[i - 1])
                                        : std::pair(std::string("x"), std::string());
        add_port(node, label, wants, *call.args[i]);
    }
}

void TabBuilder::call_node(const ast::Expr& call, int node) {
    const ast::Expr& callee = *call.args[0];
    Node& made = tab_.nodes[static_cast<size_t>(node)];
    made.kind = NodeKind::kCall;
    made.title = std::string(callee.text);
    if (callee.kind == ExprKind::kMember) {
        made.title.insert(0, ".");
        return method_node(call, node);
    }
    const check::Use* use = known_.use(callee.span);
    std::vector<std::pair<std::string, std::string>> parameters;
    if (use != nullptr && use->kind == check::UseKind::kFunction && use->function != nullptr) {
        made.declared = use->declared;
        made.help = known_.analysis().comment_above(use->declared);
        for (const auto& p : use->function->parameters)
            parameters.emplace_back(p->name, check::type_name(p->type));
    } else if (use != nullptr && use->type.record != nullptr) {
        for (const check::StructMember& m : use->type.record->members)
            parameters.emplace_back(m.name, check::type_name(m.type));
    } else if (check::find_type(callee.text).is_arithmetic()) {
        const char* const names[] = {"x", "y", "z", "w"};
        for (size_t i = 1; i < call.args.size() && call.args.size() <= 5; ++i)
            parameters.emplace_back(names[i - 1], "");
    } else {
        std::vector<std::string> types;
        for (size_t i = 1; i < call.args.size(); ++i)
            types.push_back(known_.type_name(call.args[i]->span));
        const std::vector<check::Signature> forms = check::signatures_of(callee.text);
        if (const check::Signature* form = form_of(forms, types); form != nullptr) {
            made.help = form->text;
            for (std::string_view p : check::parameters_of(form->form))
                parameters.push_back(name_and_type(p));
        }
    }
    for (size_t i = 1; i < call.args.size(); ++i) {
        const auto [label, wants] = i - 1 < parameters.size()
                                        ? parameters[i - 1]
                                        : std::pair(fmt::format("{}", i), std::string());
        add_port(node, label, wants, *call.args[i]);
    }
}

}  // namespace openfab::graph

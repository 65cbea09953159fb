// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "compiler/graph/statements.h"
#include "compiler/graph/tab_builder.h"

namespace openfab::graph {

namespace {

using ast::ExprKind;
using ast::StmtKind;

/// The first line of a statement's text, for a title.
std::string first_line(std::string_view text) {
    constexpr size_t kLongest = 48;
    std::string line(text.substr(0, text.find('\n')));
    while (!line.empty() && (line.back() == ' ' || line.back() == '{' || line.back() == '\r'))
        line.pop_back();
    if (line.size() <= kLongest) return line;
    size_t cut = kLongest;
    // Not within a code point.
    while (cut > 0 && (static_cast<unsigned char>(line[cut]) & 0xc0) == 0x80)
        --cut;
    return line.substr(0, cut) + " …";
}

}  // namespace

void TabBuilder::hold(uint32_t variable, const Source& value) {
    held_[variable] = value;
    tab_.nodes[static_cast<size_t>(value.node)]
        .outputs[static_cast<size_t>(value.output)]
        .variable = variable;
    now().writes.push_back(variable);
}

std::vector<uint32_t> TabBuilder::out_arguments(const ast::Expr& call) const {
    std::vector<uint32_t> out;
    if (call.kind != ExprKind::kCall || call.args[0]->kind != ExprKind::kName) return out;
    const check::Use* use = known_.use(call.args[0]->span);
    if (use == nullptr || use->function == nullptr) return out;
    const auto& parameters = use->function->parameters;
    for (size_t i = 1; i < call.args.size() && i <= parameters.size(); ++i) {
        if (!parameters[i - 1]->is_out) continue;
        if (const auto variable = variable_of(*call.args[i])) out.push_back(*variable);
    }
    return out;
}

bool TabBuilder::has_effects(const ast::Expr& expr) const {
    if (expr.kind == ExprKind::kAssign || expr.kind == ExprKind::kPrefix ||
        expr.kind == ExprKind::kPostfix || expr.kind == ExprKind::kComma ||
        expr.kind == ExprKind::kBad || !out_arguments(expr).empty())
        return true;
    return std::any_of(expr.args.begin(), expr.args.end(),
                       [&](const ast::ExprPtr& arg) { return has_effects(*arg); });
}

bool TabBuilder::is_drawn(const ast::Stmt& stmt) const {
    const auto pure = [&](const ast::Expr& expr) { return !has_effects(expr); };
    const auto pure_parts = [&](const ast::Expr& expr) {
        return std::all_of(expr.args.begin(), expr.args.end(),
                           [&](const ast::ExprPtr& arg) { return pure(*arg); });
    };
    switch (stmt.kind) {
        case StmtKind::kEmpty:
            return true;
        case StmtKind::kReturn:
            return stmt.expr == nullptr || pure(*stmt.expr);
        case StmtKind::kDeclaration:
            return stmt.record == nullptr &&
                   std::all_of(stmt.variables.begin(), stmt.variables.end(),
                               [&](const ast::Variable& v) {
                                   return v.init == nullptr || pure_parts(*v.init) || pure(*v.init);
                               });
        case StmtKind::kExpression: {
            if (stmt.expr == nullptr) return false;
            const ast::Expr& expr = *stmt.expr;
            if (expr.kind == ExprKind::kAssign)
                return variable_of(*expr.args[0]).has_value() && pure(*expr.args[0]) &&
                       pure(*expr.args[1]);
            if (expr.kind == ExprKind::kPrefix || expr.kind == ExprKind::kPostfix)
                return variable_of(*expr.args[0]).has_value() && pure(*expr.args[0]);
            return expr.kind == ExprKind::kCall && pure_parts(expr);
        }
        case StmtKind::kBad:
        case StmtKind::kBlock:
        case StmtKind::kIf:
        case StmtKind::kFor:
        case StmtKind::kWhile:
        case StmtKind::kDo:
        case StmtKind::kBreak:
        case StmtKind::kContinue:
        case StmtKind::kSwitch:
        case StmtKind::kCase:
            return false;
    }
    return false;
}

void TabBuilder::declaration(const ast::Stmt& stmt) {
    for (const ast::Variable& v : stmt.variables) {
        now().declares.push_back(v.span.begin);
        const check::Use* use = known_.use(v.span);
        const std::string type = use == nullptr || use->type.is_error()
                                     ? std::string(v.type.text)
                                     : check::type_name(use->type);
        names_[v.span.begin] = v.name;
        Source value;
        std::vector<uint32_t> outs;
        if (v.init != nullptr) {
            outs = out_arguments(*v.init);
            Port port;
            fill(&port, *v.init);
            // What this statement computes has the variable's name; a name for something else is a node of its own.
            const bool own =
                port.from.exists() && port.suffix.empty() && v.extents.empty() &&
                tab_.nodes[static_cast<size_t>(port.from.node)].span == v.init->span &&
                port.from.output == 0 &&
                tab_.nodes[static_cast<size_t>(port.from.node)].kind != NodeKind::kInput;
            if (own) {
                value = port.from;
            } else {
                port.label = "=";
                port.wants = type;
                value = {add_node(NodeKind::kValue, type, v.init->span), 0};
                Node& node = tab_.nodes[static_cast<size_t>(value.node)];
                node.ports.push_back(std::move(port));
                node.outputs.push_back({"", type});
            }
        } else {
            value = {add_node(NodeKind::kValue, type, v.span), 0};
            tab_.nodes[static_cast<size_t>(value.node)].outputs.push_back({"", type});
        }
        Node& node = tab_.nodes[static_cast<size_t>(value.node)];
        node.is_root = true;
        node.outputs[0] = {std::string(v.name), type};
        hold(v.span.begin, value);
        for (const uint32_t out : outs) {
            node.outputs.push_back({names_[out], ""});
            hold(out, {value.node, static_cast<int>(node.outputs.size()) - 1});
        }
    }
    now().is_simple = stmt.variables.size() == 1 && now().writes.size() == 1;
}

void TabBuilder::assignment(const ast::Expr& assign) {
    const uint32_t variable = *variable_of(*assign.args[0]);
    const bool whole = assign.args[0]->kind == ExprKind::kName;
    const std::string target = known_.text(assign.args[0]->span);
    Port before;  // what the variable was
    if (!(whole && assign.text == "=")) {
        before.label = names_[variable].empty() ? target : names_[variable];
        const auto held = held_.find(variable);
        if (held != held_.end()) before.from = held->second;
    }
    std::string title =
        assign.text == "=" ? target + " =" : target + " " + std::string(assign.text);
    const int node = add_node(NodeKind::kWrite, title, assign.span);
    tab_.nodes[static_cast<size_t>(node)].is_root = true;
    if (before.from.exists())
        tab_.nodes[static_cast<size_t>(node)].ports.push_back(std::move(before));
    if (assign.args.size() > 1)
        add_port(node, "=", known_.type_name(assign.args[0]->span), *assign.args[1]);
    if (names_[variable].empty()) {
        const ast::Expr* root = assign.args[0].get();
        while (root->kind != ExprKind::kName)
            root = root->args[0].get();
        names_[variable] = root->text;
    }
    const check::Use* use = nullptr;
    for (const ast::Expr* at = assign.args[0].get(); use == nullptr; at = at->args[0].get()) {
        if (at->kind == ExprKind::kName) {
            use = known_.use(at->span);
            break;
        }
    }
    tab_.nodes[static_cast<size_t>(node)].outputs.push_back(
        {names_[variable],
         use == nullptr || use->type.is_error() ? "" : check::type_name(use->type)});
    hold(variable, {node, 0});
}

void TabBuilder::expression(const ast::Stmt& stmt) {
    const ast::Expr& expr = *stmt.expr;
    if (expr.kind != ExprKind::kCall) return assignment(expr);
    // A method that changes what it is called on, and a call that gives values by its arguments.
    std::vector<uint32_t> changed = out_arguments(expr);
    const ast::Expr& callee = *expr.args[0];
    if (callee.kind == ExprKind::kMember &&
        known_.type(callee.args[0]->span).is(check::Base::kComposition)) {
        if (const auto variable = variable_of(*callee.args[0])) changed.push_back(*variable);
    }
    const int node = node_of(expr).node;
    Node& made = tab_.nodes[static_cast<size_t>(node)];
    made.kind = NodeKind::kWrite;
    made.is_root = true;
    made.outputs.clear();
    for (const uint32_t variable : changed) {
        const auto held = held_.find(variable);
        std::string type;
        if (held != held_.end()) {
            const Node& from = tab_.nodes[static_cast<size_t>(held->second.node)];
            type = from.outputs[static_cast<size_t>(held->second.output)].type;
        }
        made.outputs.push_back({names_[variable], type});
        hold(variable, {node, static_cast<int>(made.outputs.size()) - 1});
    }
}

void TabBuilder::result(const ast::Stmt& stmt) {
    const int node = add_node(NodeKind::kResult, "return", now().span);
    tab_.nodes[static_cast<size_t>(node)].is_root = true;
    if (stmt.expr != nullptr) add_port(node, "value", "", *stmt.expr);
    for (const uint32_t variable : out_variables_) {
        const auto held = held_.find(variable);
        if (held == held_.end()) continue;
        Port port;
        port.label = names_[variable];
        port.from = held->second;
        tab_.nodes[static_cast<size_t>(node)].ports.push_back(std::move(port));
    }
    now().returns = true;
}

void TabBuilder::collect(const ast::Expr& expr, std::set<uint32_t>* written) const {
    const auto take = [&](const ast::Expr& target) {
        if (const auto variable = variable_of(target)) written->insert(*variable);
    };
    if (expr.kind == ExprKind::kAssign || expr.kind == ExprKind::kPrefix ||
        expr.kind == ExprKind::kPostfix)
        take(*expr.args[0]);
    if (expr.kind == ExprKind::kCall && expr.args[0]->kind == ExprKind::kMember &&
        known_.type(expr.args[0]->args[0]->span).is(check::Base::kComposition))
        take(*expr.args[0]->args[0]);
    for (const uint32_t out : out_arguments(expr))
        written->insert(out);
    for (const ast::ExprPtr& arg : expr.args)
        collect(*arg, written);
}

void TabBuilder::collect(const ast::Stmt& stmt, std::set<uint32_t>* written) const {
    for (const ast::ExprPtr* part : {&stmt.expr, &stmt.step}) {
        if (*part != nullptr) collect(**part, written);
    }
    if (stmt.init != nullptr) collect(*stmt.init, written);
    for (const ast::Variable& v : stmt.variables) {
        if (v.init != nullptr) collect(*v.init, written);
    }
    for (const ast::StmtPtr& one : stmt.body)
        collect(*one, written);
}

bool TabBuilder::returns(const ast::Stmt& stmt) const {
    return stmt.kind == StmtKind::kReturn ||
           std::any_of(stmt.body.begin(), stmt.body.end(),
                       [&](const ast::StmtPtr& one) { return returns(*one); });
}

std::set<uint32_t> TabBuilder::variables_read(const source::Span& in) const {
    std::set<uint32_t> out;
    for (const check::Use& use : known_.analysis().names()) {
        const bool inside = use.span.file == server::Analysis::kDocument &&
                            use.span.begin >= in.begin && use.span.end <= in.end;
        const bool declared_here = use.declared.file == server::Analysis::kDocument;
        const bool within =
            declared_here && use.declared.begin >= in.begin && use.declared.begin < in.end;
        if (inside && declared_here && !within && use.kind == check::UseKind::kSymbol)
            out.insert(use.declared.begin);
    }
    return out;
}

void TabBuilder::opaque(const ast::Stmt& stmt) {
    const source::Span span = now().span;
    const int made = add_node(NodeKind::kOpaque, first_line(known_.text(span)), span);
    tab_.nodes[static_cast<size_t>(made)].is_root = true;
    std::set<uint32_t> written;
    collect(stmt, &written);
    now().returns = returns(stmt);
    const std::set<uint32_t> read = variables_read(span);
    for (const check::Use& use : known_.analysis().names()) {
        const bool inside = use.span.file == server::Analysis::kDocument &&
                            use.span.begin >= span.begin && use.span.end <= span.end;
        if (!inside || use.kind != check::UseKind::kSymbol ||
            use.symbol == check::SymbolKind::kType || use.declared.file == 0)
            continue;
        const bool here = use.declared.file == server::Analysis::kDocument;
        if (here && !read.contains(use.declared.begin)) continue;
        Source from;
        const auto held = here ? held_.find(use.declared.begin) : held_.end();
        if (held != held_.end()) {
            from = held->second;
        } else if (!use.type.is_attributes()) {
            ast::Expr name;
            name.kind = ExprKind::kName;
            name.span = use.span;
            from = name_value(name);
        }
        if (!from.exists()) continue;
        std::vector<Port>& ports = tab_.nodes[static_cast<size_t>(made)].ports;
        const bool known = std::any_of(ports.begin(), ports.end(),
                                       [&](const Port& port) { return port.label == use.name; });
        if (known) continue;
        Port port;
        port.label = use.name;
        port.type = use.type.is_error() ? "" : check::type_name(use.type);
        port.from = from;
        ports.push_back(std::move(port));
        // What an early return gives is as it was for who comes after.
        if (here && now().returns && use.type.is(check::Base::kComposition))
            written.insert(use.declared.begin);
        if (here && names_[use.declared.begin].empty()) names_[use.declared.begin] = use.name;
    }
    if (stmt.kind == StmtKind::kDeclaration) {
        for (const ast::Variable& v : stmt.variables) {
            now().declares.push_back(v.span.begin);
            names_[v.span.begin] = v.name;
            written.insert(v.span.begin);
        }
    }
    for (const uint32_t variable : written) {
        // Those of inner blocks are of no use outside.
        const bool inner =
            variable >= span.begin && variable < span.end && stmt.kind != StmtKind::kDeclaration;
        if (inner) continue;
        std::string type;
        for (const check::Use& use : known_.analysis().names()) {
            if (use.declared.file != server::Analysis::kDocument ||
                use.declared.begin != variable || use.kind != check::UseKind::kSymbol ||
                use.type.is_error())
                continue;
            type = check::type_name(use.type);
            if (names_[variable].empty()) names_[variable] = use.name;
            break;
        }
        Node& node = tab_.nodes[static_cast<size_t>(made)];
        node.outputs.push_back({names_[variable], type});
        hold(variable, {made, static_cast<int>(node.outputs.size()) - 1});
    }
}

void TabBuilder::statement(const ast::Stmt& stmt) {
    now().before = held_;
    if (!is_drawn(stmt)) {
        opaque(stmt);
    } else if (stmt.kind == StmtKind::kDeclaration) {
        declaration(stmt);
    } else if (stmt.kind == StmtKind::kExpression) {
        expression(stmt);
    } else if (stmt.kind == StmtKind::kReturn) {
        result(stmt);
    }
    for (const uint32_t variable : variables_read(now().span))
        now().reads.push_back(variable);
}

void TabBuilder::draw(const ast::Stmt& body) {
    const server::Analysis& analysis = known_.analysis();
    const size_t close = analysis.token_at(body.span.begin);
    const size_t open = analysis.matching(close);
    tab_.close = analysis.tokens()[close].span;
    tab_.open = analysis.tokens()[open].span;
    const std::vector<Extent> extents = statements_between(analysis, open, close);
    if (open >= close || extents.size() != body.body.size()) return;
    for (const Extent& extent : extents) {
        Statement made;
        made.span = {server::Analysis::kDocument, analysis.tokens()[extent.first].span.begin,
                     analysis.tokens()[extent.end - 1].span.end};
        made.lead = lead_of(analysis, extent.first);
        made.tail = tail_of(analysis, extent.end - 1);
        tab_.statements.push_back(std::move(made));
    }
    for (at_ = 0; at_ < body.body.size(); ++at_)
        statement(*body.body[at_]);
}

}  // namespace openfab::graph

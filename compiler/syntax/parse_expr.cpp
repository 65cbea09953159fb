// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iterator>

#include "compiler/syntax/operators.h"
#include "compiler/syntax/parser_state.h"

namespace openfab::syntax {

namespace {

struct Precedence {
    std::string_view op;
    int level;
};

// As in C and HLSL.
constexpr Precedence kBinary[] = {
    {"||", 1}, {"&&", 2}, {"|", 3}, {"^", 4},  {"&", 5},  {"==", 6},
    {"!=", 6}, {"<", 7},  {">", 7}, {"<=", 7}, {">=", 7}, {"<<", 8},
    {">>", 8}, {"+", 9},  {"-", 9}, {"*", 10}, {"/", 10}, {"%", 10},
};

constexpr std::string_view kAssignments[] = {
    "=", "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^=", "<<=", ">>="};

/// A bracket behind a number is no index.
bool is_literal(const ast::Expr& expr) {
    return expr.args.empty() && expr.kind != ast::ExprKind::kName &&
           expr.kind != ast::ExprKind::kInitList && expr.kind != ast::ExprKind::kBad;
}

}  // namespace

int precedence(const Token& token) {
    if (token.kind != TokenKind::kPunct) return 0;
    for (const Precedence& p : kBinary) {
        if (token.text == p.op) return p.level;
    }
    return 0;
}

bool is_assignment(const Token& token) {
    return token.kind == TokenKind::kPunct &&
           std::find(std::begin(kAssignments), std::end(kAssignments), token.text) !=
               std::end(kAssignments);
}

bool is_builtin_type_name(std::string_view name) {
    for (std::string_view base : {"bool", "int", "uint", "float"}) {
        if (name.substr(0, base.size()) != base) continue;
        const std::string_view rest = name.substr(base.size());
        const auto side = [](char c) { return c >= '1' && c <= '4'; };
        if (rest.empty() || (rest.size() == 1 && side(rest[0]))) return true;
        if (rest.size() == 3 && side(rest[0]) && rest[1] == 'x' && side(rest[2])) return true;
    }
    return false;
}

ast::ExprPtr Parser::node(ast::ExprKind kind, const Token& text, ast::ExprPtr a, ast::ExprPtr b,
                          ast::ExprPtr c) {
    auto out = std::make_unique<ast::Expr>();
    out->kind = kind;
    out->span = out->text_span = text.span;
    out->text = text.text;
    for (ast::ExprPtr* arg : {&a, &b, &c}) {
        if (*arg != nullptr) add_arg(out.get(), std::move(*arg));
    }
    return out;
}

void Parser::add_arg(ast::Expr* expr, ast::ExprPtr arg) {
    expr->span.begin = std::min(expr->span.begin, arg->span.begin);
    expr->span.end = std::max(expr->span.end, arg->span.end);
    expr->depth = std::max(expr->depth, arg->depth + 1);
    // A long chain of operators is parsed without recursion, but later steps recurse over it.
    if (expr->depth > kMaxDepth) give_up();
    expr->args.push_back(std::move(arg));
}

ast::ExprPtr Parser::literal(ast::ExprKind kind) {
    const Token& token = take();
    ast::ExprPtr out = node(kind, token);
    out->bits = token.bits;
    return out;
}

ast::ExprPtr Parser::parse_expression() {
    ast::ExprPtr left = parse_assignment();
    while (at(",")) {
        const Token& comma = take();
        left = node(ast::ExprKind::kComma, comma, std::move(left), parse_assignment());
    }
    return left;
}

ast::ExprPtr Parser::parse_assignment() {
    const Level level(this);
    if (!level.ok) return std::make_unique<ast::Expr>();
    ast::ExprPtr left = parse_conditional();
    if (!is_assignment(peek())) return left;
    const Token& op = take();
    return node(ast::ExprKind::kAssign, op, std::move(left), parse_initializer());
}

ast::ExprPtr Parser::parse_conditional() {
    ast::ExprPtr condition = parse_binary(1);
    if (!at("?")) return condition;
    const Token& op = take();
    ast::ExprPtr if_true = parse_assignment();
    expect(":", "the first choice of `?`");
    return node(ast::ExprKind::kConditional, op, std::move(condition), std::move(if_true),
                parse_assignment());
}

ast::ExprPtr Parser::parse_binary(int least) {
    ast::ExprPtr left = parse_unary();
    while (true) {
        const int level = precedence(peek());
        if (level == 0 || level < least) return left;
        const Token& op = take();
        left = node(ast::ExprKind::kBinary, op, std::move(left), parse_binary(level + 1));
    }
}

ast::ExprPtr Parser::parse_unary() {
    const Level level(this);
    if (!level.ok) return std::make_unique<ast::Expr>();
    for (std::string_view op : {"+", "-", "!", "~"}) {
        if (at(op)) {
            const Token& token = take();
            return node(ast::ExprKind::kUnary, token, parse_unary());
        }
    }
    if (at("++") || at("--")) {
        const Token& token = take();
        return node(ast::ExprKind::kPrefix, token, parse_unary());
    }
    if (at("(") && cast_length([&](size_t i) -> const Token& { return peek(i); }) != 0)
        return parse_cast();
    return parse_postfix();
}

ast::ExprPtr Parser::parse_cast() {
    const source::Span begin = take().span;
    const Token& type = take();
    std::vector<ast::ExprPtr> extents;
    while (accept("[")) {
        extents.push_back(parse_conditional());
        expect("]", "the array's size");
    }
    expect(")", "the type of a cast");
    ast::ExprPtr out = node(ast::ExprKind::kCast, type, parse_unary());
    for (ast::ExprPtr& extent : extents)
        add_arg(out.get(), std::move(extent));
    out->span.begin = begin.begin;
    return out;
}

size_t cast_length(const std::function<const Token&(size_t)>& peek) {
    constexpr size_t kMaxLength = 64;  // of a type with its extents
    if (!peek(0).is("(") || peek(1).kind != TokenKind::kIdentifier) return 0;
    size_t close = 2;
    for (int open = 0; open > 0 || peek(close).is("["); ++close) {
        if (close > kMaxLength || peek(close).kind == TokenKind::kEnd || peek(close).is(";"))
            return 0;
        if (peek(close).is("[")) ++open;
        if (peek(close).is("]")) --open;
    }
    if (!peek(close).is(")")) return 0;
    const Token& next = peek(close + 1);
    const bool operand = next.kind != TokenKind::kPunct && next.kind != TokenKind::kEnd;
    // A name that is not built in can only be a cast if no operator follows.
    const bool cast = is_builtin_type_name(peek(1).text)
                          ? operand || next.is("(") || next.is("-") || next.is("!") || next.is("~")
                          : operand && next.kind != TokenKind::kKeyword;
    return cast ? close + 1 : 0;
}

ast::ExprPtr Parser::parse_postfix() {
    ast::ExprPtr left = parse_primary();
    while (!gave_up_) {
        if (at("(")) {
            left = parse_call(std::move(left));
        } else if (at("[") && !peek(1).is("[") && !is_literal(*left)) {
            const Token& token = take();
            left = node(ast::ExprKind::kIndex, token, std::move(left), parse_expression());
            expect("]", "the index");
            left->span = span_to_previous(left->span);
        } else if (at(".")) {
            take();
            if (!at_identifier()) {
                expected("a member's name");
                return left;
            }
            left = node(ast::ExprKind::kMember, take(), std::move(left));
        } else if (at("++") || at("--")) {
            const Token& token = take();
            left = node(ast::ExprKind::kPostfix, token, std::move(left));
        } else {
            return left;
        }
    }
    return left;
}

ast::ExprPtr Parser::parse_call(ast::ExprPtr callee) {
    const size_t open = at_;
    ast::ExprPtr call = node(ast::ExprKind::kCall, take(), std::move(callee));
    if (!at(")")) {
        do {
            parse_argument_mark();
            add_arg(call.get(), parse_initializer());
        } while (accept(","));
    }
    if (!at(")") && last_error_ != at_ && !gave_up_) {
        diag::Diagnostic* d = expected("`,` or `)` after an argument");
        if (d != nullptr && d->helps.empty() && at(";"))
            d->insert_after(tokens_[at_ - 1].span, ")");
        const bool another = peek().kind != TokenKind::kPunct &&
                             peek().kind != TokenKind::kKeyword &&
                             peek().kind != TokenKind::kString && !at_end() && !on_fresh_line();
        if (d != nullptr && d->helps.empty() && another)
            d->insert_after(tokens_[at_ - 1].span, ",");
        if (d != nullptr && location(open).line != location(at_).line) note_opening(open, d);
    } else {
        accept(")");
    }
    call->span = span_to_previous(call->span);
    return call;
}

ast::ExprPtr Parser::parse_primary() {
    switch (peek().kind) {
        case TokenKind::kInt:
            return literal(ast::ExprKind::kIntLiteral);
        case TokenKind::kUint:
            return literal(ast::ExprKind::kUintLiteral);
        case TokenKind::kFloat:
            return literal(ast::ExprKind::kFloatLiteral);
        case TokenKind::kString:
            return literal(ast::ExprKind::kStringLiteral);
        case TokenKind::kIdentifier:
            return node(ast::ExprKind::kName, take());
        case TokenKind::kKeyword:
        case TokenKind::kPunct:
        case TokenKind::kEnd:
            break;
    }
    if (at("true") || at("false")) {
        ast::ExprPtr out = node(ast::ExprKind::kBoolLiteral, take());
        out->bits = out->text == "true" ? 1 : 0;
        return out;
    }
    if (at("(")) {
        const source::Span begin = take().span;
        ast::ExprPtr inner = parse_expression();
        expect(")", "the expression in parentheses");
        inner->span = span_to_previous(begin);
        return inner;
    }
    expected("an expression");
    auto bad = std::make_unique<ast::Expr>();
    bad->span = bad->text_span = peek().span;
    return bad;
}

ast::ExprPtr Parser::parse_initializer() {
    return at("{") ? parse_init_list() : parse_assignment();
}

ast::ExprPtr Parser::parse_init_list() {
    const Level level(this);
    if (!level.ok) return std::make_unique<ast::Expr>();
    ast::ExprPtr list = node(ast::ExprKind::kInitList, take());
    while (!at("}") && !at_end()) {
        add_arg(list.get(), parse_initializer());
        if (!accept(",")) break;
    }
    expect("}", "the list");
    list->span = span_to_previous(list->span);
    return list;
}

}  // namespace openfab::syntax

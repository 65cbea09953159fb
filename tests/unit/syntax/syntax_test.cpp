// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <bit>

#include "compiler/diag/render.h"
#include "compiler/syntax/parser.h"

namespace openfab::syntax {
namespace {

std::string words(const std::string& text) {
    source::SourceManager sources;
    diag::Sink sink;
    std::string out;
    for (const Token& t : lex(sources, sources.add("t.fl", text), &sink)) {
        if (t.kind != TokenKind::kEnd)
            out += std::string(spelling(t.kind)) + ":" + std::string(t.text) + " ";
    }
    EXPECT_EQ(diag::render_text(sink, sources), "");
    return out;
}

/// Returns the tree of an expression, as nested lists.
std::string tree(const ast::Expr& e) {
    if (e.args.empty()) return std::string(e.text);
    std::string out = "(" + std::string(e.text);
    for (const ast::ExprPtr& arg : e.args)
        out += " " + tree(*arg);
    return out + ")";
}

std::string parse_expression(const std::string& text) {
    source::SourceManager sources;
    diag::Sink sink;
    const std::vector<Token> tokens =
        lex(sources, sources.add("t.fl", "const float x = " + text + ";"), &sink);
    const ast::File file = parse(sources, tokens, &sink);
    EXPECT_EQ(diag::render_text(sink, sources), "");
    return file.scope.constants.empty() ? "" : tree(*file.scope.constants[0].init);
}

TEST(Lexer, LongestTokenWins) {
    EXPECT_EQ(words("a<<=b"), "identifier:a punct:<<= identifier:b ");
    EXPECT_EQ(words("a<- b"), "identifier:a punct:< punct:- identifier:b ");
    EXPECT_EQ(words("a+++b"), "identifier:a punct:++ punct:+ identifier:b ");
    EXPECT_EQ(words("x.y 1.5 .5 1."),
              "identifier:x punct:. identifier:y float:1.5 float:.5 float:1. ");
}

TEST(Lexer, CommentsAndBlanksAreGone) {
    EXPECT_EQ(words("\xEF\xBB\xBF// one\n/* two \n * / */ iff if // end"),
              "identifier:iff keyword:if ");
}

TEST(Lexer, NumbersHaveTheirBits) {
    source::SourceManager sources;
    diag::Sink sink;
    const std::vector<Token> t =
        lex(sources, sources.add("t.fl", "12 12u 0xff 0xffffffff 1e3 2.5f 1.h 3000000000"), &sink);
    EXPECT_EQ(t[0].bits, 12u);
    EXPECT_EQ(t[1].kind, TokenKind::kUint);
    EXPECT_EQ(t[2].bits, 255u);
    EXPECT_EQ(t[2].kind, TokenKind::kInt);
    EXPECT_EQ(t[3].bits, 0xffffffffu);
    EXPECT_EQ(t[3].kind, TokenKind::kUint);
    EXPECT_EQ(t[4].bits, std::bit_cast<uint32_t>(1000.0f));
    EXPECT_EQ(t[5].bits, std::bit_cast<uint32_t>(2.5f));
    EXPECT_EQ(t[6].bits, std::bit_cast<uint32_t>(1.0f));
    EXPECT_EQ(t[7].kind, TokenKind::kUint);
    EXPECT_EQ(sink.errors(), 0u);
}

TEST(Parser, PrecedenceIsThatOfC) {
    EXPECT_EQ(parse_expression("a + b * c - d"), "(- (+ a (* b c)) d)");
    EXPECT_EQ(parse_expression("a < b == c > d"), "(== (< a b) (> c d))");
    EXPECT_EQ(parse_expression("a | b ^ c & d << 1"), "(| a (^ b (& c (<< d 1))))");
    EXPECT_EQ(parse_expression("a || b && c"), "(|| a (&& b c))");
    EXPECT_EQ(parse_expression("a ? b : c ? d : e"), "(? a b (? c d e))");
    EXPECT_EQ(parse_expression("-a * !b"), "(* (- a) (! b))");
    EXPECT_EQ(parse_expression("-a.x[1]"), "(- ([ (x a) 1))");
    EXPECT_EQ(parse_expression("(a + b) * c"), "(* (+ a b) c)");
    EXPECT_EQ(parse_expression("(float3)a * b"), "(* (float3 a) b)");
    EXPECT_EQ(parse_expression("(a)(b)"), "(( a b)");
    EXPECT_EQ(parse_expression("f(a, g())"), "(( f a (( g))");
    EXPECT_EQ(parse_expression("a = b += c"), "(= a (+= b c))");
}

TEST(Parser, SpansCoverTheWholeExpression) {
    source::SourceManager sources;
    diag::Sink sink;
    const std::vector<Token> tokens =
        lex(sources, sources.add("t.fl", "const float x = (float)(a + f(b)[0]);"), &sink);
    const ast::File file = parse(sources, tokens, &sink);
    const ast::Expr& cast = *file.scope.constants[0].init;
    EXPECT_EQ(sources.text(cast.span), "(float)(a + f(b)[0])");
    EXPECT_EQ(sources.text(cast.args[0]->span), "(a + f(b)[0])");
    EXPECT_EQ(sources.text(cast.args[0]->args[1]->span), "f(b)[0]");
}

}  // namespace
}  // namespace openfab::syntax

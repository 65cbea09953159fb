// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// What begins with a marker: `@uniform { … }`, and the stages with their varyings.
#include <fmt/format.h>

#include <string>

#include "base/messages.h"
#include "base/near_miss.h"
#include "compiler/syntax/parser_state.h"

namespace openfab::syntax {

std::optional<ast::StageKind> stage_of(std::string_view marker) {
    for (const ast::StageKind kind :
         {ast::StageKind::kSurface, ast::StageKind::kVolume, ast::StageKind::kDither,
          ast::StageKind::kShape, ast::StageKind::kGrow}) {
        if (marker == ast::stage_name(kind)) return kind;
    }
    return std::nullopt;
}

/// Consumes `@` and a word, or a known word without its `@`, and returns the word; empty where
/// there is neither.
std::string_view Parser::marker_word(std::initializer_list<const char*> known) {
    if (at("@")) {
        const source::Span begin = take().span;
        if (!at_identifier()) {
            expected("a marker's name after `@`");
            return "?";
        }
        const Token& word = take();
        for (const char* candidate : known) {
            if (word.text == candidate) return word.text;
        }
        const std::vector<std::string> candidates(known.begin(), known.end());
        const std::string near = near_miss(word.text, candidates);
        diag::Diagnostic& d =
            sink_->report(span_to_previous(begin), diag::kUnknownMarker, word.text);
        if (near.empty()) {
            std::string all;
            for (const std::string& candidate : candidates)
                all += (all.empty() ? "`@" : ", `@") + candidate + "`";
            d.help("the markers here are " + all);
            return "?";
        }
        d.help(fmt::format(openfab::messages::kDidYouMean, "@" + near)).replace(word.span, near);
        for (const char* candidate : known) {
            if (near == candidate) return candidate;  // continue as if it were correct
        }
        return "?";
    }
    for (const char* candidate : known) {
        const bool starts =
            peek(1).is("{") || peek(1).is("(") || (at_identifier(1) && at_identifier(2));
        if (at_identifier() && peek().text == candidate && starts) {
            const Token& word = take();
            sink_->report(word.span, diag::kMissingAt, word.text)
                .help("write `@" + std::string(word.text) + "`")
                .insert_before(word.span, "@");
            last_error_ = at_;  // suppresses consequential errors
            return word.text;
        }
    }
    return "";
}

bool Parser::parse_marker(ast::Fablet* fablet) {
    if (parse_bare_uniform(fablet)) return true;
    const source::Span begin = peek().span;
    const std::string_view word =
        marker_word({"uniform", "Surface", "Volume", "Dither", "Shape", "Grow"});
    if (word.empty()) return false;
    if (word == "uniform") {
        parse_uniforms(fablet);
    } else if (const std::optional<ast::StageKind> stage = stage_of(word)) {
        parse_stage(fablet, *stage, span_to_previous(begin));
    } else {
        while (at("(") || at("{"))
            skip_balanced();
    }
    return true;
}

/// Parses `uniform float x;` or `@uniform float x;`, the syntax of other languages.
bool Parser::parse_bare_uniform(ast::Fablet* fablet) {
    const size_t word = at("@") ? 1 : 0;
    if (peek(word).text != "uniform" || !at_identifier(word + 1) || !at_identifier(word + 2)) {
        return false;
    }
    const source::Span begin = peek().span;
    take();
    if (word == 1) take();
    const source::Span span = span_to_previous(begin);
    const size_t first = at_;
    diag::Diagnostic& d = word == 0 ? sink_->report(span, diag::kMissingAt, "uniform")
                                    : sink_->report(peek().span, diag::kExpected,
                                                    "`{` after `@uniform`", describe(peek()));
    last_error_ = first;
    std::string form = std::string(peek().text) + " " + std::string(peek(1).text);
    d.help("uniforms go in a block: `@uniform { " + form + "; }`");
    const size_t errors = sink_->errors();
    const bool ok = parse_variables(false, &fablet->uniforms);
    if (!ok) skip_to_statement_end();
    // Adding another message may have moved this one.
    if (!ok || sink_->errors() != errors) return true;
    d.replace(span, "@uniform {").insert_after(tokens_[at_ - 1].span, " }");
    return true;
}

void Parser::parse_uniforms(ast::Fablet* fablet) {
    const size_t open = at_;
    if (!expect("{", "`@uniform`")) return skip_to_member();
    while (!at("}") && !at_end()) {
        const size_t before = at_;
        begin_item();
        if (at_identifier() && peek().text == "uniform" && at_identifier(1) && at_identifier(2)) {
            source::Span word = peek().span;
            word.end = peek(1).span.begin;
            if (diag::Diagnostic* d = expected("a uniform's type")) {
                d->helps.clear();
                d->help("all in this block are uniforms: leave out `uniform`").replace(word, "");
            }
            take();
        }
        if (at("const") && at_identifier(1)) {
            source::Span word = peek().span;
            word.end = peek(1).span.begin;
            if (diag::Diagnostic* d = expected("a uniform's type"))
                d->help("no stage changes a uniform: leave out `const`").replace(word, "");
            take();
        }
        if (!at_identifier()) {
            expected("a uniform's type");
            skip_to_statement_end();
        } else if (!parse_variables(false, &fablet->uniforms)) {
            skip_to_statement_end();
        }
        if (at_ == before) take();
        if (at_member_marker()) break;
    }
    expect_close("}", "the uniforms", open);
    accept(";");
}

void Parser::parse_stage(ast::Fablet* fablet, ast::StageKind kind, const source::Span& span) {
    ast::Stage stage;
    stage.kind = kind;
    stage.span = span;
    begin_item();
    if (at("(")) {
        take();
        parse_varyings(&stage);
        while (!at(")") && !at("{") && !at("}") && !at_end()) {
            expected("`)` after the varyings");
            skip_balanced();
        }
        if (!accept(")")) expected("`)` after the varyings");
    } else if (diag::Diagnostic* d =
                   expected(std::string("`(` after `@") + ast::stage_name(kind) + "`")) {
        d->help(varyings_form(kind));
    }
    if (at("[")) parse_claims(&stage);
    if (at("-") && peek(1).is(">")) {
        expected("the stage's body in `{ }`");
        while (!at("{") && !at("}") && !at(";") && !at_end())
            take();
    }
    if (at("{")) {
        stage.body = parse_block();
    } else {
        expected("the stage's body in `{ }`");
        skip_to_member();
    }
    fablet->stages.push_back(std::move(stage));
}

/// Parses `[[ distance ]]`.
void Parser::parse_claims(ast::Stage* stage) {
    constexpr const char* kForm = "write `[[ distance ]]` before the stage's body";
    const auto recover = [&](const char* what) {
        if (diag::Diagnostic* d = expected(what)) d->help(kForm);
        while (!at("{") && !at("}") && !at_end())
            take();
    };
    if (!peek(1).is("[")) return recover("`[[`");
    take();
    take();
    do {
        if (!at_identifier()) return recover("what the stage claims");
        stage->claims.push_back({peek().text, peek().span});
        take();
    } while (accept(","));
    if (!at("]") || !peek(1).is("]")) return recover("`]]`");
    take();
    take();
}

void Parser::parse_varyings(ast::Stage* stage) {
    if (at(")")) return;
    const std::string_view word = marker_word({"varying"});
    const char* form = varyings_form(stage->kind);
    if (word != "varying" || !at("{")) {
        const bool known = word == "varying";
        if (known || word.empty()) {
            diag::Diagnostic* d = expected(known ? "`{` after `@varying`" : "`@varying`");
            if (d != nullptr) d->help(form);
        }
        // Skips the tokens in place of the varyings.
        while (!at(")") && !at("{") && !at("}") && !at_end())
            take();
        if (!at("{") || peek(1).is("}")) return;
        if (word != "?") return;
    }
    const size_t open = at_;
    if (!accept("{")) return;
    while (!at("}") && !at_end()) {
        if (!parse_varying(stage)) {
            while (!at(",") && !at(";") && !at("}") && !at_end())
                skip_balanced();
        }
        if (at(";")) {
            if (diag::Diagnostic* d = expected("`,` between varyings")) {
                if (!peek(1).is("}")) d->replace(peek().span, ",");
            }
            take();
            continue;
        }
        if (!accept(",")) break;
    }
    expect_close("}", "the varyings", open);
}

bool Parser::parse_varying(ast::Stage* stage) {
    ast::Variable v;
    begin_item();
    if (marker_word({"nearest"}) == "nearest") v.nearest = true;
    parse_direction(&v);
    if (!at_identifier()) {
        expected("a varying's type");
        return false;
    }
    begin_item();
    const ast::TypeRef type{peek().text, peek().span};
    take();
    if (!at_identifier()) {
        if (diag::Diagnostic* d = expected("a name")) {
            d->help("a varying is a type and a name: `VolumeAttributes attr`");
        }
        return false;
    }
    const bool ok = parse_declarator(type, &v);
    if (ok) stage->varyings.push_back(std::move(v));
    return ok;
}

}  // namespace openfab::syntax

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/syntax/parser_state.h"

namespace openfab::syntax {

/// Parses `enum Name { A, B = 4, C [[ string label = "…" ]] };` with its semicolon.
bool Parser::parse_enum(ast::Enum* out) {
    take();
    if (at_identifier() && (peek().text == "class" || peek().text == "struct") &&
        at_identifier(1)) {
        source::Span word = peek().span;
        word.end = peek(1).span.begin;
        if (diag::Diagnostic* d = expected("the enum's name")) {
            d->helps.clear();
            d->help("the names of an enum are used alone: leave out `class`").replace(word, "");
        }
        take();
    }
    out->span = peek().span;
    if (!at_identifier()) {
        if (diag::Diagnostic* d = expected("the enum's name"))
            d->help("write `enum Pattern { STRIPES, DOTS };`");
        return false;
    }
    out->name = take().text;
    if (at(":") && at_identifier(1)) {
        if (diag::Diagnostic* d = expected("`{` after the enum's name")) {
            d->helps.clear();
            d->fix.clear();
            d->help("the values of an enum are ints").replace(between(at_, at_ + 1), "");
        }
        take();
        take();
    }
    const size_t open = at_;
    if (!expect("{", "the enum's name")) return false;
    while (!at("}") && !at_end()) {
        begin_item();
        if (!at_identifier()) {
            expected("a name");
            return false;
        }
        ast::Variable item;
        item.is_const = true;
        item.span = peek().span;
        item.name = take().text;
        if (accept("=")) item.init = parse_assignment();
        if (at("[") && peek(1).is("[")) parse_annotations(&item);
        out->items.push_back(std::move(item));
        if (at(";")) {
            if (diag::Diagnostic* d = expected("`,` between the names"))
                d->replace(peek().span, ",");
            take();
            continue;
        }
        if (!accept(",")) break;
    }
    if (!expect_close("}", "the enum's names", open)) return false;
    return expect(";", "the enum");
}

}  // namespace openfab::syntax

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "compiler/check/statement_checker.h"

namespace openfab::check {

namespace {

/// Returns whether a `break` in the statement leaves the enclosing `switch`.
bool mentions_break(const ast::Stmt& stmt) {
    if (stmt.kind == ast::StmtKind::kBreak) return true;
    if (stmt.kind != ast::StmtKind::kBlock && stmt.kind != ast::StmtKind::kIf) return false;
    return std::any_of(stmt.body.begin(), stmt.body.end(),
                       [](const ast::StmtPtr& child) { return mentions_break(*child); });
}

bool leaves(const ast::Stmt& stmt, bool breaks_leave);

/// Returns whether every section of an inner `switch` leaves the outer one; a `break` leaves the
/// inner one only.
bool switch_leaves(const ast::Stmt& stmt) {
    bool has_default = false;
    bool left = true;
    for (const ast::StmtPtr& child : stmt.body) {
        if (child->kind == ast::StmtKind::kCase) {
            has_default = has_default || child->expr == nullptr;
            left = false;
        } else {
            left = left || leaves(*child, false);
        }
        if (mentions_break(*child)) return false;
    }
    return has_default && left;
}

/// Returns whether control never reaches the end of the statement: as in HLSL, each section must
/// end like that.
bool leaves(const ast::Stmt& stmt, bool breaks_leave) {
    switch (stmt.kind) {
        case ast::StmtKind::kBreak:
            return breaks_leave;
        case ast::StmtKind::kContinue:
        case ast::StmtKind::kReturn:
            return true;
        case ast::StmtKind::kBlock:
            return std::any_of(stmt.body.begin(), stmt.body.end(), [&](const ast::StmtPtr& child) {
                return leaves(*child, breaks_leave);
            });
        case ast::StmtKind::kIf:
            return stmt.body.size() == 2 && leaves(*stmt.body[0], breaks_leave) &&
                   leaves(*stmt.body[1], breaks_leave);
        case ast::StmtKind::kSwitch:
            return switch_leaves(stmt);
        case ast::StmtKind::kBad:
        case ast::StmtKind::kEmpty:
        case ast::StmtKind::kDeclaration:
        case ast::StmtKind::kExpression:
        case ast::StmtKind::kFor:
        case ast::StmtKind::kWhile:
        case ast::StmtKind::kDo:
        case ast::StmtKind::kCase:
            return false;
    }
    return false;
}

}  // namespace

/// Parses the labels at `*at` and appends them to `out->labels`.
bool StatementChecker::labels(const ast::Stmt& stmt, size_t* at, const Type& type, Stmt* out) {
    Stmt::Labels section;
    for (; *at < stmt.body.size() && stmt.body[*at]->kind == ast::StmtKind::kCase; ++*at) {
        const ast::Stmt& label = *stmt.body[*at];
        if (label.expr == nullptr) {
            const bool again =
                section.is_default ||
                std::any_of(out->labels.begin(), out->labels.end(),
                            [](const Stmt::Labels& other) { return other.is_default; });
            if (again) sink_->report(label.span, diag::kRedeclared, "default");
            section.is_default = true;
            continue;
        }
        const ExprPtr value = convert(expression(*label.expr), type);
        if (value->type.is_error()) continue;
        const std::optional<uint32_t> bits = known_bits(*value);
        if (!bits) {
            sink_->report(label.expr->span, diag::kNotConstant, "the value of `case`");
            continue;
        }
        bool again = std::count(section.values.begin(), section.values.end(), *bits) != 0;
        for (const Stmt::Labels& other : out->labels) {
            again = again || std::count(other.values.begin(), other.values.end(), *bits) != 0;
        }
        if (again) {
            sink_->report(label.expr->span, diag::kRedeclared,
                          fmt::format("case {}", static_cast<int32_t>(*bits)));
        } else {
            section.values.push_back(*bits);
        }
    }
    out->labels.push_back(std::move(section));
    return !out->labels.back().values.empty() || out->labels.back().is_default;
}

StmtPtr StatementChecker::switch_statement(const ast::Stmt& stmt) {
    auto out = std::make_unique<Stmt>();
    out->kind = StmtKind::kSwitch;
    out->span = stmt.span;
    out->expr = expression(*stmt.expr);
    Type type = out->expr->type;
    if (!type.is_error() && !(type.is_scalar() && type.base != Base::kFloat)) {
        diag::Diagnostic& d = sink_->report(stmt.expr->span, diag::kBadOperand, "switch",
                                            fmt::format("`{}`", type_name(type)));
        if (type == kFloatType) d.help("convert it on purpose: `switch (int(x))`");
        type = {};
    }
    if (type.base == Base::kBool) type = kIntType;
    out->expr = convert(std::move(out->expr), type);
    if (!stmt.body.empty() && stmt.body[0]->kind != ast::StmtKind::kCase) {
        sink_->report(stmt.body[0]->span, diag::kExpected, "`case` or `default` in a `switch`",
                      "a statement before it");
        return out;
    }
    ++switches_;
    for (size_t at = 0; at < stmt.body.size();) {
        const ast::Stmt& label = *stmt.body[at];
        labels(stmt, &at, type, out.get());
        auto section = std::make_unique<Stmt>();
        section->span = label.span;
        scopes_.emplace_back();
        bool left = false;
        const size_t first = at;
        for (; at < stmt.body.size() && stmt.body[at]->kind != ast::StmtKind::kCase; ++at) {
            const ast::Stmt& child = *stmt.body[at];
            left = left || leaves(child, true);
            if (child.kind == ast::StmtKind::kDeclaration) {
                declaration(child, &section->body);
            } else {
                section->body.push_back(statement(child));
            }
        }
        scopes_.pop_back();
        out->body.push_back(std::move(section));
        if (!left && first != at && at < stmt.body.size()) {
            sink_->report(stmt.body[at]->span, diag::kFallThrough)
                .note(label.span, "the section that does not end begins here")
                .help("end it with `break`; several labels may share one section");
        }
    }
    --switches_;
    return out;
}

}  // namespace openfab::check

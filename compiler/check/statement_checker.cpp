// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <utility>

#include "compiler/check/foreign_names.h"
#include "compiler/check/limits.h"
#include "compiler/check/statement_checker.h"

namespace openfab::check {

namespace {

StmtPtr make_stmt(StmtKind kind, const source::Span& span) {
    auto out = std::make_unique<Stmt>();
    out->kind = kind;
    out->span = span;
    return out;
}

}  // namespace

StmtPtr StatementChecker::block(const ast::Stmt& stmt) {
    StmtPtr out = make_stmt(StmtKind::kBlock, stmt.span);
    scopes_.emplace_back();
    for (const ast::StmtPtr& child : stmt.body) {
        if (child->kind == ast::StmtKind::kDeclaration) {
            declaration(*child, &out->body);
        } else {
            out->body.push_back(statement(*child));
        }
    }
    scopes_.pop_back();
    return out;
}

StmtPtr StatementChecker::statement(const ast::Stmt& stmt) {
    switch (stmt.kind) {
        case ast::StmtKind::kBad:
        case ast::StmtKind::kEmpty:
            break;
        case ast::StmtKind::kBlock:
            return block(stmt);
        case ast::StmtKind::kDeclaration: {
            // A declaration as the whole body of an `if` or a loop: nothing can use the name.
            StmtPtr out = make_stmt(StmtKind::kBlock, stmt.span);
            scopes_.emplace_back();
            declaration(stmt, &out->body);
            scopes_.pop_back();
            return out;
        }
        case ast::StmtKind::kExpression: {
            StmtPtr out = make_stmt(StmtKind::kExpression, stmt.span);
            out->expr = expression(*stmt.expr);
            check_used(*stmt.expr, *out->expr);
            return out;
        }
        case ast::StmtKind::kIf:
            return if_statement(stmt);
        case ast::StmtKind::kFor:
        case ast::StmtKind::kWhile:
        case ast::StmtKind::kDo:
            return loop(stmt);
        case ast::StmtKind::kBreak:
            if (loops_ + switches_ == 0) sink_->report(stmt.span, diag::kNotInLoop, stmt.text);
            return make_stmt(StmtKind::kBreak, stmt.span);
        case ast::StmtKind::kContinue:
            if (loops_ == 0) sink_->report(stmt.span, diag::kNotInLoop, stmt.text);
            return make_stmt(StmtKind::kContinue, stmt.span);
        case ast::StmtKind::kReturn:
            return return_statement(stmt);
        case ast::StmtKind::kSwitch:
            return switch_statement(stmt);
        case ast::StmtKind::kCase:
            sink_->report(stmt.span, diag::kExpected, "a statement", fmt::format("`{}`", stmt.text))
                .help("a label belongs directly in the `{ }` of its `switch`");
            break;
    }
    return make_stmt(StmtKind::kBlock, stmt.span);
}

void StatementChecker::declaration(const ast::Stmt& stmt, std::vector<StmtPtr>* out) {
    if (stmt.record != nullptr) declare_struct(*stmt.record);
    for (const ast::Variable& v : stmt.variables)
        out->push_back(local(v));
}

/// Reports `auto x = 1;` with the type that the value has, which the variable is given; false at any other type.
bool StatementChecker::infer(const ast::Variable& v, Stmt* out) {
    const bool known = find(v.type.text) != nullptr || v.init == nullptr || !v.extents.empty() ||
                       v.init->kind == ast::ExprKind::kInitList ||
                       v.init->kind == ast::ExprKind::kStringLiteral;
    if (known || !infers_type(v.type.text)) return false;
    out->expr = expression(*v.init);
    const Type type = out->expr->type;
    diag::Diagnostic& d = sink_->report(v.type.span, diag::kUnknownType, v.type.text);
    d.help(foreign_type_help(v.type.text));
    if (!type.is_error() && type != kVoidType && !type.is_array())
        d.replace(v.type.span, type_name(type));
    out->symbol->type = type == kVoidType ? Type{} : type;
    declare(out->symbol.get());
    return true;
}

StmtPtr StatementChecker::local(const ast::Variable& v) {
    StmtPtr out = make_stmt(StmtKind::kDeclare, v.span);
    out->symbol = std::make_unique<Symbol>();
    Symbol& symbol = *out->symbol;
    symbol.kind = SymbolKind::kLocal;
    symbol.name = v.name;
    symbol.span = v.span;
    symbol.is_const = v.is_const;
    if (infer(v, out.get())) return out;
    symbol.type = declared_type(v);
    const Type& type = symbol.type;
    if (type == kVoidType) {
        sink_->report(v.type.span, diag::kBadDeclaration,
                      fmt::format("a variable cannot have type `{}`", v.type.text));
        symbol.type = {};
    }
    const bool untyped = v.init != nullptr && (v.init->kind == ast::ExprKind::kInitList ||
                                               v.init->kind == ast::ExprKind::kStringLiteral);
    if (v.init != nullptr && !(type.is_error() && untyped)) {
        // The name is not in scope in its own initializer.
        out->expr = initializer(*v.init, type);
        if (v.is_const && !out->expr->type.is_error()) symbol.known = known_bits(*out->expr);
    }
    const bool handle = type.is_attributes() || contains(type, Base::kTexture2D) ||
                        contains(type, Base::kTexture3D) || contains(type, Base::kObject);
    if ((v.is_const || handle) && v.init == nullptr && !type.is_error()) {
        sink_->report(v.span, diag::kBadDeclaration,
                      fmt::format("`{}` needs a value: it cannot be assigned later", v.name));
    }
    declare(&symbol);
    return out;
}

/// Returns n of `@bound(n)`, or 0.
int32_t StatementChecker::loop_bound(const ast::Stmt& stmt) {
    if (stmt.bound == nullptr) return 0;
    const std::optional<int32_t> bound = constant_int(*stmt.bound, "the bound of a loop");
    if (!bound) return 0;
    if (*bound < 1 || *bound > kMaxTrips) {
        sink_->report(stmt.bound->span, diag::kOutOfRange, "bound", *bound, 1, kMaxTrips);
        return 0;
    }
    return *bound;
}

StmtPtr StatementChecker::if_statement(const ast::Stmt& stmt) {
    StmtPtr out = make_stmt(StmtKind::kIf, stmt.span);
    out->expr = condition(*stmt.expr);
    for (const ast::StmtPtr& child : stmt.body)
        out->body.push_back(statement(*child));
    return out;
}

StmtPtr StatementChecker::loop(const ast::Stmt& stmt) {
    StmtPtr out = make_stmt(StmtKind::kLoop, stmt.span);
    out->test_last = stmt.kind == ast::StmtKind::kDo;
    out->bound = loop_bound(stmt);
    scopes_.emplace_back();
    if (stmt.init != nullptr) {
        out->init = make_stmt(StmtKind::kBlock, stmt.span);
        if (stmt.init->kind == ast::StmtKind::kDeclaration) {
            declaration(*stmt.init, &out->init->body);
        } else {
            out->init->body.push_back(statement(*stmt.init));
        }
    }
    if (stmt.expr != nullptr) out->expr = condition(*stmt.expr);
    if (stmt.step != nullptr) out->step = expression(*stmt.step);
    const int switches = std::exchange(switches_, 0);
    ++loops_;
    out->body.push_back(statement(*stmt.body[0]));
    --loops_;
    switches_ = switches;
    scopes_.pop_back();
    return out;
}

StmtPtr StatementChecker::return_statement(const ast::Stmt& stmt) {
    StmtPtr out = make_stmt(StmtKind::kReturn, stmt.span);
    if (stmt.expr == nullptr) {
        if (return_type_ != kVoidType && !return_type_.is_error()) {
            diag::Diagnostic& d =
                sink_->report(stmt.span, diag::kNoConversion, "void", type_name(return_type_));
            d.help(fmt::format("return a `{}`", type_name(return_type_)));
        }
        return out;
    }
    if (stmt.expr->kind == ast::ExprKind::kInitList && return_type_ != kVoidType) {
        out->expr = initializer(*stmt.expr, return_type_);
        return out;
    }
    ExprPtr value = expression(*stmt.expr);
    if (value->type.is_error() || return_type_.is_error()) return out;
    if (return_type_ == kVoidType && value->type != kVoidType) {
        diag::Diagnostic& d =
            sink_->report(stmt.expr->span, diag::kNoConversion, type_name(value->type), "void");
        help_with_conversion(value->type, kVoidType, &d);
        return out;
    }
    if (context_ == StageContext::kShape && is_no_shape(*value)) return out;
    out->expr = convert(std::move(value), return_type_);
    return out;
}

}  // namespace openfab::check

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/statement_checker.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "compiler/check/foreign_names.h"
#include "compiler/check/limits.h"

namespace openfab::check {

namespace {

StmtPtr make_stmt(StmtKind kind, const source::Span& span) {
    auto out = std::make_unique<Stmt>();
    out->kind = kind;
    out->span = span;
    return out;
}

/// Warns about an expression statement without effect; a call is assumed to be intended.
void check_used(diag::Sink* sink, const ast::Expr& from, const Expr& expr) {
    if (expr.type.is_error() || from.kind == ast::ExprKind::kComma ||
        from.kind == ast::ExprKind::kCall || side_effect(expr) != nullptr) {
        return;
    }
    diag::Diagnostic& d = sink->report(from.span, diag::kUnusedValue);
    if (from.kind == ast::ExprKind::kBinary && from.text == "==") {
        d.help("`=` assigns").replace(from.text_span, "=");
    }
}

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

StmtPtr StatementChecker::stage(const ast::Stmt& body, const Type& result) {
    begin(result);
    return block(body);
}

StmtPtr StatementChecker::function(const ast::Stmt& body, const Type& result) {
    begin(result);
    StmtPtr out = make_stmt(StmtKind::kBlock, body.span);
    children(body, out.get());
    return out;
}

void StatementChecker::begin(const Type& result) {
    return_type_ = result;
    loops_ = switches_ = 0;
}

void StatementChecker::children(const ast::Stmt& stmt, Stmt* out) {
    for (const ast::StmtPtr& child : stmt.body) {
        if (child->kind == ast::StmtKind::kDeclaration) {
            declaration(*child, &out->body);
        } else {
            out->body.push_back(statement(*child));
        }
    }
}

StmtPtr StatementChecker::block(const ast::Stmt& stmt) {
    StmtPtr out = make_stmt(StmtKind::kBlock, stmt.span);
    names_.open();
    children(stmt, out.get());
    names_.close();
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
            names_.open();
            declaration(stmt, &out->body);
            names_.close();
            return out;
        }
        case ast::StmtKind::kExpression: {
            StmtPtr out = make_stmt(StmtKind::kExpression, stmt.span);
            out->expr = expressions_.expression(*stmt.expr);
            check_used(sink_, *stmt.expr, *out->expr);
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
    if (stmt.record != nullptr) expressions_.types().declare_struct(*stmt.record);
    for (const ast::Variable& v : stmt.variables)
        out->push_back(local(v));
}

/// Reports `auto x = 1;` with the type that the value has, which the variable is given; false at any other type.
bool StatementChecker::infer(const ast::Variable& v, Stmt* out) {
    const bool known = names_.find(v.type.text) != nullptr || v.init == nullptr ||
                       !v.extents.empty() || v.init->kind == ast::ExprKind::kInitList ||
                       v.init->kind == ast::ExprKind::kStringLiteral;
    if (known || !infers_type(v.type.text)) return false;
    out->expr = expressions_.expression(*v.init);
    const Type type = out->expr->type;
    diag::Diagnostic& d = sink_->report(v.type.span, diag::kUnknownType, v.type.text);
    d.help(foreign_type_help(v.type.text));
    if (!type.is_error() && type != kVoidType && !type.is_array())
        d.replace(v.type.span, type_name(type));
    out->symbol->type = type == kVoidType ? Type{} : type;
    names_.declare(out->symbol.get());
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
    symbol.type = expressions_.types().declared_type(v);
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
        out->expr = expressions_.initializers().of(*v.init, type);
        if (v.is_const && !out->expr->type.is_error()) symbol.known = known_bits(*out->expr);
    }
    const bool handle = type.is_attributes() || contains(type, Base::kTexture2D) ||
                        contains(type, Base::kTexture3D) || contains(type, Base::kObject);
    if ((v.is_const || handle) && v.init == nullptr && !type.is_error()) {
        sink_->report(v.span, diag::kBadDeclaration,
                      fmt::format("`{}` needs a value: it cannot be assigned later", v.name));
    }
    names_.declare(&symbol);
    return out;
}

/// Returns n of `@bound(n)`, or 0.
int32_t StatementChecker::loop_bound(const ast::Stmt& stmt) {
    if (stmt.bound == nullptr) return 0;
    const std::optional<int32_t> bound =
        expressions_.types().constant_int(*stmt.bound, "the bound of a loop");
    if (!bound) return 0;
    if (*bound < 1 || *bound > kMaxTrips) {
        sink_->report(stmt.bound->span, diag::kOutOfRange, "bound", *bound, 1, kMaxTrips);
        return 0;
    }
    return *bound;
}

StmtPtr StatementChecker::if_statement(const ast::Stmt& stmt) {
    StmtPtr out = make_stmt(StmtKind::kIf, stmt.span);
    out->expr = expressions_.conditions().condition(*stmt.expr);
    for (const ast::StmtPtr& child : stmt.body)
        out->body.push_back(statement(*child));
    return out;
}

StmtPtr StatementChecker::loop(const ast::Stmt& stmt) {
    StmtPtr out = make_stmt(StmtKind::kLoop, stmt.span);
    out->test_last = stmt.kind == ast::StmtKind::kDo;
    out->bound = loop_bound(stmt);
    names_.open();
    if (stmt.init != nullptr) {
        out->init = make_stmt(StmtKind::kBlock, stmt.span);
        if (stmt.init->kind == ast::StmtKind::kDeclaration) {
            declaration(*stmt.init, &out->init->body);
        } else {
            out->init->body.push_back(statement(*stmt.init));
        }
    }
    if (stmt.expr != nullptr) out->expr = expressions_.conditions().condition(*stmt.expr);
    if (stmt.step != nullptr) out->step = expressions_.expression(*stmt.step);
    const int switches = std::exchange(switches_, 0);
    ++loops_;
    out->body.push_back(statement(*stmt.body[0]));
    --loops_;
    switches_ = switches;
    names_.close();
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
        out->expr = expressions_.initializers().of(*stmt.expr, return_type_);
        return out;
    }
    ExprPtr value = expressions_.expression(*stmt.expr);
    if (value->type.is_error() || return_type_.is_error()) return out;
    if (return_type_ == kVoidType && value->type != kVoidType) {
        diag::Diagnostic& d =
            sink_->report(stmt.expr->span, diag::kNoConversion, type_name(value->type), "void");
        Conversions::help(value->type, kVoidType, &d);
        return out;
    }
    if (place_.context == StageContext::kShape && is_no_shape(*value)) return out;
    out->expr = expressions_.conversions().implicit(std::move(value), return_type_);
    return out;
}

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
        const ExprPtr value =
            expressions_.conversions().implicit(expressions_.expression(*label.expr), type);
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
    out->expr = expressions_.expression(*stmt.expr);
    Type type = out->expr->type;
    if (!type.is_error() && !(type.is_scalar() && type.base != Base::kFloat)) {
        diag::Diagnostic& d = sink_->report(stmt.expr->span, diag::kBadOperand, "switch",
                                            fmt::format("`{}`", type_name(type)));
        if (type == kFloatType) d.help("convert it on purpose: `switch (int(x))`");
        type = {};
    }
    if (type.base == Base::kBool) type = kIntType;
    out->expr = expressions_.conversions().implicit(std::move(out->expr), type);
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
        names_.open();
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
        names_.close();
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

/// Reports a value that cannot be meant as a shape's; false for numbers.
bool StatementChecker::is_no_shape(const Expr& value) const {
    const bool number = value.type.is_scalar() && value.type.base != Base::kBool;
    if (number || value.type.is_error()) return false;
    const bool truth = value.type.is_scalar();
    sink_->report(value.span, diag::kNoConversion, type_name(value.type), "float")
        .note(place_.stage, "stage declared `@Shape` here")
        .help(truth
                  ? "a shape returns a number, negative inside: of a condition, `inside ? -1 : 1`, "
                    "better a distance, `length(p) - 5`"
                  : "a shape returns one number, negative inside: `length(p) - 5` is a ball of "
                    "radius 5");
    return true;
}

}  // namespace openfab::check

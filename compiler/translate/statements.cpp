// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "compiler/translate/proof.h"
#include "compiler/translate/stage_translator.h"

namespace openfab::translate {

using ir::ValueId;

namespace {

constexpr int kMaxInlineDepth = 64;

}  // namespace

/// Called between two statements: returns false if the second one is unreachable. If some paths
/// reach it, the rest becomes a branch, which `unwind` closes.
bool StageTranslator::skip_where_exited(std::vector<ValueId>* pending) {
    const ValueId exit = exited();
    if (always(exit) || gave_up_) return false;
    if (emit_.is_false(exit)) return true;
    pending->push_back(exit);
    enter(emit_.logical_not(exit));
    // Known to be false inside; merging restores the old values where they were true. A flag that
    // was false anyway does not become a variable of the loops around.
    const auto clear = [&](VariableId id) {
        if (!emit_.is_false(flag(id))) set_flag(id, emit_.constant(false));
    };
    clear(frame_.returned);
    if (frame_.in_loop) {
        clear(frame_.broken);
        clear(frame_.continued);
    }
    return true;
}

bool StageTranslator::too_complex(const source::Span& span) {
    if (gave_up_) return true;
    const bool steps = ++steps_ > step_limit_;
    const bool operations = emit_.operations_by_steps() > check::kMaxOperations;
    if (!steps && !operations && emit_.operations() <= check::kMaxChoices) return false;
    sink_
        ->report(span, diag::kTooComplex,
                 fmt::format("the stage has more than {} {}",
                             steps        ? check::kMaxSteps
                             : operations ? check::kMaxOperations
                                          : check::kMaxChoices,
                             steps        ? "statements"
                             : operations ? "operations"
                                          : "choices among elements of arrays"))
        .help(
            steps || operations
                ? "functions are inlined and short loops unrolled: make the innermost ones smaller"
                : "write accesses that are repeated as a loop, or take a smaller array");
    gave_up_ = true;
    return true;
}

// --- statements

void StageTranslator::statements(const std::vector<check::StmtPtr>& list) {
    std::vector<ValueId> pending;
    for (const check::StmtPtr& child : list) {
        if (!skip_where_exited(&pending)) break;
        statement(*child);
    }
    unwind(pending);
}

void StageTranslator::statement(const check::Stmt& stmt) {
    if (too_complex(stmt.span)) return;
    switch (stmt.kind) {
        case check::StmtKind::kBlock:
            return statements(stmt.body);
        case check::StmtKind::kDeclare:
            return declare(stmt);
        case check::StmtKind::kExpression:
            expression(*stmt.expr);
            return;
        case check::StmtKind::kIf:
            return branch(
                scalar(*stmt.expr), [&] { statement(*stmt.body[0]); },
                [&] {
                    if (stmt.body.size() > 1) statement(*stmt.body[1]);
                });
        case check::StmtKind::kLoop:
            return loop(stmt);
        case check::StmtKind::kBreak:
            return set_flag(frame_.broken, emit_.constant(true));
        case check::StmtKind::kContinue:
            return set_flag(frame_.continued, emit_.constant(true));
        case check::StmtKind::kReturn:
            return return_statement(stmt);
        case check::StmtKind::kSwitch:
            return switch_statement(stmt);
    }
}

void StageTranslator::declare(const check::Stmt& stmt) {
    // Before it is built, since a composition has a component for each material.
    if (check::min_components(stmt.symbol->type, fablet_.ir.slot_count) > check::kMaxComponents) {
        sink_->report(
            stmt.span, diag::kTooComplex,
            fmt::format("`{}` has more than {} components, counting those of each material",
                        stmt.symbol->name, check::kMaxComponents));
        gave_up_ = true;
        return;
    }
    Variable v;
    if (stmt.expr != nullptr) {
        v.value = expression(*stmt.expr);
    } else {
        v.value = zero(stmt.symbol->type);
        v.assigned = unassigned(stmt.symbol->type);
    }
    frame_.variables[stmt.symbol.get()] = add_variable(std::move(v));
}

void StageTranslator::return_statement(const check::Stmt& stmt) {
    if (stmt.expr != nullptr) {
        Value value = expression(*stmt.expr);
        if (!value.empty()) set(frame_.result, {std::move(value), {}});
    }
    set_flag(frame_.returned, emit_.constant(true));
}

// --- calls

bool StageTranslator::always(ValueId condition) const {
    return emit_.is_true(condition) || follows(*stage_, {}, condition);
}

void StageTranslator::check_assigned(const Variable& v, const check::Symbol& symbol) {
    const bool all =
        std::all_of(v.assigned.begin(), v.assigned.end(), [&](ValueId set) { return always(set); });
    if (!all && !gave_up_) sink_->report(symbol.span, diag::kOutputUnassigned, symbol.name);
}

/// Reports a path through a body that ends without `return`.
void StageTranslator::check_returned(const source::Span& span, const std::string& what,
                                     const check::Type& type, const check::Stmt& body) {
    if (always(flag(frame_.returned)) || gave_up_) return;
    diag::Diagnostic& d = sink_->report(span, diag::kMissingReturn, what);
    const check::Symbol* result = nullptr;
    for (const check::StmtPtr& stmt : body.body) {
        const bool fits = stmt->kind == check::StmtKind::kDeclare && stmt->symbol->type == type;
        if (fits && type.is(check::Base::kComposition)) result = stmt->symbol.get();
    }
    if (result == nullptr) {
        d.help(
            type.is(check::Base::kComposition)
                ? "every path ends with `return` of a `MaterialComposition`; an empty one is void"
                : fmt::format("every path ends with `return` and a value of type `{}`",
                              check::type_name(type)));
        return;
    }
    d.help(fmt::format("end it with `return {};`", result->name))
        .insert_before(body.span, fmt::format("    return {};\n    ", result->name));
}

/// Returns what `body` does one call deeper; empty if that is too deep.
Value StageTranslator::nested(const source::Span& span, const std::function<Value()>& body) {
    Value out;
    if (++inline_depth_ > kMaxInlineDepth) {
        sink_->report(span, diag::kTooComplex,
                      fmt::format("calls nested deeper than {} levels", kMaxInlineDepth));
        gave_up_ = true;
    } else {
        out = body();
    }
    --inline_depth_;
    return out;
}

Value StageTranslator::inline_call(const check::Expr& expr) {
    if (too_complex(expr.span)) return zero(expr.type);
    Value out = nested(expr.span, [&] { return call(expr); });
    return gave_up_ ? zero(expr.type) : out;
}

Value StageTranslator::call(const check::Expr& expr) {
    const check::Function& f = *expr.function;
    std::vector<Variable> arguments;
    std::vector<Target> targets(f.parameters.size());
    for (size_t i = 0; i < f.parameters.size(); ++i) {
        const check::Symbol& p = *f.parameters[i];
        Variable v;
        if (p.is_out) {
            targets[i] = target(*expr.args[i]);
            v.value = p.is_in ? read(targets[i], *expr.args[i]) : zero(p.type);
        } else {
            v.value = expression(*expr.args[i]);
        }
        if (!p.is_in) v.assigned = unassigned(p.type);
        arguments.push_back(std::move(v));
    }
    std::vector<Value> results;
    Value result;
    if (alone_) {
        result = call_result(f, f.return_type, 0, arguments);
        for (size_t i = 0; i < f.parameters.size(); ++i) {
            const check::Symbol& p = *f.parameters[i];
            const auto number = static_cast<int32_t>(i) + 1;
            results.push_back(p.is_out ? call_result(f, p.type, number, arguments) : Value{});
        }
    } else {
        inlined_.insert(&f);
        result = run_body(f, std::move(arguments), &results);
    }
    for (size_t i = 0; i < f.parameters.size(); ++i) {
        if (f.parameters[i]->is_out) store(targets[i], results[i]);
    }
    return result;
}

/// Returns the body's result; `results` receives the final values of its parameters.
Value StageTranslator::run_body(const check::Function& f, std::vector<Variable> arguments,
                                std::vector<Value>* results) {
    const size_t outside = variables_.size();
    Frame caller = std::exchange(frame_, Frame{});
    for (size_t i = 0; i < f.parameters.size(); ++i) {
        frame_.variables[f.parameters[i].get()] = add_variable(std::move(arguments[i]));
    }
    frame_.returned = add_flag();
    frame_.result = add_variable({zero(f.return_type), {}});
    statements(f.body->body);
    if (f.return_type != check::kVoidType)
        check_returned(f.span, fmt::format("`{}`", f.name), f.return_type, *f.body);
    Value result = variables_[frame_.result].value;
    for (const auto& p : f.parameters) {
        const Variable& v = variables_[frame_.variables[p.get()]];
        if (p->is_out) check_assigned(v, *p);
        results->push_back(v.value);
    }
    frame_ = std::move(caller);
    variables_.resize(outside);
    return result;
}

// --- functions by themselves

void StageTranslator::run(const check::Function& function) {
    alone_ = true;
    live_ = emit_.constant(true);
    std::vector<Variable> arguments;
    for (const auto& p : function.parameters) {
        Variable v;
        for (const ir::Type type : components(p->type)) {
            v.value.push_back(p->is_in ? emit_.input(type, kArgument, unknowns_++, 0)
                                       : emit_.constant(type, 0));
        }
        if (!p->is_in) v.assigned = unassigned(p->type);
        arguments.push_back(std::move(v));
    }
    std::vector<Value> results;
    run_body(function, std::move(arguments), &results);
}

/// Functions have no state: equal arguments give equal results. `number` is 0 for the result of
/// `f`, then counts its parameters.
Value StageTranslator::call_result(const check::Function& f, const check::Type& type,
                                   int32_t number, const std::vector<Variable>& arguments) {
    const auto callee = static_cast<int32_t>(callees_.size());
    const int32_t known = callees_.emplace(&f, callee).first->second;
    std::vector<ValueId> values = {emit_.constant(ir::Type::kInt, static_cast<uint32_t>(number))};
    for (const Variable& argument : arguments)
        values.insert(values.end(), argument.value.begin(), argument.value.end());
    Value out;
    for (const ir::Type component : components(type)) {
        const auto index = static_cast<int32_t>(out.size());
        out.push_back(emit_.unknown(component, kCallResult, known, index, values));
    }
    return out;
}

}  // namespace openfab::translate

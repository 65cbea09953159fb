// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/calls.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace openfab::translate {

using ir::ValueId;

void Calls::check_assigned(const Variable& v, const check::Symbol& symbol) {
    const bool all = std::all_of(v.assigned.begin(), v.assigned.end(),
                                 [&](ValueId set) { return facts_.always(set); });
    if (!all && !budget_.gave_up) sink_->report(symbol.span, diag::kOutputUnassigned, symbol.name);
}

/// Reports a path through a body that ends without `return`.
void Calls::check_returned(const source::Span& span, const std::string& what,
                           const check::Type& type, const check::Stmt& body) {
    if (facts_.always(paths_.flag(paths_.frame.returned)) || budget_.gave_up) return;
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

Value Calls::inline_call(const check::Expr& expr) {
    if (budget_.too_complex(expr.span)) return layout_.zero(expr.type);
    Value out = budget_.nested(expr.span, [&] { return call(expr); });
    return budget_.gave_up ? layout_.zero(expr.type) : out;
}

Value Calls::call(const check::Expr& expr) {
    const check::Function& f = *expr.function;
    std::vector<Variable> arguments;
    std::vector<Target> targets(f.parameters.size());
    for (size_t i = 0; i < f.parameters.size(); ++i) {
        const check::Symbol& p = *f.parameters[i];
        Variable v;
        if (p.is_out) {
            targets[i] = targets_.target(*expr.args[i]);
            v.value = p.is_in ? targets_.read(targets[i], *expr.args[i]) : layout_.zero(p.type);
        } else {
            v.value = expressions_.expression(*expr.args[i]);
        }
        if (!p.is_in) v.assigned = layout_.unassigned(p.type);
        arguments.push_back(std::move(v));
    }
    std::vector<Value> results;
    Value value;
    if (place_.alone) {
        value = result(f, f.return_type, 0, arguments);
        for (size_t i = 0; i < f.parameters.size(); ++i) {
            const check::Symbol& p = *f.parameters[i];
            const auto number = static_cast<int32_t>(i) + 1;
            results.push_back(p.is_out ? result(f, p.type, number, arguments) : Value{});
        }
    } else {
        inlined_.insert(&f);
        value = run_body(f, std::move(arguments), &results);
    }
    for (size_t i = 0; i < f.parameters.size(); ++i) {
        if (f.parameters[i]->is_out) targets_.store(targets[i], results[i]);
    }
    return value;
}

Value Calls::run_body(const check::Function& f, std::vector<Variable> arguments,
                      std::vector<Value>* results) {
    const size_t outside = paths_.variables.size();
    Frame caller = std::exchange(paths_.frame, Frame{});
    for (size_t i = 0; i < f.parameters.size(); ++i) {
        paths_.frame.variables[f.parameters[i].get()] =
            paths_.add_variable(std::move(arguments[i]));
    }
    paths_.frame.returned = paths_.add_flag();
    paths_.frame.result = paths_.add_variable({layout_.zero(f.return_type), {}});
    statements_.list(f.body->body);
    if (f.return_type != check::kVoidType)
        check_returned(f.span, fmt::format("`{}`", f.name), f.return_type, *f.body);
    Value result = paths_.variables[paths_.frame.result].value;
    for (const auto& p : f.parameters) {
        const Variable& v = paths_.variables[paths_.frame.variables[p.get()]];
        if (p->is_out) check_assigned(v, *p);
        results->push_back(v.value);
    }
    paths_.frame = std::move(caller);
    paths_.variables.resize(outside);
    return result;
}

/// Functions have no state: equal arguments give equal results. `number` is 0 for the result of
/// `f`, then counts its parameters.
Value Calls::result(const check::Function& f, const check::Type& type, int32_t number,
                    const std::vector<Variable>& arguments) {
    const auto callee = static_cast<int32_t>(callees_.size());
    const int32_t known = callees_.emplace(&f, callee).first->second;
    std::vector<ValueId> values = {emit_.constant(ir::Type::kInt, static_cast<uint32_t>(number))};
    for (const Variable& argument : arguments)
        values.insert(values.end(), argument.value.begin(), argument.value.end());
    Value out;
    for (const ir::Type component : layout_.components(type)) {
        const auto index = static_cast<int32_t>(out.size());
        out.push_back(emit_.unknown(component, kCallResult, known, index, values));
    }
    return out;
}

}  // namespace openfab::translate

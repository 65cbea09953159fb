// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/loops.h"

#include <algorithm>
#include <utility>

#include "compiler/translate/loop_bounds.h"

namespace openfab::translate {

using ir::ValueId;

namespace {

// A real loop costs about as much compile time as a few hundred instructions, and at run time a
// load and a store of each variable in each iteration.
constexpr int kFewTrips = 16;
constexpr size_t kManyOperations = 4000;  // for few iterations

constexpr size_t kFewOperations = 1500;  // for more

// The size of a stage from which no more loops are unrolled.
constexpr size_t kMaxUnrolledOperations = 12000;

// The most segments that unrolling may add to a stage.
constexpr size_t kManyKernels = 16;

size_t kernels_of(ir::Op op) {
    if (op == ir::Op::kLoop) return kManyKernels / 2;
    return op == ir::Op::kQuery || op == ir::Op::kPrintf ? 1 : 0;
}

/// Returns whether an expression of variables costs next to nothing to recompute.
bool is_plain(const check::Expr& expr) {
    const bool bounds =
        expr.kind == check::ExprKind::kIntrinsic &&
        (expr.intrinsic == check::Intrinsic::kMin || expr.intrinsic == check::Intrinsic::kMax ||
         expr.intrinsic == check::Intrinsic::kClamp);
    const bool arithmetic =
        bounds || expr.kind == check::ExprKind::kBinary || expr.kind == check::ExprKind::kUnary ||
        expr.kind == check::ExprKind::kConvert || expr.kind == check::ExprKind::kConditional;
    if (!arithmetic)
        return expr.kind == check::ExprKind::kVariable || expr.kind == check::ExprKind::kConstant;
    return std::all_of(expr.args.begin(), expr.args.end(),
                       [](const check::ExprPtr& arg) { return is_plain(*arg); });
}

const check::Symbol* base_symbol(const check::Expr& target) {
    const check::Expr* expr = &target;
    while (expr->kind != check::ExprKind::kVariable) {
        if (expr->args.empty()) return nullptr;
        expr = expr->args[0].get();
    }
    return expr->symbol;
}

/// Collects the symbols that a statement assigns, but for those that a called function sees by
/// itself, which are found when the loop is translated.
class AssignedSymbols {
  public:
    void visit(const check::Stmt& stmt) {
        if (stmt.kind == check::StmtKind::kReturn) returns = true;
        for (const check::ExprPtr* expr : {&stmt.expr, &stmt.step}) {
            if (*expr != nullptr) visit(**expr);
        }
        if (stmt.init != nullptr) visit(*stmt.init);
        for (const check::StmtPtr& child : stmt.body)
            visit(*child);
    }

    void visit(const check::Expr& expr) {
        if (expr.kind == check::ExprKind::kAssign || expr.kind == check::ExprKind::kIncrement ||
            expr.kind == check::ExprKind::kSet || expr.kind == check::ExprKind::kAdd ||
            expr.kind == check::ExprKind::kClear) {
            add(*expr.args[0]);
        }
        if (expr.kind == check::ExprKind::kIntrinsic &&
            (expr.intrinsic == check::Intrinsic::kSincos ||
             expr.intrinsic == check::Intrinsic::kModf ||
             expr.intrinsic == check::Intrinsic::kFrexp)) {
            for (size_t i = 1; i < expr.args.size(); ++i)
                add(*expr.args[i]);
        }
        if (expr.kind == check::ExprKind::kCall && expr.function != nullptr) {
            for (size_t i = 0; i < expr.args.size(); ++i) {
                if (expr.function->parameters[i]->is_out) add(*expr.args[i]);
            }
        }
        for (const check::ExprPtr& arg : expr.args)
            visit(*arg);
    }

    std::vector<const check::Symbol*> symbols;
    bool returns = false;

  private:
    void add(const check::Expr& target) {
        const check::Symbol* symbol = base_symbol(target);
        if (symbol != nullptr) symbols.push_back(symbol);
    }
};

/// Returns the int that the loop `for (…; i < x; ++i)`, or `--i` with `>`, counts with, if nothing
/// else assigns it: it then stays on one side of its start.
const check::Symbol* steady_counter(const check::Stmt& loop) {
    if (loop.expr == nullptr || loop.step == nullptr || loop.test_last) return nullptr;
    const check::Expr& test = *loop.expr;
    const check::Expr& step = *loop.step;
    if (test.kind != check::ExprKind::kBinary || step.kind != check::ExprKind::kIncrement)
        return nullptr;
    const bool up = step.op == ir::Op::kAdd;
    if (test.args[0]->kind != check::ExprKind::kVariable ||
        step.args[0]->kind != check::ExprKind::kVariable ||
        test.args[0]->symbol != step.args[0]->symbol || test.args[0]->type != check::kIntType)
        return nullptr;
    // `<=` of the largest int always holds, and the counter wraps.
    const check::Expr& end = *test.args[1];
    const uint32_t last = up ? 0x7fffffffu : 0x80000000u;
    const bool inclusive = test.op == (up ? ir::Op::kLe : ir::Op::kGe) &&
                           end.kind == check::ExprKind::kConstant && end.bits != last;
    if (!inclusive && test.op != (up ? ir::Op::kLt : ir::Op::kGt)) return nullptr;
    AssignedSymbols assigned;
    assigned.visit(*loop.body[0]);
    const check::Symbol* counter = step.args[0]->symbol;
    const auto& all = assigned.symbols;
    return std::find(all.begin(), all.end(), counter) == all.end() ? counter : nullptr;
}

}  // namespace

Loops::Attempt Loops::attempt() const {
    return {emit_.size(), stage_->printfs.size(), sink_->mark(), paths_.variables,
            paths_.open,  paths_.frame,           paths_.live,   budget_.inline_depth};
}

/// Rolls back to the start of an attempt, except the diagnostics.
void Loops::rollback_code(const Attempt& start) {
    emit_.truncate(start.instructions);
    stage_->printfs.resize(start.printfs);
    paths_.variables = start.variables;
    paths_.open = start.open;
    paths_.frame = start.frame;
    paths_.live = start.live;
    budget_.inline_depth = start.inline_depth;
}

void Loops::rollback(const Attempt& start) {
    rollback_code(start);
    sink_->rollback(start.reported);
    budget_.gave_up = false;
}

void Loops::loop(const check::Stmt& stmt) {
    if (stmt.init != nullptr) {
        // Not a block: its declarations live as long as the loop.
        for (const check::StmtPtr& child : stmt.init->body)
            statements_.statement(*child);
    }
    if (budget_.gave_up) return;
    const Attempt start = attempt();
    if (unroll_in_steps(stmt)) return;
    rollback(start);
    run_loop(stmt);
}

/// Unrolls unless it takes too many steps: nests of which all is constant come to few operations
/// however often they run. What the steps were spent on is not tried again.
bool Loops::unroll_in_steps(const check::Stmt& stmt) {
    if (too_long_.count(&stmt) != 0) return false;
    const size_t limit = budget_.steps + budget_.unroll_limit;
    const size_t outer = std::exchange(budget_.step_limit, std::min(budget_.step_limit, limit));
    const bool done = unroll(stmt);
    budget_.step_limit = outer;
    if (budget_.steps > limit) too_long_.insert(&stmt);
    return done;
}

bool Loops::fits_unroll_budget(size_t begin, int trips) {
    const size_t size = emit_.operations() - emit_.operations(begin);
    size_t kernels = 0;
    for (size_t id = begin; id < emit_.size(); ++id) {
        kernels += kernels_of(emit_.instr(static_cast<ValueId>(id)).op);
    }
    if (kernels > kManyKernels) return false;
    if (emit_.operations() > kMaxUnrolledOperations) return false;
    return size <= (trips <= kFewTrips ? kManyOperations : kFewOperations);
}

/// Returns false if a test is not a constant or the result would be too long.
bool Loops::unroll(const check::Stmt& stmt) {
    const size_t begin = emit_.size();
    const Frame outer = paths_.frame;
    paths_.frame.in_loop = true;
    paths_.frame.broken = paths_.add_flag();
    paths_.frame.continued = paths_.add_flag();
    std::vector<ValueId> pending;
    bool done = false;
    for (int trips = 0; !budget_.gave_up; ++trips) {
        if (stmt.bound > 0 && trips == stmt.bound) {
            done = true;
            break;
        }
        if (stmt.expr != nullptr && !(stmt.test_last && trips == 0)) {
            const ValueId test = expressions_.scalar(*stmt.expr);
            if (!emit_.is_constant(test)) break;
            done = emit_.is_false(test);
            if (done) break;
        }
        if (trips == check::kMaxUnrolledTrips || !fits_unroll_budget(begin, trips)) break;
        const size_t outside = paths_.variables.size();
        statements_.statement(*stmt.body[0]);
        paths_.variables.resize(outside);
        paths_.set_flag(paths_.frame.continued, emit_.constant(false));
        if (!statements_.skip_where_exited(&pending)) {
            done = !budget_.gave_up;
            break;
        }
        if (stmt.step != nullptr) expressions_.expression(*stmt.step);
    }
    if (!done) return false;
    paths_.unwind(pending);
    paths_.frame.in_loop = outer.in_loop;
    paths_.frame.broken = outer.broken;
    paths_.frame.continued = outer.continued;
    return true;
}

std::set<VariableId> Loops::guess_changed(const check::Stmt& stmt) const {
    AssignedSymbols assigned;
    assigned.visit(stmt);
    std::set<VariableId> out;
    for (const check::Symbol* symbol : assigned.symbols) {
        const auto variable = paths_.frame.variables.find(symbol);
        if (variable != paths_.frame.variables.end() &&
            variable->second < paths_.variables.size()) {
            out.insert(variable->second);
        }
    }
    if (assigned.returns) out.insert({paths_.frame.result, paths_.frame.returned});
    return out;
}

void Loops::run_loop(const check::Stmt& stmt) {
    ValueId guard = paths_.live;
    bool certain = true;  // the first iteration runs wherever the loop is reached
    if (stmt.expr != nullptr && !stmt.test_last) {
        const ValueId test = expressions_.scalar(*stmt.expr);
        certain = emit_.is_true(test);
        guard = emit_.logical_and(paths_.live, test);
    }
    std::set<VariableId> changed = guess_changed(stmt);
    const Attempt start = attempt();
    for (;;) {
        RealLoop loop = make_loop(stmt, guard, changed);
        bool complete = true;
        for (const auto& item : loop.changes) {
            if (changed.insert(item.first).second) complete = false;
        }
        if (budget_.gave_up) return rollback_code(start);
        if (complete) return finish_loop(stmt, loop, guard, certain);
        rollback(start);
    }
}

/// Adds to the tests that hold in this iteration on which side of its start the counter is.
void Loops::push_start_test(const check::Stmt& stmt) {
    const check::Symbol* counter = steady_counter(stmt);
    if (counter == nullptr) return;
    const auto variable = paths_.frame.variables.find(counter);
    if (variable == paths_.frame.variables.end()) return;
    const ValueId now = paths_.variables[variable->second].value[0];
    if (emit_.instr(now).op != ir::Op::kLoopVar) return;
    const ir::Op side = stmt.step->op == ir::Op::kAdd ? ir::Op::kGe : ir::Op::kLe;
    tests_.push_back(emit_.binary(side, now, emit_.instr(now).args[1]));
}

/// Makes one attempt: translates the loop up to its end, which is not emitted yet. Restores the
/// variables.
Loops::RealLoop Loops::make_loop(const check::Stmt& stmt, ValueId guard,
                                 const std::set<VariableId>& changed) {
    RealLoop loop;
    // Before the loop, which starts with its variables.
    for (const VariableId id : changed) {
        Value& assigned = loop.assigned_before[id];
        for (const ValueId before : paths_.variables[id].assigned)
            assigned.push_back(facts_.assigned_by_a_trip(before, kEarlierTrip));
    }
    const ValueId zero = emit_.constant(ir::Type::kInt, 0);
    loop.id = emit_.loop(guard);
    paths_.open.push_back({{}, paths_.variables.size(), paths_.live});
    paths_.outer_live.push_back(guard);
    paths_.live = emit_.constant(true);
    for (const VariableId id : changed) {
        Variable v = paths_.variables[id];
        for (ValueId& value : v.value) {
            value = emit_.loop_var(loop.id, static_cast<int32_t>(loop.vars++), value);
        }
        // After a return there is no further iteration.
        if (id == paths_.frame.returned) v.value[0] = paths_.variables[id].value[0];
        v.assigned = loop.assigned_before.at(id);
        paths_.set(id, std::move(v));
    }
    const ValueId counter = stmt.bound > 0
                                ? emit_.loop_var(loop.id, static_cast<int32_t>(loop.vars), zero)
                                : ir::kNoValue;
    // The variables' initial values must precede the loop.
    const Frame outer = paths_.frame;
    paths_.frame.in_loop = true;
    paths_.frame.broken = paths_.add_flag();
    paths_.frame.continued = paths_.add_flag();
    const VariableId go = paths_.add_flag();
    const bool tested = stmt.expr != nullptr && !stmt.test_last && is_plain(*stmt.expr);
    const size_t outer_tests = tests_.size();
    if (tested) {
        tests_.push_back(expressions_.scalar(*stmt.expr));
        push_start_test(stmt);
    }
    statements_.statement(*stmt.body[0]);
    tests_.resize(outer_tests);
    paths_.set_flag(paths_.frame.continued, emit_.constant(false));
    std::vector<ValueId> pending;
    if (statements_.skip_where_exited(&pending)) {
        if (stmt.step != nullptr) expressions_.expression(*stmt.step);
        paths_.set_flag(
            go, stmt.expr != nullptr ? expressions_.scalar(*stmt.expr) : emit_.constant(true));
    }
    paths_.unwind(pending);
    loop.again = paths_.flag(go);
    if (counter != ir::kNoValue) {
        loop.count = emit_.binary(ir::Op::kAdd, counter, emit_.constant(ir::Type::kInt, 1));
        const ValueId limit = emit_.constant(ir::Type::kInt, static_cast<uint32_t>(stmt.bound));
        loop.again = emit_.logical_and(loop.again, emit_.binary(ir::Op::kLt, loop.count, limit));
    }
    paths_.frame.in_loop = outer.in_loop;
    paths_.frame.broken = outer.broken;
    paths_.frame.continued = outer.continued;
    paths_.outer_live.pop_back();
    loop.changes = paths_.leave();
    return loop;
}

void Loops::finish_loop(const check::Stmt& stmt, const RealLoop& loop, ValueId guard,
                        bool certain) {
    std::vector<ValueId> next;
    for (const auto& item : loop.changes)
        next.insert(next.end(), item.second.value.begin(), item.second.value.end());
    if (loop.count != ir::kNoValue) next.push_back(loop.count);
    const double most = most_trips(*stage_, loop.id, loop.again, next, tests_);
    if (!emit_.is_false(loop.again) && stmt.bound == 0 && !(most <= check::kMaxTrips)) {
        const check::Expr* test = stmt.expr.get();
        sink_->report(test != nullptr ? test->span : stmt.span, diag::kLoopUnbounded)
            .help(
                "compare a counter with a constant or with something of known range, `min(n, 64)`; "
                "or "
                "write `@bound(n)` before the loop, which then stops after n trips");
    }
    const ValueId end = emit_.loop_end(loop.id, loop.again, next);
    const ValueId ran = certain ? emit_.constant(true) : guard;
    int32_t number = 0;
    for (const auto& item : loop.changes) {
        Variable v = paths_.variables[item.first];
        for (size_t i = 0; i < v.value.size(); ++i, ++number) {
            v.value[i] = emit_.loop_result(end, number);
        }
        for (size_t i = 0; i < v.assigned.size(); ++i) {
            const ValueId by_trip = item.second.assigned[i];
            if (by_trip == loop.assigned_before.at(item.first)[i]) continue;  // by none
            v.assigned[i] = facts_.always(by_trip)
                                ? emit_.logical_or(v.assigned[i], ran)
                                : facts_.assigned_by_a_trip(v.assigned[i], kSomeTrip);
        }
        paths_.set(item.first, std::move(v));
    }
}

}  // namespace openfab::translate

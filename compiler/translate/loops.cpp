// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Loops: unrolled if the number of iterations is constant and the result stays small, else real
// loops. A real loop is translated as `if (test) do { body; step; } while (test)`, since every
// iteration costs a pass over memory. A failed attempt is rolled back, code and diagnostics, before
// the next.
#include <algorithm>
#include <utility>

#include "compiler/translate/loop_bounds.h"
#include "compiler/translate/proof.h"
#include "compiler/translate/stage_translator.h"

namespace openfab::translate {

using ir::ValueId;

namespace {

// A real loop costs about as much compile time as a few hundred instructions, and at run time a
// load and a store of each variable in each iteration.
constexpr int kFewTrips = 16;
constexpr size_t kManyOperations = 4000;  // for few iterations
constexpr size_t kFewOperations = 1500;   // for more
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

StageTranslator::Attempt StageTranslator::attempt() const {
    return {emit_.size(), stage_->printfs.size(), sink_->mark(), variables_, open_, frame_,
            live_,        inline_depth_};
}

/// Rolls back to the start of an attempt, except the diagnostics.
void StageTranslator::rollback_code(const Attempt& start) {
    emit_.truncate(start.instructions);
    stage_->printfs.resize(start.printfs);
    variables_ = start.variables;
    open_ = start.open;
    frame_ = start.frame;
    live_ = start.live;
    inline_depth_ = start.inline_depth;
}

void StageTranslator::rollback(const Attempt& start) {
    rollback_code(start);
    sink_->rollback(start.reported);
    gave_up_ = false;
}

bool StageTranslator::is_implied(ValueId fact, ValueId and_where) const {
    std::vector<ValueId> given = outer_live_;
    given.push_back(live_);
    given.push_back(and_where);
    return std::any_of(given.begin(), given.end(),
                       [&](ValueId condition) { return emit_.implies(condition, fact); }) ||
           follows(*stage_, given, fact);
}

/// Returns `assigned`, or true in an unknown iteration.
ValueId StageTranslator::assigned_by_a_trip(ValueId assigned, int32_t which) {
    if (emit_.is_true(assigned)) return assigned;
    const ValueId unknown = emit_.input(ir::Type::kBool, which, unknowns_++, 0);
    return emit_.logical_or(assigned, unknown);
}

/// Returns whether only an earlier iteration can have assigned it.
bool StageTranslator::unassigned_in_first_trip(ValueId assigned) const {
    const ir::Instr& instr = emit_.instr(assigned);
    if (instr.op == ir::Op::kInput) return instr.kind == kEarlierTrip;
    return instr.op == ir::Op::kOr && unassigned_in_first_trip(instr.args[0]) &&
           unassigned_in_first_trip(instr.args[1]);
}

/// Returns whether loops are open and the first iteration of each reaches the current point.
bool StageTranslator::first_trip_comes_here() const {
    if (outer_live_.empty()) return false;
    return emit_.is_true(live_) && std::all_of(outer_live_.begin() + 1, outer_live_.end(),
                                               [&](ValueId guard) { return emit_.is_true(guard); });
}

void StageTranslator::loop(const check::Stmt& stmt) {
    if (stmt.init != nullptr) {
        // Not a block: its declarations live as long as the loop.
        for (const check::StmtPtr& child : stmt.init->body)
            statement(*child);
    }
    if (gave_up_) return;
    const Attempt start = attempt();
    if (unroll_in_steps(stmt)) return;
    rollback(start);
    run_loop(stmt);
}

/// Unrolls unless it takes too many steps: nests of which all is constant come to few operations
/// however often they run. What the steps were spent on is not tried again.
bool StageTranslator::unroll_in_steps(const check::Stmt& stmt) {
    if (too_long_.count(&stmt) != 0) return false;
    const size_t limit = steps_ + unroll_limit_;
    const size_t outer = std::exchange(step_limit_, std::min(step_limit_, limit));
    const bool done = unroll(stmt);
    step_limit_ = outer;
    if (steps_ > limit) too_long_.insert(&stmt);
    return done;
}

bool StageTranslator::fits_unroll_budget(size_t begin, int trips) {
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
bool StageTranslator::unroll(const check::Stmt& stmt) {
    const size_t begin = emit_.size();
    const Frame outer = frame_;
    frame_.in_loop = true;
    frame_.broken = add_flag();
    frame_.continued = add_flag();
    std::vector<ValueId> pending;
    bool done = false;
    for (int trips = 0; !gave_up_; ++trips) {
        if (stmt.bound > 0 && trips == stmt.bound) {
            done = true;
            break;
        }
        if (stmt.expr != nullptr && !(stmt.test_last && trips == 0)) {
            const ValueId test = scalar(*stmt.expr);
            if (!emit_.is_constant(test)) break;
            done = emit_.is_false(test);
            if (done) break;
        }
        if (trips == check::kMaxUnrolledTrips || !fits_unroll_budget(begin, trips)) break;
        const size_t outside = variables_.size();
        statement(*stmt.body[0]);
        variables_.resize(outside);
        set_flag(frame_.continued, emit_.constant(false));
        if (!skip_where_exited(&pending)) {
            done = !gave_up_;
            break;
        }
        if (stmt.step != nullptr) expression(*stmt.step);
    }
    if (!done) return false;
    unwind(pending);
    frame_.in_loop = outer.in_loop;
    frame_.broken = outer.broken;
    frame_.continued = outer.continued;
    return true;
}

std::set<StageTranslator::VariableId> StageTranslator::guess_changed(
    const check::Stmt& stmt) const {
    AssignedSymbols assigned;
    assigned.visit(stmt);
    std::set<VariableId> out;
    for (const check::Symbol* symbol : assigned.symbols) {
        const auto found = frame_.variables.find(symbol);
        if (found != frame_.variables.end() && found->second < variables_.size()) {
            out.insert(found->second);
        }
    }
    if (assigned.returns) out.insert({frame_.result, frame_.returned});
    return out;
}

void StageTranslator::run_loop(const check::Stmt& stmt) {
    ValueId guard = live_;
    bool certain = true;  // the first iteration runs wherever the loop is reached
    if (stmt.expr != nullptr && !stmt.test_last) {
        const ValueId test = scalar(*stmt.expr);
        certain = emit_.is_true(test);
        guard = emit_.logical_and(live_, test);
    }
    std::set<VariableId> changed = guess_changed(stmt);
    const Attempt start = attempt();
    for (;;) {
        RealLoop made = make_loop(stmt, guard, changed);
        bool complete = true;
        for (const auto& item : made.changes) {
            if (changed.insert(item.first).second) complete = false;
        }
        if (gave_up_) return rollback_code(start);
        if (complete) return finish_loop(stmt, made, guard, certain);
        rollback(start);
    }
}

/// Adds to the tests that hold in this iteration on which side of its start the counter is.
void StageTranslator::push_start_test(const check::Stmt& stmt) {
    const check::Symbol* counter = steady_counter(stmt);
    if (counter == nullptr) return;
    const auto found = frame_.variables.find(counter);
    if (found == frame_.variables.end()) return;
    const ValueId now = variables_[found->second].value[0];
    if (emit_.instr(now).op != ir::Op::kLoopVar) return;
    const ir::Op side = stmt.step->op == ir::Op::kAdd ? ir::Op::kGe : ir::Op::kLe;
    tests_.push_back(emit_.binary(side, now, emit_.instr(now).args[1]));
}

/// Makes one attempt: translates the loop up to its end, which is not emitted yet. Restores the
/// variables.
StageTranslator::RealLoop StageTranslator::make_loop(const check::Stmt& stmt, ValueId guard,
                                                     const std::set<VariableId>& changed) {
    RealLoop made;
    // Before the loop, which starts with its variables.
    for (const VariableId id : changed) {
        Value& assigned = made.assigned_before[id];
        for (const ValueId before : variables_[id].assigned)
            assigned.push_back(assigned_by_a_trip(before, kEarlierTrip));
    }
    const ValueId zero = emit_.constant(ir::Type::kInt, 0);
    made.loop = emit_.loop(guard);
    open_.push_back({{}, variables_.size(), live_});
    outer_live_.push_back(guard);
    live_ = emit_.constant(true);
    for (const VariableId id : changed) {
        Variable v = variables_[id];
        for (ValueId& value : v.value) {
            value = emit_.loop_var(made.loop, static_cast<int32_t>(made.vars++), value);
        }
        // After a return there is no further iteration.
        if (id == frame_.returned) v.value[0] = variables_[id].value[0];
        v.assigned = made.assigned_before.at(id);
        set(id, std::move(v));
    }
    const ValueId counter = stmt.bound > 0
                                ? emit_.loop_var(made.loop, static_cast<int32_t>(made.vars), zero)
                                : ir::kNoValue;
    // The variables' initial values must precede the loop.
    const Frame outer = frame_;
    frame_.in_loop = true;
    frame_.broken = add_flag();
    frame_.continued = add_flag();
    const VariableId go = add_flag();
    const bool tested = stmt.expr != nullptr && !stmt.test_last && is_plain(*stmt.expr);
    const size_t outer_tests = tests_.size();
    if (tested) {
        tests_.push_back(scalar(*stmt.expr));
        push_start_test(stmt);
    }
    statement(*stmt.body[0]);
    tests_.resize(outer_tests);
    set_flag(frame_.continued, emit_.constant(false));
    std::vector<ValueId> pending;
    if (skip_where_exited(&pending)) {
        if (stmt.step != nullptr) expression(*stmt.step);
        set_flag(go, stmt.expr != nullptr ? scalar(*stmt.expr) : emit_.constant(true));
    }
    unwind(pending);
    made.again = flag(go);
    if (counter != ir::kNoValue) {
        made.count = emit_.binary(ir::Op::kAdd, counter, emit_.constant(ir::Type::kInt, 1));
        const ValueId limit = emit_.constant(ir::Type::kInt, static_cast<uint32_t>(stmt.bound));
        made.again = emit_.logical_and(made.again, emit_.binary(ir::Op::kLt, made.count, limit));
    }
    frame_.in_loop = outer.in_loop;
    frame_.broken = outer.broken;
    frame_.continued = outer.continued;
    outer_live_.pop_back();
    made.changes = leave();
    return made;
}

void StageTranslator::finish_loop(const check::Stmt& stmt, const RealLoop& made, ValueId guard,
                                  bool certain) {
    std::vector<ValueId> next;
    for (const auto& item : made.changes)
        next.insert(next.end(), item.second.value.begin(), item.second.value.end());
    if (made.count != ir::kNoValue) next.push_back(made.count);
    const double most = most_trips(*stage_, made.loop, made.again, next, tests_);
    if (!emit_.is_false(made.again) && stmt.bound == 0 && !(most <= check::kMaxTrips)) {
        const check::Expr* test = stmt.expr.get();
        sink_->report(test != nullptr ? test->span : stmt.span, diag::kLoopUnbounded)
            .help(
                "compare a counter with a constant or with something of known range, `min(n, 64)`; "
                "or "
                "write `@bound(n)` before the loop, which then stops after n trips");
    }
    const ValueId end = emit_.loop_end(made.loop, made.again, next);
    const ValueId ran = certain ? emit_.constant(true) : guard;
    int32_t number = 0;
    for (const auto& item : made.changes) {
        Variable v = variables_[item.first];
        for (size_t i = 0; i < v.value.size(); ++i, ++number) {
            v.value[i] = emit_.loop_result(end, number);
        }
        for (size_t i = 0; i < v.assigned.size(); ++i) {
            const ValueId by_trip = item.second.assigned[i];
            if (by_trip == made.assigned_before.at(item.first)[i]) continue;  // by none
            v.assigned[i] = always(by_trip) ? emit_.logical_or(v.assigned[i], ran)
                                            : assigned_by_a_trip(v.assigned[i], kSomeTrip);
        }
        set(item.first, std::move(v));
    }
}

}  // namespace openfab::translate

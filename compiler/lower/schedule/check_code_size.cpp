// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "compiler/lower/algorithm/constant.h"
#include "compiler/lower/schedule/apply_schedule.h"

namespace openfab::lower {

namespace {

namespace internal = Halide::Internal;

struct CodeSize {
    int64_t loops = 0;
    int64_t operations = 0;  ///< statements and expressions
};

/// Counts what code is made of, as often as it is written out, for each Func that it computes.
class CodeSizes : public internal::IRGraphVisitor {
  public:
    /// `unrolled`: loops that will be written out, and are not yet.
    explicit CodeSizes(std::vector<LoopNames> unrolled = {}) : unrolled_(std::move(unrolled)) {}

    CodeSize all;
    std::map<std::string, CodeSize> by_func;  ///< Halide's names; what is computed for none: ""

    void count(const internal::Stmt& body) { include(body); }

  private:
    using internal::IRGraphVisitor::visit;

    CodeSize& current() { return by_func[producers_.empty() ? "" : producers_.back()]; }

    // What is shared is visited again: in code it is there twice.
    void include(const Halide::Expr& e) override { add(e.get()); }
    void include(const internal::Stmt& s) override { add(s.get()); }
    void add(const internal::IRNode* node) {
        count_node();
        node->accept(this);
    }
    void count_node() {
        all.operations += copies_;
        current().operations += copies_;
    }

    // One after the other: they are nested by the thousand.
    template <typename Node, typename First>
    void walk_chain(const Node* op, First Node::*first, internal::Stmt Node::*rest) {
        note(op);
        include(op->*first);
        while (const auto* next = (op->*rest).template as<Node>()) {
            op = next;
            count_node();
            note(op);
            include(op->*first);
        }
        include(op->*rest);
    }
    void visit(const internal::LetStmt* op) override {
        walk_chain(op, &internal::LetStmt::value, &internal::LetStmt::body);
    }
    // Lengths of loops depend on few of them, whose names are different.
    void note(const internal::LetStmt* op) {
        if (!unrolled_.empty() && op->value.type() == Halide::Int(32))
            ranges_.push(op->name, internal::find_constant_bounds(op->value, ranges_));
    }
    void note(const internal::Block* /*op*/) {}
    void visit(const internal::Block* op) override {
        walk_chain(op, &internal::Block::first, &internal::Block::rest);
    }

    void visit(const internal::For* op) override {
        const int64_t copies = copies_;
        if (const std::optional<int64_t> steps = steps_written_out(*op)) {
            copies_ = std::min(copies * *steps, kMostCopies);
        } else {
            all.loops += copies;
            current().loops += copies;
        }
        if (!unrolled_.empty()) {
            const Halide::Expr last = internal::simplify(op->min + op->extent - 1);
            ranges_.push(op->name, {internal::find_constant_bounds(op->min, ranges_).min,
                                    internal::find_constant_bounds(last, ranges_).max});
        }
        IRGraphVisitor::visit(op);
        copies_ = copies;
    }

    /// Returns how often what is in a loop will stand there; nothing where it stays a loop. Of those
    /// whose length is not constant Halide writes out as many steps as there may be.
    std::optional<int64_t> steps_written_out(const internal::For& op) const {
        const bool is_unrolled =
            std::any_of(unrolled_.begin(), unrolled_.end(),
                        [&](const LoopNames& names) { return names.has(op.name); });
        if (!is_unrolled) return std::nullopt;
        const Halide::Expr most =
            internal::find_constant_bound(op.extent, internal::Direction::Upper, ranges_);
        const std::optional<int64_t> steps = integer_constant(most);
        if (!steps) return std::nullopt;
        return std::max<int64_t>(*steps, 0);
    }

    void visit(const internal::ProducerConsumer* op) override {
        if (!op->is_producer) return IRGraphVisitor::visit(op);
        producers_.push_back(op->name);
        IRGraphVisitor::visit(op);
        producers_.pop_back();
    }

    // More than there can be, and sums of it are numbers.
    static constexpr int64_t kMostCopies = 1'000'000'000;

    std::vector<LoopNames> unrolled_;
    internal::Scope<internal::Interval> ranges_;  ///< of variables, where there are such loops
    int64_t copies_ = 1;                          ///< of the current statement
    std::vector<std::string> producers_;          ///< around it, outermost first
};

/// Returns the fault of a limit: at the Func that has most of it, of those that a line names.
schedule::Fault fault_of_size(const schedule::Schedule& schedule, const ScheduledKernel& kernel,
                              CodeSizes* sizes, int64_t CodeSize::*part, const char* what,
                              int64_t limit) {
    const ScheduledFunc* largest = nullptr;
    const auto size = [&](const ScheduledFunc& f) { return sizes->by_func[f.func.name()].*part; };
    for (const ScheduledFunc& func : kernel.funcs()) {
        if (func.placed_by() && (largest == nullptr || size(func) > size(*largest)))
            largest = &func;
    }
    return schedule::fault_at(
        largest != nullptr ? *largest->placed_by() : schedule::start_of(schedule),
        fmt::format("this schedule writes out {} {}{}; the limit is {}", sizes->all.*part, what,
                    largest != nullptr ? fmt::format(", most of them for `{}`", largest->name) : "",
                    limit),
        "unroll less, split by a factor that divides, or compute at an outer loop what is copied");
}

// Copies get smaller where an index that is a number decides what they compute.
constexpr int64_t kTimesBefore = 2;

/// Finds whether code is larger than the limits, of which it may have `times` as much.
std::optional<schedule::Fault> check_sizes(const schedule::Schedule& schedule,
                                           const ScheduledKernel& kernel,
                                           const Halide::Module& module, CodeSizes sizes,
                                           int64_t times) {
    for (const internal::LoweredFunc& function : module.functions())
        sizes.count(function.body);
    if (sizes.all.loops > times * kMostLoops)
        return fault_of_size(schedule, kernel, &sizes, &CodeSize::loops, "loops", kMostLoops);
    if (sizes.all.operations > times * kMostOperations) {
        return fault_of_size(schedule, kernel, &sizes, &CodeSize::operations, "operations",
                             kMostOperations);
    }
    return std::nullopt;
}

}  // namespace

std::optional<schedule::Fault> check_copies(const schedule::Schedule& schedule,
                                            const ScheduledKernel& kernel,
                                            const Halide::Module& module) {
    return check_sizes(schedule, kernel, module, CodeSizes(kernel.unrolled()), kTimesBefore);
}

std::optional<schedule::Fault> check_code_size(const schedule::Schedule& schedule,
                                               const ScheduledKernel& kernel,
                                               const Halide::Module& module) {
    return check_sizes(schedule, kernel, module, CodeSizes(), 1);
}

}  // namespace openfab::lower

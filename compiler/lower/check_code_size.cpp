// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <map>
#include <string>
#include <vector>

#include "compiler/lower/apply_schedule.h"

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
        ++all.operations;
        ++current().operations;
    }

    // One after the other: they are nested by the thousand.
    template <typename Node, typename First>
    void walk_chain(const Node* op, First Node::*first, internal::Stmt Node::*rest) {
        include(op->*first);
        while (const auto* next = (op->*rest).template as<Node>()) {
            op = next;
            count_node();
            include(op->*first);
        }
        include(op->*rest);
    }
    void visit(const internal::LetStmt* op) override {
        walk_chain(op, &internal::LetStmt::value, &internal::LetStmt::body);
    }
    void visit(const internal::Block* op) override {
        walk_chain(op, &internal::Block::first, &internal::Block::rest);
    }

    void visit(const internal::For* op) override {
        ++all.loops;
        ++current().loops;
        IRGraphVisitor::visit(op);
    }

    void visit(const internal::ProducerConsumer* op) override {
        if (!op->is_producer) return IRGraphVisitor::visit(op);
        producers_.push_back(op->name);
        IRGraphVisitor::visit(op);
        producers_.pop_back();
    }

    std::vector<std::string> producers_;  ///< around the current statement, outermost first
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

}  // namespace

std::optional<schedule::Fault> check_code_size(const schedule::Schedule& schedule,
                                               const ScheduledKernel& kernel,
                                               const Halide::Module& module) {
    CodeSizes sizes;
    for (const internal::LoweredFunc& function : module.functions())
        sizes.count(function.body);
    if (sizes.all.loops > kMostLoops)
        return fault_of_size(schedule, kernel, &sizes, &CodeSize::loops, "loops", kMostLoops);
    if (sizes.all.operations > kMostOperations) {
        return fault_of_size(schedule, kernel, &sizes, &CodeSize::operations, "operations",
                             kMostOperations);
    }
    return std::nullopt;
}

}  // namespace openfab::lower

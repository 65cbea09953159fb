// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "compiler/lower/schedule/apply_schedule.h"

namespace openfab::lower {

namespace {

namespace internal = Halide::Internal;

/// The size of expressions as Halide walks them: as trees, with what is inline in the place of each
/// call. Shared parts are walked once here, and counted each time.
class TreeSizes : public internal::IRGraphVisitor {
  public:
    explicit TreeSizes(const ScheduledKernel& kernel) {
        for (const ScheduledFunc& func : kernel.funcs())
            funcs_[func.func.name()] = &func;
    }

    /// Returns the operations of all definitions of a Func.
    double of(const ScheduledFunc& func) {
        const auto known = sizes_.find(&func);
        if (known != sizes_.end()) return known->second;
        const internal::Function function = func.func.function();
        const double before = count_;
        count_ = 0;
        for (const Halide::Expr& value : function.values())
            include(value);
        for (const internal::Definition& update : function.updates()) {
            for (const Halide::Expr& value : update.values())
                include(value);
        }
        const double size = count_;
        count_ = before;
        sizes_[&func] = size;
        return size;
    }

  private:
    using internal::IRGraphVisitor::visit;

    void include(const Halide::Expr& e) override {
        const auto known = nodes_.find(e.get());
        if (known != nodes_.end()) {
            count_ += known->second;
            return;
        }
        const double before = count_;
        count_ += 1;
        e.accept(this);
        nodes_[e.get()] = count_ - before;
    }

    void visit(const internal::Call* op) override {
        IRGraphVisitor::visit(op);
        const auto called = funcs_.find(op->name);
        if (op->call_type != internal::Call::Halide || called == funcs_.end()) return;
        if (called->second->is_inline() && !called->second->is_reduction())
            count_ += of(*called->second);
    }

    std::map<std::string, const ScheduledFunc*> funcs_;
    std::map<const ScheduledFunc*, double> sizes_;
    std::map<const internal::IRNode*, double> nodes_;
    double count_ = 0;
};

}  // namespace

std::optional<schedule::Fault> check_inlining(const schedule::Schedule& schedule,
                                              const ScheduledKernel& kernel) {
    TreeSizes sizes(kernel);
    for (const ScheduledFunc& func : kernel.funcs()) {
        if (func.is_extern() || func.is_inline() || sizes.of(func) <= kMostInlined) continue;
        // The largest part of it that is inline.
        const ScheduledFunc* largest = nullptr;
        for (const std::set<size_t>& calls : func.calls) {
            for (const size_t call : calls) {
                const ScheduledFunc& part = kernel.funcs()[call];
                const bool is_part = part.is_listed && part.is_inline() && !part.is_reduction();
                if (is_part && (largest == nullptr || sizes.of(part) > sizes.of(*largest)))
                    largest = &part;
            }
        }
        // What a kernel computes without any schedule is its own affair.
        if (largest == nullptr) continue;
        const auto placed = largest->placed_by() ? largest->placed_by() : func.last_word;
        return schedule::fault_at(
            placed.value_or(schedule::start_of(schedule)),
            fmt::format("`{}` is part of `{}`, which has {:.0f} million operations by "
                        "that; the limit is {:.0f}",
                        largest->name, func.name, sizes.of(func) * 1e-6, kMostInlined * 1e-6),
            fmt::format("place it, as in `{}.compute_at(func, var)`", largest->name));
    }
    return std::nullopt;
}

}  // namespace openfab::lower

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/schedule/hoist_storage.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "compiler/lower/schedule/kernel_memory.h"

namespace openfab::lower {

namespace {

namespace internal = Halide::Internal;
using Halide::Expr;
using internal::Stmt;

struct Memory {
    Halide::Type type;
    Halide::MemoryType kind = Halide::MemoryType::Auto;
    std::vector<Expr> extents;
};

/// A Func that is stored outside where it is computed.
struct Outer {
    std::string name;  ///< Halide's
    /// The loops between, by the beginning and the end of their names in lowered code.
    std::vector<std::pair<std::string, std::string>> loops;
    int32_t inside = 0;  ///< in how many of them the pass is
    size_t defined = 0;  ///< variables around the outermost
    /// Memory to be taken there, by name: one for each value of a tuple.
    std::map<std::string, Memory> found;

    bool is_between(const std::string& loop) const {
        return std::any_of(loops.begin(), loops.end(), [&](const auto& ends) {
            return loop.starts_with(ends.first) && loop.ends_with(ends.second);
        });
    }
};

class StorageHoister : public internal::IRMutator {
  public:
    explicit StorageHoister(const ScheduledKernel& kernel) {
        for (size_t k = 0; k < kernel.funcs().size(); ++k) {
            const ScheduledFunc& func = kernel.funcs()[k];
            if (!func.store) continue;
            Outer outer{func.func.name(), {}, 0, {}};
            const std::vector<LoopSite> path = kernel.path(k);
            for (size_t s = kernel.loops_to_storage(k); s < path.size(); ++s) {
                outer.loops.emplace_back(kernel.funcs()[path[s].func].func.name() + ".",
                                         "." + path[s].loop->var.name());
            }
            if (!outer.loops.empty()) outers_.push_back(std::move(outer));
        }
    }

  private:
    using internal::IRMutator::visit;

    Stmt visit(const internal::For* op) override {
        std::vector<Outer*> entered;
        for (Outer& outer : outers_) {
            if (!outer.is_between(op->name)) continue;
            if (outer.inside++ == 0) outer.defined = defined_.size();
            entered.push_back(&outer);
        }
        defined_.push_back(op->name);
        Stmt out = IRMutator::visit(op);
        defined_.pop_back();
        for (Outer* outer : entered) {
            if (--outer->inside > 0) continue;
            for (const auto& [name, memory] : outer->found) {
                out = internal::Allocate::make(name, memory.type, memory.kind, memory.extents,
                                               internal::const_true(), out);
            }
            outer->found.clear();
        }
        return out;
    }

    // One after the other: they are nested by the thousand.
    Stmt visit(const internal::LetStmt* op) override {
        std::vector<const internal::LetStmt*> lets;
        for (; op != nullptr; op = op->body.as<internal::LetStmt>()) {
            lets.push_back(op);
            defined_.push_back(op->name);
        }
        Stmt out = mutate(lets.back()->body);
        for (auto let = lets.rbegin(); let != lets.rend(); ++let) {
            defined_.pop_back();
            out = out.same_as((*let)->body)
                      ? Stmt(*let)
                      : internal::LetStmt::make((*let)->name, (*let)->value, out);
        }
        return out;
    }

    Stmt visit(const internal::Allocate* op) override {
        const auto outer = std::find_if(outers_.begin(), outers_.end(), [&](const Outer& o) {
            return o.inside > 0 && (op->name == o.name || op->name.starts_with(o.name + "."));
        });
        // What is on the stack is the function's.
        if (outer == outers_.end() || is_on_stack(*op) || varies(*op, outer->defined))
            return IRMutator::visit(op);
        const auto [memory, fresh] =
            outer->found.try_emplace(op->name, Memory{op->type, op->memory_type, op->extents});
        std::vector<Expr>& extents = memory->second.extents;
        for (size_t d = 0; d < extents.size() && !fresh; ++d)
            extents[d] = internal::simplify(Halide::max(extents[d], op->extents[d]));
        moved_.push_back(op->name);
        Stmt out = mutate(op->body);
        moved_.pop_back();
        return out;
    }

    Stmt visit(const internal::Free* op) override {
        const bool moved = std::find(moved_.begin(), moved_.end(), op->name) != moved_.end();
        return moved ? internal::Evaluate::make(0) : Stmt(op);
    }

    /// Returns whether its size depends on variables that are defined after so many.
    bool varies(const internal::Allocate& op, size_t defined) const {
        return std::any_of(defined_.begin() + static_cast<std::ptrdiff_t>(defined), defined_.end(),
                           [&](const std::string& name) {
                               return std::any_of(op.extents.begin(), op.extents.end(),
                                                  [&](const Expr& extent) {
                                                      return internal::expr_uses_var(extent, name);
                                                  });
                           });
    }

    std::vector<Outer> outers_;
    std::vector<std::string> defined_;  ///< variables around the current statement, outermost first
    std::vector<std::string> moved_;    ///< around the current statement
};

}  // namespace

internal::IRMutator* make_storage_hoister(const ScheduledKernel& kernel) {
    return new StorageHoister(kernel);
}

}  // namespace openfab::lower

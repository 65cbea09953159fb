// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/kernel_memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "compiler/lower/lowered_ranges.h"

namespace openfab::lower {

namespace {

namespace internal = Halide::Internal;
using Halide::Expr;

/// Adds up what is allocated at a time.
class StorageWalk : public RangeWalk {
  public:
    using RangeWalk::RangeWalk;

    int64_t peak = 0;
    int64_t stack = 0;  ///< of all functions
    std::vector<FuncStorage> all;
    std::string unbounded;

  private:
    void begin(bool /*last*/) override {
        peak = 0;
        stack = 0;
        all.clear();
        unbounded.clear();
    }

    /// What a function allocates is alive while the functions run that its parallel loops became.
    void enter(const internal::LoweredFunc& function) override {
        live_ = most_ = 0;
        RangeWalk::enter(function);
        peak += most_;
    }

    using RangeWalk::visit;

    void visit(const internal::Allocate* op) override {
        const int64_t bytes = size_of(*op);
        if (is_on_stack(*op)) stack += bytes;
        all.push_back({op->name, bytes});
        live_ += bytes;
        most_ = std::max(most_, live_);
        op->body.accept(this);
        live_ -= bytes;
    }

    /// Halide takes what is small from the stack, too.
    static bool is_on_stack(const internal::Allocate& op) {
        const int32_t constant = op.constant_allocation_size();
        return op.memory_type == Halide::MemoryType::Stack ||
               (op.memory_type == Halide::MemoryType::Auto && constant > 0 &&
                internal::can_allocation_fit_on_stack(int64_t{constant} * op.type.bytes()));
    }

    int64_t size_of(const internal::Allocate& op) {
        constexpr int64_t kMost = std::numeric_limits<int64_t>::max() / 4096;
        int64_t bytes = int64_t{op.type.bytes()};
        for (size_t d = 0; d < op.extents.size(); ++d) {
            const Expr most =
                internal::find_constant_bound(internal::simplify(queries_.resolve(op.extents[d])),
                                              internal::Direction::Upper, scope_);
            const int64_t* value = most.defined() ? internal::as_const_int(most) : nullptr;
            const int64_t factor = std::max<int64_t>(value != nullptr ? *value : whole(op, d), 0);
            bytes = factor > 0 && bytes > kMost / factor ? kMost : bytes * factor;
        }
        return bytes;
    }

    /// Where the extent of a dimension is not seen through, it is at most that of the result, which
    /// everything is computed for place by place; what is no Func of the kernel is not bounded so.
    int64_t whole(const internal::Allocate& op, size_t dimension) {
        const ScheduledFunc* func = func_of_storage(kernel_, op.name);
        if (func != nullptr) {
            const auto& dims = func->func.function().schedule().storage_dims();
            if (dimension < dims.size()) return most_extent(*func, dims[dimension].var);
        }
        unbounded = op.name;
        return 0;
    }

    /// Returns the bound of a Func's var, or of the result's var of that name; else the places.
    int64_t most_extent(const ScheduledFunc& func, const std::string& var) const {
        std::vector<const ScheduledFunc*> with_bounds = {&func};
        for (const ScheduledFunc& each : kernel_.funcs()) {
            if (each.is_result) with_bounds.push_back(&each);
        }
        for (const ScheduledFunc* each : with_bounds) {
            if (const std::optional<int64_t> extent = constant_extent(*each, var)) return *extent;
        }
        return places_;
    }

    int64_t live_ = 0, most_ = 0;
};

}  // namespace

const ScheduledFunc* func_of_storage(const ScheduledKernel& kernel, const std::string& name) {
    for (const ScheduledFunc& func : kernel.funcs()) {
        const std::string& own = func.func.name();
        if (name == own || name.starts_with(own + ".")) return &func;
    }
    return nullptr;
}

std::optional<KernelMemory> measure_memory(const ScheduledKernel& kernel,
                                           const Halide::Module& module, int64_t places,
                                           std::string* unbounded) {
    StorageWalk walk(kernel, places);
    walk.walk(module);
    if (walk.unbounded.empty()) return KernelMemory{walk.peak, walk.stack};
    if (unbounded != nullptr) *unbounded = walk.unbounded;
    return std::nullopt;
}

std::vector<FuncStorage> list_storage(const ScheduledKernel& kernel, const Halide::Module& module,
                                      int64_t places) {
    StorageWalk walk(kernel, places);
    walk.walk(module);
    return std::move(walk.all);
}

}  // namespace openfab::lower

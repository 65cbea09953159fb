// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/schedule/print_loops.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

namespace openfab::lower {

namespace {

class LoopPrinter {
  public:
    LoopPrinter(const ScheduledKernel& kernel, const std::vector<FuncStorage>& storage)
        : kernel_(kernel), storage_(storage) {}

    std::string run() {
        produce_all(nullptr, 0);
        for (const ScheduledFunc& func : kernel_.funcs()) {
            if (func.is_listed && func.is_inline())
                line(0, fmt::format("{}: computed where it is read", func.name));
        }
        return std::move(out_);
    }

  private:
    void line(size_t depth, const std::string& text) {
        out_ += std::string(2 * depth, ' ') + text + '\n';
    }

    static bool is_here(const Placement& placement, const Loop* loop, size_t func) {
        if (loop == nullptr) return placement.level == Placement::Level::kRoot;
        return placement.level == Placement::Level::kAt && placement.func == func &&
               placement.var == loop->name;
    }

    /// Prints what is stored, then what is computed, inside a loop of `func`; producers first.
    void produce_all(const Loop* loop, size_t depth, size_t func = 0, size_t definition = 0) {
        const std::vector<ScheduledFunc>& funcs = kernel_.funcs();
        for (size_t k = funcs.size(); k-- > 0;) {
            const Placement& store = funcs[k].store ? *funcs[k].store : funcs[k].compute;
            if (is_here(store, loop, func) && is_needed(k, loop, func, definition))
                stored(k, depth);
        }
        for (size_t k = funcs.size(); k-- > 0;) {
            if (is_here(funcs[k].compute, loop, func) && is_needed(k, loop, func, definition))
                produce(k, depth);
        }
    }

    /// A loop of that name may be in several definitions: a Func is computed in the one that reads
    /// it.
    bool is_needed(size_t k, const Loop* loop, size_t func, size_t definition) const {
        return loop == nullptr || kernel_.definitions_that_need(func, k).contains(definition);
    }

    void stored(size_t k, size_t depth) {
        const ScheduledFunc& func = kernel_.funcs()[k];
        if (func.is_result) return;
        // Each value of a Func is an allocation; where Halide wrote a loop twice, of two sizes.
        std::map<std::string, int64_t> sizes;
        for (const FuncStorage& each : storage_) {
            const std::string& own = func.func.name();
            if (each.func == own || each.func.starts_with(own + "."))
                sizes[each.func] = std::max(sizes[each.func], each.bytes);
        }
        int64_t bytes = 0;
        for (const auto& [name, size] : sizes)
            bytes += size;
        line(depth, bytes > 0 ? fmt::format("store {}: {} bytes", func.name, bytes)
                              : fmt::format("store {}", func.name));
    }

    void produce(size_t k, size_t depth) {
        const ScheduledFunc& func = kernel_.funcs()[k];
        if (func.is_extern()) {
            line(depth, fmt::format("{}: computed by the runtime", func.name));
            return;
        }
        for (size_t d = 0; d < func.definitions.size(); ++d) {
            const std::vector<LoopNest>& nests = func.definitions[d];
            const std::string what =
                d == 0 ? func.name : fmt::format("{}, update {}", func.name, d - 1);
            for (size_t s = nests.size(); s-- > 0;) {
                line(depth, nests[s].condition.empty()
                                ? fmt::format("{}{}:", what, nests.size() > 1 ? " else" : "")
                                : fmt::format("{} if {}:", what, nests[s].condition));
                loops(k, d, nests[s], depth + 1);
            }
        }
    }

    void loops(size_t k, size_t definition, const LoopNest& nest, size_t depth) {
        constexpr std::array<const char*, 4> kKinds = {"for", "vectorized", "unrolled", "parallel"};
        for (auto loop = nest.loops.rbegin(); loop != nest.loops.rend(); ++loop) {
            line(depth++,
                 fmt::format("{} {}{}:", kKinds[static_cast<size_t>(loop->kind)], loop->name,
                             loop->extent ? fmt::format(" in {}", *loop->extent) : std::string()));
            produce_all(&*loop, depth, k, definition);
        }
        line(depth, fmt::format("{} = …", kernel_.funcs()[k].name));
    }

    const ScheduledKernel& kernel_;
    const std::vector<FuncStorage>& storage_;
    std::string out_;
};

}  // namespace

std::string print_loops(const ScheduledKernel& kernel, const std::vector<FuncStorage>& storage) {
    return LoopPrinter(kernel, storage).run();
}

}  // namespace openfab::lower

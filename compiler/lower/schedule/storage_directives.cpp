// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Directives that say where a Func is computed and stored, and how its storage is laid out.
#include <fmt/format.h>

#include <utility>
#include <vector>

#include "compiler/lower/schedule/directive_chain.h"
#include "compiler/schedule/rules.h"

namespace openfab::lower {

bool DirectiveChain::is_placed_by_kernel() {
    if (!func().is_result) return true;
    return fail(current_->name,
                fmt::format("`{}` is the kernel's result and stays outermost", func().name));
}

bool DirectiveChain::place(Placement::Level level, Placement* out) {
    *out = {level, 0, {}, current_->name};
    if (level != Placement::Level::kAt) return true;
    if (!find_func(arg(0), &out->func)) return false;
    const ScheduledFunc& at = kernel_->funcs()[out->func];
    if (at.is_extern()) return fail_loopless(arg(0), at);
    if (out->func == target_) return fail(arg(0), "a func is computed inside another");
    out->var = arg(1).text;
    // The loop may be one that a later line makes: check_placements looks for it.
    return true;
}

bool DirectiveChain::compute_at() {
    if (!is_placed_by_kernel() || !place(Placement::Level::kAt, &func().compute)) return false;
    return true;
}

bool DirectiveChain::compute_root() {
    return is_placed_by_kernel() && place(Placement::Level::kRoot, &func().compute);
}

bool DirectiveChain::compute_inline() {
    if (!is_placed_by_kernel()) return false;
    if (func().is_extern() || func().is_read_by_extern) {
        return fail(current_->name,
                    fmt::format("`{}` is {} by the runtime: it has to be stored", func().name,
                                func().is_extern() ? "computed" : "read"),
                    "place it: compute_at, compute_root");
    }
    if (func().is_reduction())
        return fail(current_->name,
                    fmt::format("`{}` has updates: it has to be stored", func().name));
    return place(Placement::Level::kInline, &func().compute);
}

bool DirectiveChain::store_at() {
    return is_placed_by_kernel() && place(Placement::Level::kAt, &func().store.emplace());
}

bool DirectiveChain::store_root() {
    return is_placed_by_kernel() && place(Placement::Level::kRoot, &func().store.emplace());
}

bool DirectiveChain::has_own_storage() {
    if (func().is_result) {
        return fail(
            current_->name,
            fmt::format("`{}` is the kernel's result: the buffer is the caller's", func().name));
    }
    if (!func().is_extern() && !func().is_read_by_extern) return true;
    return fail(current_->name, fmt::format("the runtime {} `{}` and knows its layout",
                                            func().is_extern() ? "writes" : "reads", func().name));
}

bool DirectiveChain::storage_var(const schedule::Word& word, Halide::Var* out) {
    std::vector<std::string> names;
    for (const Halide::Var& var : func().func.args()) {
        if (var.name() == word.text) {
            *out = var;
            return true;
        }
        names.push_back(var.name());
    }
    return fail(word,
                fmt::format("the storage of `{}` has no dimension `{}`", func().name, word.text),
                schedule::near_or_all(word.text, names, "it has"));
}

bool DirectiveChain::store_in() {
    if (func().is_result) return has_own_storage();
    if (arg(0).text != "heap" && arg(0).text != "stack")
        return fail(arg(0), "expected `heap` or `stack`");
    func().has_memory = true;
    func().func.store_in(arg(0).text == "heap" ? Halide::MemoryType::Heap
                                               : Halide::MemoryType::Stack);
    return true;
}

bool DirectiveChain::reorder_storage() {
    std::vector<Halide::Var> order;
    if (!has_own_storage()) return false;
    for (const schedule::Word& word : current_->args) {
        if (!storage_var(word, &order.emplace_back())) return false;
        for (size_t k = 0; k + 1 < order.size(); ++k) {
            if (order[k].same_as(order.back()))
                return fail(word, fmt::format("`{}` is named twice", word.text));
        }
    }
    func().func.reorder_storage(order);
    return true;
}

bool DirectiveChain::align_storage() {
    Halide::Var var;
    int64_t multiple = 1;
    if (!has_own_storage() || !storage_var(arg(0), &var) ||
        !factor(arg(1), kMostFactor, &multiple)) {
        return false;
    }
    func().func.align_storage(var, static_cast<int>(multiple));
    return true;
}

bool DirectiveChain::bound_storage() {
    Halide::Var var;
    int64_t extent = 1;
    if (!has_own_storage() || !storage_var(arg(0), &var) ||
        !factor(arg(1), schedule::kMostNumber, &extent)) {
        return false;
    }
    func().func.bound_storage(var, static_cast<int>(extent));
    return true;
}

bool DirectiveChain::fold_storage() {
    Halide::Var var;
    int64_t extent = 1;
    if (!has_own_storage() || !storage_var(arg(0), &var) ||
        !factor(arg(1), schedule::kMostNumber, &extent)) {
        return false;
    }
    func().folds.push_back({var.name(), extent, current_->name});
    return true;
}

}  // namespace openfab::lower

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Directives that make and order loops.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "compiler/lower/schedule/apply_schedule.h"
#include "compiler/lower/schedule/directive_chain.h"
#include "compiler/schedule/rules.h"

namespace openfab::lower {

namespace {

using Halide::VarOrRVar;

// Splits whose factor does not divide the extent test each index: nothing outside a buffer is read
// or written.
constexpr Halide::TailStrategy kTail = Halide::TailStrategy::GuardWithIf;

}  // namespace

bool DirectiveChain::find_loop(const schedule::Word& word, Loop** out) {
    *out = nest().find(word.text);
    if (*out != nullptr) return true;
    std::vector<std::string> names;
    for (const Loop& loop : nest().loops)
        names.push_back(loop.name);
    return fail(word, fmt::format("`{}` has no var `{}`", func().name, word.text),
                schedule::near_or_all(word.text, names, "it has"));
}

bool DirectiveChain::find_serial(const schedule::Word& word, Loop** out) {
    if (!find_loop(word, out)) return false;
    constexpr std::array<const char*, 4> kHow = {"", "vectorized", "unrolled", "parallel"};
    const auto kind = static_cast<size_t>((*out)->kind);
    if (kind == 0) return true;
    return fail(word, fmt::format("`{}` is {} already", word.text, kHow[kind]));
}

bool DirectiveChain::new_name(const schedule::Word& word) {
    if (word.text.find('*') != std::string::npos || std::isdigit(word.text[0]) != 0)
        return fail(word, fmt::format("`{}` cannot name a var", word.text));
    if (!room_for_var(word)) return false;
    if (nest().names.insert(word.text).second) return true;
    return fail(word, fmt::format("`{}` has, or had, a var `{}` already", func().name, word.text));
}

bool DirectiveChain::room_for_var(const schedule::Word& word) {
    if (nest().names.size() < kMostVars) return true;
    return fail(word, fmt::format("`{}` has, or had, {} vars here, which is the limit", func().name,
                                  nest().names.size()));
}

void DirectiveChain::split_loop(Loop* loop, const std::string& outer, const std::string& inner,
                                int64_t by) {
    // A part may keep the loop's name.
    const auto part = [&](const std::string& name) {
        return name == loop->name ? loop->var : VarOrRVar(name, loop->var.is_rvar);
    };
    const VarOrRVar outer_var = part(outer);
    const VarOrRVar inner_var = part(inner);
    nest().stage.split(loop->var, outer_var, inner_var, static_cast<int>(by), kTail);
    std::optional<int64_t> trips;
    if (loop->extent) trips = (*loop->extent + by - 1) / by;
    const bool reduces = loop->reduces;
    *loop = {inner, inner_var, by, Loop::Kind::kSerial, reduces, true};
    nest().loops.insert(nest().loops.begin() + (loop - nest().loops.data()) + 1,
                        {outer, outer_var, trips, Loop::Kind::kSerial, reduces, true});
}

bool DirectiveChain::split() {
    Loop* loop = nullptr;
    int64_t by = 1;
    if (!find_serial(arg(0), &loop) || !factor(arg(3), kMostFactor, &by)) return false;
    // Lines that name the loop may mean one of its parts from now on.
    const std::string& name = arg(0).text;
    const bool keeps = arg(1).text == name;
    if ((!keeps && !new_name(arg(1))) || ((keeps || arg(2).text != name) && !new_name(arg(2)))) {
        return false;
    }
    split_loop(loop, arg(1).text, arg(2).text, by);
    return true;
}

bool DirectiveChain::tile() {
    std::array<Loop*, 2> sides{};
    std::array<int64_t, 2> by{};
    for (size_t k = 0; k < 2; ++k) {
        if (!find_serial(arg(k), &sides[k]) || !factor(arg(6 + k), kMostFactor, &by[k]))
            return false;
        if (sides[k]->reduces) return fail_order(arg(k));
    }
    if (arg(0).text == arg(1).text) return fail(arg(1), "the sides of a tile are two vars");
    for (size_t k = 2; k < 6; ++k) {
        if (!new_name(arg(k))) return false;
    }
    for (size_t k = 0; k < 2; ++k)
        split_loop(nest().find(arg(k).text), arg(2 + k).text, arg(4 + k).text, by[k]);
    return reorder_loops({arg(4).text, arg(5).text, arg(2).text, arg(3).text});
}

bool DirectiveChain::fuse() {
    Loop* inner = nullptr;
    Loop* outer = nullptr;
    if (!find_serial(arg(0), &inner) || !find_serial(arg(1), &outer)) return false;
    for (const size_t k : {0u, 1u}) {
        if (nest().find(arg(k).text)->reduces) return fail_order(arg(k));
    }
    if (inner == outer) return fail(arg(1), "one loop cannot be fused with itself");
    if (!new_name(arg(2))) return false;
    const VarOrRVar fused(arg(2).text, false);
    nest().stage.fuse(inner->var, outer->var, fused);
    std::optional<int64_t> extent;
    if (inner->extent && outer->extent) extent = *inner->extent * *outer->extent;
    const bool is_part = inner->is_part || outer->is_part;
    *inner = {arg(2).text, fused, extent, Loop::Kind::kSerial, false, is_part};
    nest().loops.erase(nest().loops.begin() + (outer - nest().loops.data()));
    return true;
}

bool DirectiveChain::fail_order(const schedule::Word& word) {
    return fail(word,
                fmt::format("`{}` runs over a reduction: in another order its result would be "
                            "another",
                            word.text),
                "its loops can be split, unrolled, and stand inside or outside others");
}

bool DirectiveChain::reorder() {
    std::vector<std::string> order;
    for (const schedule::Word& word : current_->args) {
        Loop* loop = nullptr;
        if (!find_loop(word, &loop)) return false;
        if (std::find(order.begin(), order.end(), word.text) != order.end())
            return fail(word, fmt::format("`{}` is named twice", word.text));
        order.push_back(word.text);
    }
    return reorder_loops(order);
}

bool DirectiveChain::reorder_loops(const std::vector<std::string>& order) {
    std::vector<VarOrRVar> vars;
    for (const std::string& name : order)
        vars.push_back(nest().find(name)->var);
    std::vector<Loop> loops = nest().loops;
    size_t next = 0;
    for (Loop& loop : loops) {
        if (std::find(order.begin(), order.end(), loop.name) != order.end())
            loop = *nest().find(order[next++]);
    }
    // Loops over a reduction keep their order among each other.
    const auto reductions = [](const std::vector<Loop>& of) {
        std::vector<std::string> names;
        for (const Loop& loop : of) {
            if (loop.reduces) names.push_back(loop.name);
        }
        return names;
    };
    if (reductions(loops) != reductions(nest().loops)) {
        const auto guilty =
            std::find_if(current_->args.begin(), current_->args.end(),
                         [&](const auto& word) { return nest().find(word.text)->reduces; });
        return fail_order(*guilty);
    }
    nest().loops = std::move(loops);
    nest().stage.reorder(vars);
    return true;
}

std::string DirectiveChain::made_name(const std::string& base) {
    std::string name = base;
    for (int k = 2; !nest().names.insert(name).second; ++k)
        name = fmt::format("{}{}", base, k);
    return name;
}

bool DirectiveChain::inner_part(int64_t most, const char* what, Loop** out) {
    if (!find_serial(arg(0), out)) return false;
    if (current_->args.size() == 1) {
        if ((*out)->extent || !func().is_result) return true;
        return fail(
            arg(0),
            fmt::format("the length of `{}` is known only when the kernel runs", arg(0).text),
            fmt::format("give a factor, as in `{}({}, 8)`", what, arg(0).text));
    }
    int64_t by = 1;
    if (!factor(arg(1), most, &by)) return false;
    if (!room_for_var(arg(0))) return false;
    const std::string inner = made_name(fmt::format("{}_{}", arg(0).text, what));
    // Later lines, and other versions of the loops, go on naming the loop as they did.
    split_loop(*out, arg(0).text, inner, by);
    *out = nest().find(inner);
    return true;
}

int64_t DirectiveChain::together(Loop::Kind kind) {
    int64_t out = 1;
    for (const Loop& loop : nest().loops) {
        if (loop.kind == kind) out *= loop.extent.value_or(1);
    }
    return out;
}

bool DirectiveChain::vectorize() {
    Loop* loop = nullptr;
    if (!find_loop(arg(0), &loop)) return false;
    if (loop->reduces) {
        return fail(arg(0),
                    fmt::format("`{}` runs over a reduction: its steps come one after the other",
                                arg(0).text),
                    "vectorize a var of the func");
    }
    if (!inner_part(kMostVectorLanes, "vectorize", &loop)) return false;
    loop->kind = Loop::Kind::kVector;
    if (const int64_t lanes = together(Loop::Kind::kVector); lanes > kMostVectorLanes) {
        return fail(arg(0), fmt::format("this makes vectors of {} lanes; the limit is {}", lanes,
                                        kMostVectorLanes));
    }
    if (!func().is_result && loop->is_part && loop->extent) {
        func().part_vectors.push_back({definition_, loop->name, current_->name});
    } else {
        nest().stage.vectorize(loop->var);
    }
    return true;
}

bool DirectiveChain::unroll() {
    Loop* loop = nullptr;
    if (!inner_part(kMostUnrolled, "unroll", &loop)) return false;
    loop->kind = Loop::Kind::kUnrolled;
    if (const int64_t copies = together(Loop::Kind::kUnrolled); copies > kMostUnrolled) {
        return fail(arg(0), fmt::format("this makes {} copies of the code; the limit is {}", copies,
                                        kMostUnrolled));
    }
    return true;
}

bool DirectiveChain::parallel() {
    Loop* loop = nullptr;
    if (!find_serial(arg(0), &loop)) return false;
    if (loop->reduces) {
        return fail(arg(0),
                    fmt::format("`{}` runs over a reduction: its steps come one after the other",
                                arg(0).text),
                    "make a var of the func parallel");
    }
    loop->kind = Loop::Kind::kParallel;
    nest().stage.parallel(loop->var);
    return true;
}

bool DirectiveChain::update() {
    const size_t number = current_->args.empty() ? 0 : static_cast<size_t>(number_of(arg(0)));
    const size_t updates = func().definitions.size() - 1;
    if (updates == 0) {
        return fail(current_->name, fmt::format("`{}` has no loop to update", func().name));
    }
    if (number >= updates) {
        return fail(arg(0), fmt::format("`{}` has {} update{}, counted from 0", func().name,
                                        updates, updates == 1 ? "" : "s"));
    }
    definition_ = number + 1;
    specialization_ = 0;
    return true;
}

bool DirectiveChain::specialize() {
    const schedule::Word& var = arg(0);
    if (specialization_ != 0)
        return fail(current_->name, "a specialization is not specialized again");
    if (func().definitions[0].size() > kMostSpecializations) {
        return fail(current_->name, fmt::format("`{}` has {} specializations, which is the limit",
                                                func().name, kMostSpecializations));
    }
    if (!func().is_result || definition_ != 0) {
        return fail(current_->name, fmt::format("`{}` is not a result of the kernel: no var of "
                                                "it has a length that is known before",
                                                func().name));
    }
    const std::optional<Halide::Expr> extent = kernel_->result_extent(var.text);
    if (!extent) {
        std::vector<std::string> names;
        for (const Halide::Var& each : func().func.args())
            names.push_back(each.name());
        return fail(var, fmt::format("the kernel's result has no var `{}`", var.text),
                    schedule::near_or_all(var.text, names, "it has"));
    }
    Halide::Expr left = *extent;
    std::string text = var.text;
    for (size_t k = 1; k < current_->args.size(); ++k)
        text += " " + arg(k).text;
    if (arg(1).text == "%") {
        int64_t by = 1;
        if (!factor(arg(2), kMostFactor, &by)) return false;
        left = left % static_cast<int>(by);
    }
    const Halide::Expr right = static_cast<int>(number_of(current_->args.back()));
    const std::string& sign = arg(current_->args.size() - 2).text;
    const Halide::Expr condition = sign == "<"    ? left < right
                                   : sign == ">"  ? left > right
                                   : sign == "<=" ? left <= right
                                   : sign == ">=" ? left >= right
                                   : sign == "==" ? left == right
                                                  : left != right;
    LoopNest special = nest();
    special.stage = nest().stage.specialize(condition);
    special.condition = text;
    std::vector<LoopNest>& nests = func().definitions[0];
    nests.push_back(std::move(special));
    specialization_ = nests.size() - 1;
    return true;
}

bool DirectiveChain::prefetch() {
    size_t read = 0;
    Loop* loop = nullptr;
    int64_t distance = 0;
    if (!find_func(arg(0), &read) || !find_loop(arg(1), &loop) ||
        !factor(arg(2), kMostFactor, &distance)) {
        return false;
    }
    if (!func().calls[definition_].contains(read)) {
        return fail(arg(0), fmt::format("`{}` does not read `{}`", func().name, arg(0).text));
    }
    if (loop->kind == Loop::Kind::kVector)
        return fail(arg(1), fmt::format("`{}` is vectorized: it has no next step", arg(1).text));
    func().prefetches.push_back({read, arg(1).text, current_->name});
    nest().stage.prefetch(kernel_->funcs()[read].func, loop->var, loop->var,
                          static_cast<int>(distance));
    return true;
}

}  // namespace openfab::lower

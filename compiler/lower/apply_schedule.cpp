// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/apply_schedule.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "compiler/schedule/rules.h"

namespace openfab::lower {

namespace {

using Halide::VarOrRVar;

// Splits whose factor does not divide the extent test each index: nothing outside a buffer is read
// or written.
constexpr Halide::TailStrategy kTail = Halide::TailStrategy::GuardWithIf;
constexpr int64_t kMostFactor = 4096;

bool names_func(const schedule::Line& line, std::string_view func) {
    const std::string& pattern = line.func.text;
    const size_t star = pattern.find('*');
    return star == std::string::npos ? func == pattern : func.starts_with(pattern.substr(0, star));
}

int64_t number_of(const schedule::Word& word) {
    int64_t out = 0;
    std::from_chars(word.text.data(), word.text.data() + word.text.size(), out);
    return out;
}

/// One line applied to one Func.
class DirectiveChain {
  public:
    DirectiveChain(ScheduledKernel* kernel, size_t target, const schedule::Line& line)
        : kernel_(kernel), target_(target), line_(line) {}

    std::optional<schedule::Fault> run() {
        func().last_word = line_.func;
        for (const schedule::Directive& directive : line_.directives) {
            current_ = &directive;
            if (!apply()) return fault_;
        }
        return std::nullopt;
    }

  private:
    struct Handler {
        const char* name;
        bool (DirectiveChain::*run)();
        bool needs_loops;  ///< else it is about the Func as a whole
    };

    bool apply() {
        static constexpr Handler kHandlers[] = {
            {"split", &DirectiveChain::split, true},
            {"tile", &DirectiveChain::tile, true},
            {"fuse", &DirectiveChain::fuse, true},
            {"reorder", &DirectiveChain::reorder, true},
            {"unroll", &DirectiveChain::unroll, true},
            {"vectorize", &DirectiveChain::vectorize, true},
            {"parallel", &DirectiveChain::parallel, true},
            {"specialize", &DirectiveChain::specialize, true},
            {"prefetch", &DirectiveChain::prefetch, true},
            {"update", &DirectiveChain::update, true},
            {"compute_at", &DirectiveChain::compute_at, false},
            {"compute_root", &DirectiveChain::compute_root, false},
            {"compute_inline", &DirectiveChain::compute_inline, false},
            {"store_at", &DirectiveChain::store_at, false},
            {"store_root", &DirectiveChain::store_root, false},
            {"store_in", &DirectiveChain::store_in, false},
            {"reorder_storage", &DirectiveChain::reorder_storage, false},
            {"align_storage", &DirectiveChain::align_storage, false},
            {"bound_storage", &DirectiveChain::bound_storage, false},
            {"fold_storage", &DirectiveChain::fold_storage, false},
        };
        const auto* handler =
            std::find_if(std::begin(kHandlers), std::end(kHandlers),
                         [&](const Handler& h) { return current_->name.text == h.name; });
        if (handler->needs_loops && func().is_extern())
            return fail_loopless(current_->name, func());
        if (!handler->needs_loops && definition_ != 0)
            return fail(current_->name,
                        "this is about the whole func: it belongs before `update()`");
        return (this->*handler->run)();
    }

    ScheduledFunc& func() { return kernel_->funcs()[target_]; }
    LoopNest& nest() { return func().definitions[definition_][specialization_]; }
    const schedule::Word& arg(size_t k) const { return current_->args[k]; }

    bool fail(const schedule::Word& word, std::string message, std::string help = {}) {
        fault_ = schedule::fault_at(word, std::move(message), std::move(help));
        return false;
    }

    bool fail_loopless(const schedule::Word& word, const ScheduledFunc& func) {
        return fail(
            word,
            fmt::format("`{}` is computed by the runtime: it has no loops of its own", func.name),
            "it can be placed: compute_at, compute_root, store_at, store_root");
    }

    bool find_loop(const schedule::Word& word, Loop** out) {
        *out = nest().find(word.text);
        if (*out != nullptr) return true;
        std::vector<std::string> names;
        for (const Loop& loop : nest().loops)
            names.push_back(loop.name);
        return fail(word, fmt::format("`{}` has no var `{}`", func().name, word.text),
                    schedule::near_or_all(word.text, names, "it has"));
    }

    /// Finds a loop that no directive has taken yet: the others have no parts.
    bool find_serial(const schedule::Word& word, Loop** out) {
        if (!find_loop(word, out)) return false;
        constexpr std::array<const char*, 4> kHow = {"", "vectorized", "unrolled", "parallel"};
        const auto kind = static_cast<size_t>((*out)->kind);
        if (kind == 0) return true;
        return fail(word, fmt::format("`{}` is {} already", word.text, kHow[kind]));
    }

    bool new_name(const schedule::Word& word) {
        if (word.text.find('*') != std::string::npos || std::isdigit(word.text[0]) != 0)
            return fail(word, fmt::format("`{}` cannot name a var", word.text));
        if (!room_for_var(word)) return false;
        if (nest().names.insert(word.text).second) return true;
        return fail(word,
                    fmt::format("`{}` has, or had, a var `{}` already", func().name, word.text));
    }

    /// Halide's time grows with the third power of splits in splits.
    bool room_for_var(const schedule::Word& word) {
        if (nest().names.size() < kMostVars) return true;
        return fail(word, fmt::format("`{}` has, or had, {} vars here, which is the limit",
                                      func().name, nest().names.size()));
    }

    bool factor(const schedule::Word& word, int64_t most, int64_t* out) {
        *out = number_of(word);
        if (*out >= 1 && *out <= most) return true;
        return fail(word, fmt::format("expected a number from 1 to {}", most));
    }

    void split_loop(Loop* loop, const std::string& outer, const std::string& inner, int64_t by) {
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

    bool split() {
        Loop* loop = nullptr;
        int64_t by = 1;
        if (!find_serial(arg(0), &loop) || !factor(arg(3), kMostFactor, &by)) return false;
        // Lines that name the loop may mean one of its parts from now on.
        const std::string& name = arg(0).text;
        const bool keeps = arg(1).text == name;
        if ((!keeps && !new_name(arg(1))) ||
            ((keeps || arg(2).text != name) && !new_name(arg(2)))) {
            return false;
        }
        split_loop(loop, arg(1).text, arg(2).text, by);
        return true;
    }

    bool tile() {
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

    bool fuse() {
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

    bool fail_order(const schedule::Word& word) {
        return fail(word,
                    fmt::format("`{}` runs over a reduction: in another order its result would be "
                                "another",
                                word.text),
                    "its loops can be split, unrolled, and stand inside or outside others");
    }

    bool reorder() {
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

    /// Puts the named loops, innermost first, into the places that they have together.
    bool reorder_loops(const std::vector<std::string>& order) {
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

    /// Makes a name for a loop that no directive names.
    std::string made_name(const std::string& base) {
        std::string name = base;
        for (int k = 2; !nest().names.insert(name).second; ++k)
            name = fmt::format("{}{}", base, k);
        return name;
    }

    /// Splits off the inner part of a loop that is to be vectorized or unrolled, if a factor says
    /// so; what is left keeps the loop's name.
    bool inner_part(int64_t most, const char* what, Loop** out) {
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

    /// Counts the iterations of all loops of a kind; loops whose length is not known count as one.
    int64_t together(Loop::Kind kind) {
        int64_t out = 1;
        for (const Loop& loop : nest().loops) {
            if (loop.kind == kind) out *= loop.extent.value_or(1);
        }
        return out;
    }

    bool vectorize() {
        Loop* loop = nullptr;
        if (!find_loop(arg(0), &loop)) return false;
        if (loop->reduces) {
            return fail(
                arg(0),
                fmt::format("`{}` runs over a reduction: its steps come one after the other",
                            arg(0).text),
                "vectorize a var of the func");
        }
        if (!inner_part(kMostVectorLanes, "vectorize", &loop)) return false;
        loop->kind = Loop::Kind::kVector;
        if (const int64_t lanes = together(Loop::Kind::kVector); lanes > kMostVectorLanes) {
            return fail(arg(0), fmt::format("this makes vectors of {} lanes; the limit is {}",
                                            lanes, kMostVectorLanes));
        }
        if (!func().is_result && loop->is_part && loop->extent) {
            func().part_vectors.push_back({definition_, loop->name, current_->name});
        } else {
            nest().stage.vectorize(loop->var);
        }
        return true;
    }

    bool unroll() {
        Loop* loop = nullptr;
        if (!inner_part(kMostUnrolled, "unroll", &loop)) return false;
        loop->kind = Loop::Kind::kUnrolled;
        if (const int64_t copies = together(Loop::Kind::kUnrolled); copies > kMostUnrolled) {
            return fail(arg(0), fmt::format("this makes {} copies of the code; the limit is {}",
                                            copies, kMostUnrolled));
        }
        return true;
    }

    bool parallel() {
        Loop* loop = nullptr;
        if (!find_serial(arg(0), &loop)) return false;
        if (loop->reduces) {
            return fail(
                arg(0),
                fmt::format("`{}` runs over a reduction: its steps come one after the other",
                            arg(0).text),
                "make a var of the func parallel");
        }
        loop->kind = Loop::Kind::kParallel;
        nest().stage.parallel(loop->var);
        return true;
    }

    bool update() {
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

    bool specialize() {
        const schedule::Word& var = arg(0);
        if (specialization_ != 0)
            return fail(current_->name, "a specialization is not specialized again");
        if (func().definitions[0].size() > kMostSpecializations) {
            return fail(current_->name,
                        fmt::format("`{}` has {} specializations, which is the limit", func().name,
                                    kMostSpecializations));
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

    bool prefetch() {
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
            return fail(arg(1),
                        fmt::format("`{}` is vectorized: it has no next step", arg(1).text));
        func().prefetches.push_back({read, arg(1).text, current_->name});
        nest().stage.prefetch(kernel_->funcs()[read].func, loop->var, loop->var,
                              static_cast<int>(distance));
        return true;
    }

    bool find_func(const schedule::Word& word, size_t* out) {
        const std::optional<size_t> found = kernel_->find(word.text);
        if (found) {
            *out = *found;
            return true;
        }
        return fail(word, fmt::format("this kernel has no func `{}`", word.text),
                    schedule::near_or_all(word.text, kernel_->names(), "it has"));
    }

    /// True where the Func may be placed at all.
    bool is_placed_by_kernel() {
        if (!func().is_result) return true;
        return fail(current_->name,
                    fmt::format("`{}` is the kernel's result and stays outermost", func().name));
    }

    bool place(Placement::Level level, Placement* out) {
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

    bool compute_at() {
        if (!is_placed_by_kernel() || !place(Placement::Level::kAt, &func().compute)) return false;
        return true;
    }
    bool compute_root() {
        return is_placed_by_kernel() && place(Placement::Level::kRoot, &func().compute);
    }
    bool compute_inline() {
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
    bool store_at() {
        return is_placed_by_kernel() && place(Placement::Level::kAt, &func().store.emplace());
    }
    bool store_root() {
        return is_placed_by_kernel() && place(Placement::Level::kRoot, &func().store.emplace());
    }

    /// True where the layout of the Func's storage is nobody else's business.
    bool has_own_storage() {
        if (func().is_result) {
            return fail(current_->name,
                        fmt::format("`{}` is the kernel's result: the buffer is the caller's",
                                    func().name));
        }
        if (!func().is_extern() && !func().is_read_by_extern) return true;
        return fail(current_->name,
                    fmt::format("the runtime {} `{}` and knows its layout",
                                func().is_extern() ? "writes" : "reads", func().name));
    }

    bool storage_var(const schedule::Word& word, Halide::Var* out) {
        std::vector<std::string> names;
        for (const Halide::Var& var : func().func.args()) {
            if (var.name() == word.text) {
                *out = var;
                return true;
            }
            names.push_back(var.name());
        }
        return fail(
            word, fmt::format("the storage of `{}` has no dimension `{}`", func().name, word.text),
            schedule::near_or_all(word.text, names, "it has"));
    }

    bool store_in() {
        if (func().is_result) return has_own_storage();
        if (arg(0).text != "heap" && arg(0).text != "stack")
            return fail(arg(0), "expected `heap` or `stack`");
        func().has_memory = true;
        func().func.store_in(arg(0).text == "heap" ? Halide::MemoryType::Heap
                                                   : Halide::MemoryType::Stack);
        return true;
    }

    bool reorder_storage() {
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

    bool align_storage() {
        Halide::Var var;
        int64_t multiple = 1;
        if (!has_own_storage() || !storage_var(arg(0), &var) ||
            !factor(arg(1), kMostFactor, &multiple)) {
            return false;
        }
        func().func.align_storage(var, static_cast<int>(multiple));
        return true;
    }

    bool bound_storage() {
        Halide::Var var;
        int64_t extent = 1;
        if (!has_own_storage() || !storage_var(arg(0), &var) ||
            !factor(arg(1), schedule::kMostNumber, &extent)) {
            return false;
        }
        func().func.bound_storage(var, static_cast<int>(extent));
        return true;
    }

    bool fold_storage() {
        Halide::Var var;
        int64_t extent = 1;
        if (!has_own_storage() || !storage_var(arg(0), &var) ||
            !factor(arg(1), schedule::kMostNumber, &extent)) {
            return false;
        }
        func().folds.push_back({var.name(), extent, current_->name});
        return true;
    }

    ScheduledKernel* kernel_;
    size_t target_;
    const schedule::Line& line_;
    size_t definition_ = 0;
    size_t specialization_ = 0;
    const schedule::Directive* current_ = nullptr;
    schedule::Fault fault_;
};

std::optional<schedule::Fault> apply_line(const schedule::Line& line, ScheduledKernel* kernel) {
    bool found = false;
    for (size_t k = 0; k < kernel->funcs().size(); ++k) {
        const ScheduledFunc& func = kernel->funcs()[k];
        if (!func.is_listed || !names_func(line, func.name)) continue;
        found = true;
        if (std::optional<schedule::Fault> fault = DirectiveChain(kernel, k, line).run())
            return fault;
    }
    // A pattern may match nothing: which Funcs there are depends on the fablet.
    const bool one = line.func.text.find('*') == std::string::npos;
    if (found || !one) return std::nullopt;
    return schedule::fault_at(line.func,
                              fmt::format("this kernel has no func `{}`", line.func.text),
                              schedule::near_or_all(line.func.text, kernel->names(), "it has"));
}

Halide::LoopLevel level_of(const ScheduledKernel& kernel, const Placement& placement) {
    switch (placement.level) {
        case Placement::Level::kInline:
            return Halide::LoopLevel::inlined();
        case Placement::Level::kRoot:
            return Halide::LoopLevel::root();
        case Placement::Level::kAt:
            break;
    }
    const ScheduledFunc& at = kernel.funcs()[placement.func];
    for (const std::vector<LoopNest>& definition : at.definitions) {
        if (const Loop* loop = definition[0].find(placement.var)) return {at.func, loop->var};
    }
    return Halide::LoopLevel::root();
}

/// Kernels ask for the stack, which is right for what a batch needs; of what another schedule stores
/// only small things of constant size are, unless a line says otherwise.
void choose_memory(ScheduledFunc* func) {
    if (!func->is_result && !func->has_memory) func->func.store_in(Halide::MemoryType::Auto);
}

/// Tells Halide where Funcs are computed, now that it is known to be legal.
void set_levels(ScheduledKernel* kernel, bool built_in) {
    for (ScheduledFunc& func : kernel->funcs()) {
        if (!built_in) choose_memory(&func);
        if (func.compute.directive) func.func.compute_at(level_of(*kernel, func.compute));
        // Halide warns of updates that nobody scheduled.
        for (size_t u = 1; u < func.definitions.size(); ++u) {
            Halide::Stage stage = func.func.update(static_cast<int>(u) - 1);
            if (!func.func.function().update(static_cast<int>(u) - 1).schedule().touched())
                stage.unscheduled();
        }
    }
}

}  // namespace

std::variant<ScheduledKernel, schedule::Fault> apply_schedule(const schedule::Schedule& schedule,
                                                              const Kernel& kernel, bool built_in) {
    ScheduledKernel scheduled(kernel);
    for (const schedule::Line& line : schedule.lines) {
        try {
            if (std::optional<schedule::Fault> fault = apply_line(line, &scheduled)) return *fault;
        } catch (const Halide::Error&) {
            return schedule::fault_at(
                line.func, fmt::format("this line cannot be applied to `{}`", line.func.text),
                "the loops that it asks for cannot be made");
        }
    }
    if (std::optional<schedule::Fault> fault = check_placements(scheduled)) return *fault;
    if (std::optional<schedule::Fault> fault = check_inlining(schedule, scheduled)) return *fault;
    set_levels(&scheduled, built_in);
    if (built_in) {
        scheduled.unroll_loops();
        scheduled.vectorize_parts();
    }
    return scheduled;
}

}  // namespace openfab::lower

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/apply_schedule.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <functional>

namespace openfab::lower {

namespace {

using Halide::Func;
using Halide::Var;

// Splits whose factor does not divide the extent guard each index, so that nothing outside a buffer
// is read or written.
constexpr Halide::TailStrategy kTail = Halide::TailStrategy::GuardWithIf;
constexpr int32_t kMaxFactor = 4096;

ScheduleFault fault_at(int32_t line, const ScheduleWord& word, std::string message,
                       std::string help = {}) {
    ScheduleFault fault;
    fault.line = line;
    fault.column = word.column;
    fault.offset = word.offset;
    fault.length = std::max<int32_t>(1, static_cast<int32_t>(word.text.size()));
    fault.message = std::move(message);
    fault.help = std::move(help);
    return fault;
}

/// Applies one line to one Func.
class DirectiveChain {
  public:
    DirectiveChain(Kernel* kernel, NamedFunc* target, const ScheduleLine& line)
        : kernel_(kernel), target_(target), line_(line) {
        if (!target->func.is_extern()) stage_.emplace(target->func);
    }

    std::optional<ScheduleFault> run() {
        for (const Directive& directive : line_.directives) {
            current_ = &directive;
            if (!apply(directive)) return fault_;
        }
        return std::nullopt;
    }

  private:
    bool fail(const ScheduleWord& word, std::string message, std::string help = {}) {
        fault_ = fault_at(line_.line, word, std::move(message), std::move(help));
        return false;
    }

    bool fail_loopless(const ScheduleWord& word, const NamedFunc& func) {
        return fail(
            word,
            fmt::format("`{}` is computed by the runtime: it has no loops of its own", func.name),
            "it can be placed: compute_at, compute_root, store_at, store_root");
    }

    bool find_var(const NamedFunc& func, const ScheduleWord& word, Var* out) {
        for (const auto& [name, var] : func.vars) {
            if (name == word.text) {
                *out = var;
                return true;
            }
        }
        std::vector<std::string> names;
        for (const auto& [name, var] : func.vars)
            names.push_back(name);
        return fail(word, fmt::format("`{}` has no var `{}`", func.name, word.text),
                    near_or_all(word.text, names, "it has"));
    }

    bool vars(size_t first, size_t count, std::vector<Var>* out) {
        for (size_t k = 0; k < count; ++k) {
            Var var;
            if (!find_var(*target_, current_->args[first + k], &var)) return false;
            out->push_back(var);
        }
        return true;
    }

    bool new_var(size_t arg, Var* out) {
        const ScheduleWord& word = current_->args[arg];
        for (const auto& [name, var] : target_->vars) {
            if (name == word.text) {
                return fail(word, fmt::format("`{}` has a var `{}` already", target_->name, name));
            }
        }
        *out = Var(word.text);
        target_->vars.emplace_back(word.text, *out);
        return true;
    }

    void drop_var(const Var& var) {
        auto& vars = target_->vars;
        vars.erase(std::remove_if(vars.begin(), vars.end(),
                                  [&](const auto& v) { return v.second.same_as(var); }),
                   vars.end());
    }

    bool factor(size_t arg, int32_t* out) {
        const ScheduleWord& word = current_->args[arg];
        const char* end = word.text.data() + word.text.size();
        const auto [stop, error] = std::from_chars(word.text.data(), end, *out);
        if (error != std::errc() || stop != end || *out < 1 || *out > kMaxFactor) {
            return fail(word, fmt::format("expected a number from 1 to {}", kMaxFactor));
        }
        return true;
    }

    bool is(const char* name) const { return current_->name.text == name; }

    bool apply(const Directive& directive) {
        if (is("update")) {
            if (!target_->func.has_update_definition()) {
                return fail(directive.name,
                            fmt::format("`{}` has no loop to update", target_->name));
            }
            updating_ = true;
            stage_ = target_->func.update(0);
            return true;
        }
        if (is("compute_at") || is("compute_root") || is("store_at") || is("store_root")) {
            return set_compute_level();
        }
        if (!stage_) return fail_loopless(directive.name, *target_);
        if (is("split")) return split();
        if (is("tile")) return tile();
        if (is("fuse")) return fuse();
        if (is("reorder")) return reorder();
        return run_loop();
    }

    /// Splits `var` in stage_ and in the name map.
    void split_var(const Var& var, const Var& outer, const Var& inner, int32_t by) {
        stage_->split(var, outer, inner, by, kTail);
        drop_var(var);
    }

    bool split() {
        Var var;
        Var outer;
        Var inner;
        int32_t by = 1;
        if (!find_var(*target_, current_->args[0], &var) || !new_var(1, &outer) ||
            !new_var(2, &inner) || !factor(3, &by)) {
            return false;
        }
        split_var(var, outer, inner, by);
        return true;
    }

    bool tile() {
        std::vector<Var> sides;
        std::array<Var, 4> made;
        std::array<int32_t, 2> by{};
        if (!vars(0, 2, &sides)) return false;
        for (size_t k = 0; k < 4; ++k) {
            if (!new_var(2 + k, &made[k])) return false;
        }
        if (!factor(6, &by[0]) || !factor(7, &by[1])) return false;
        split_var(sides[0], made[0], made[2], by[0]);
        split_var(sides[1], made[1], made[3], by[1]);
        stage_->reorder(made[2], made[3], made[0], made[1]);
        return true;
    }

    bool fuse() {
        std::vector<Var> parts;
        Var fused;
        if (!vars(0, 2, &parts) || !new_var(2, &fused)) return false;
        stage_->fuse(parts[0], parts[1], fused);
        drop_var(parts[0]);
        drop_var(parts[1]);
        return true;
    }

    bool reorder() {
        std::vector<Var> order;
        if (!vars(0, current_->args.size(), &order)) return false;
        stage_->reorder(std::vector<Halide::VarOrRVar>(order.begin(), order.end()));
        return true;
    }

    bool run_loop() {
        Var var;
        if (!find_var(*target_, current_->args[0], &var)) return false;
        if (is("parallel")) {
            stage_->parallel(var);
            return true;
        }
        if (current_->args.size() == 1) {
            if (is("unroll")) {
                stage_->unroll(var);
            } else {
                stage_->vectorize(var);
            }
            return true;
        }
        int32_t by = 1;
        if (!factor(1, &by)) return false;
        if (is("unroll")) {
            stage_->unroll(var, by, kTail);
        } else {
            stage_->vectorize(var, by, kTail);
        }
        return true;
    }

    /// Applies compute_at, compute_root, store_at or store_root.
    bool set_compute_level() {
        Func func = target_->func;
        if (kernel_->output.name() == func.name()) {
            return fail(
                current_->name,
                fmt::format("`{}` is the kernel's result and stays outermost", target_->name));
        }
        if (updating_) return fail(current_->name, "this belongs before `update()`");
        if (is("compute_root")) {
            func.compute_root();
            return true;
        }
        if (is("store_root")) {
            func.store_root();
            return true;
        }
        NamedFunc* at = find_func(current_->args[0]);
        Var var;
        if (at == nullptr) return false;
        if (at->func.is_extern()) return fail_loopless(current_->args[0], *at);
        if (!find_var(*at, current_->args[1], &var)) return false;
        if (is("compute_at")) {
            func.compute_at(at->func, var);
        } else {
            func.store_at(at->func, var);
        }
        return true;
    }

    NamedFunc* find_func(const ScheduleWord& word);

    Kernel* kernel_;
    NamedFunc* target_;
    const ScheduleLine& line_;
    std::optional<Halide::Stage> stage_;  ///< none for an extern Func
    bool updating_ = false;
    const Directive* current_ = nullptr;
    ScheduleFault fault_;
};

ScheduleFault unknown_func(const Kernel& kernel, int32_t line, const ScheduleWord& word) {
    std::vector<std::string> names;
    for (const NamedFunc& func : kernel.funcs)
        names.push_back(func.name);
    return fault_at(line, word, fmt::format("this kernel has no func `{}`", word.text),
                    near_or_all(word.text, names, "it has"));
}

NamedFunc* DirectiveChain::find_func(const ScheduleWord& word) {
    for (NamedFunc& func : kernel_->funcs) {
        if (func.name == word.text) return &func;
    }
    fault_ = unknown_func(*kernel_, line_.line, word);
    return nullptr;
}

}  // namespace

bool names_func(const ScheduleLine& line, std::string_view func) {
    const std::string& pattern = line.func.text;
    const size_t star = pattern.find('*');
    return star == std::string::npos ? func == pattern : func.starts_with(pattern.substr(0, star));
}

namespace {

std::optional<ScheduleFault> apply_line(const ScheduleLine& line, Kernel* kernel) {
    bool found = false;
    for (NamedFunc& func : kernel->funcs) {
        if (!names_func(line, func.name)) continue;
        found = true;
        if (std::optional<ScheduleFault> fault = DirectiveChain(kernel, &func, line).run())
            return fault;
    }
    const bool one = line.func.text.find('*') == std::string::npos;
    if (!found && one) return unknown_func(*kernel, line.line, line.func);
    return std::nullopt;
}

/// Rephrases Halide's message, which names Funcs differently from schedules.
std::string reason_for(std::string_view message) {
    const auto says = [&](std::string_view part) {
        return message.find(part) != std::string_view::npos;
    };
    if (says("invalid location")) {
        return "a func is computed inside a loop of a func that uses it, or in none (compute_root)";
    }
    if (says("constant extent")) {
        return "only loops of constant length can be vectorized or unrolled; give a factor, as in "
               "`vectorize(n, 8)`";
    }
    if (says("reorder")) return "each loop is named once, from the innermost out";
    return "the loops that it asks for cannot be made";
}

}  // namespace

ScheduleFault fault_on_line(const ScheduleLine& line, const std::string& halide_message) {
    return fault_at(line.line, line.func,
                    fmt::format("this line cannot be applied to `{}`", line.func.text),
                    reason_for(halide_message));
}

std::optional<ScheduleFault> apply_schedule(const Schedule& schedule, size_t line_count,
                                            Kernel* kernel) {
    for (size_t k = 0; k < std::min(line_count, schedule.lines.size()); ++k) {
        const ScheduleLine& line = schedule.lines[k];
        try {
            if (std::optional<ScheduleFault> fault = apply_line(line, kernel)) return fault;
        } catch (const Halide::Error& error) {
            return fault_on_line(line, error.what());
        }
    }
    return std::nullopt;
}

}  // namespace openfab::lower

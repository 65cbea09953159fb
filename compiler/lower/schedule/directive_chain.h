// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// One line of a schedule, directive by directive, applied to one Func.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/lower/schedule/scheduled_kernel.h"
#include "compiler/schedule/schedule.h"

namespace openfab::lower {

constexpr int64_t kMostFactor = 4096;

/// Returns the value of a word that is a number.
int64_t number_of(const schedule::Word& word);

class DirectiveChain {
  public:
    DirectiveChain(ScheduledKernel* kernel, size_t target, const schedule::Line& line)
        : kernel_(kernel), target_(target), line_(line) {}

    std::optional<schedule::Fault> run();

  private:
    bool apply();

    // One a directive; false where it ends with `fault_`.
#define OPENFAB_DIRECTIVE(name, ...) bool name();
#include "compiler/schedule/directives.def"
#undef OPENFAB_DIRECTIVE

    ScheduledFunc& func() {
        return kernel_->funcs()[target_];
    }
    LoopNest& nest() {
        return func().definitions[definition_][specialization_];
    }
    const schedule::Word& arg(size_t k) const {
        return current_->args[k];
    }

    bool fail(const schedule::Word& word, std::string message, std::string help = {});
    bool fail_loopless(const schedule::Word& word, const ScheduledFunc& func);
    bool find_func(const schedule::Word& word, size_t* out);
    bool factor(const schedule::Word& word, int64_t most, int64_t* out);
    bool find_loop(const schedule::Word& word, Loop** out);
    /// Finds a loop that no directive has taken yet: the others have no parts.
    bool find_serial(const schedule::Word& word, Loop** out);
    bool new_name(const schedule::Word& word);
    /// Halide's time grows with the third power of splits in splits.
    bool room_for_var(const schedule::Word& word);
    void split_loop(Loop* loop, const std::string& outer, const std::string& inner, int64_t by);
    bool fail_order(const schedule::Word& word);
    /// Puts the named loops, innermost first, into the places that they have together.
    bool reorder_loops(const std::vector<std::string>& order);
    /// Makes a name for a loop that no directive names.
    std::string made_name(const std::string& base);
    /// Splits off the inner part of a loop that is to be vectorized or unrolled, if a factor says
    /// so; what is left keeps the loop's name.
    bool inner_part(int64_t most, const char* what, Loop** out);
    /// Counts the iterations of all loops of a kind; loops whose length is not known count as one.
    int64_t together(Loop::Kind kind);
    /// True where the Func may be placed at all.
    bool is_placed_by_kernel();
    bool place(Placement::Level level, Placement* out);
    /// True where the layout of the Func's storage is nobody else's business.
    bool has_own_storage();
    bool storage_var(const schedule::Word& word, Halide::Var* out);

    ScheduledKernel* kernel_;
    size_t target_;
    const schedule::Line& line_;
    size_t definition_ = 0;
    size_t specialization_ = 0;
    const schedule::Directive* current_ = nullptr;
    schedule::Fault fault_;
};

}  // namespace openfab::lower

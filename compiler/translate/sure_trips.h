// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Finds what a real loop certainly does: its counters are evaluated iteration by iteration as long
// as their values are compile-time constants. This is how `for (int i = 0; i < 300; ++i) a[i] = x;`
// is found to assign all of `a`, for any number of iterations, upwards or downwards and in nested
// loops. Where the loop's condition is not a constant, an iteration runs under a condition on
// values from before the loop: `for (int i = 0; i < min(n, 8); ++i) a[i] = x;` assigns `a[3]` where
// `3 < min(n, 8)`. A `break` ends the analysis.
//
// An index is often known but for a value from outside, as in the inner loop over `x` of
// `a[y * 20 + x]`. It then changes by a constant stride, and the loop assigns `a[k]` where
// `k - 19 <= y * 20 && y * 20 <= k`, which the outer loop evaluates.

#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "compiler/check/tree.h"
#include "compiler/translate/emitter.h"

namespace openfab::translate {

/// A read in a loop that an earlier iteration may have to assign. As bools: when it is reached, and
/// for each element that it may access, when it is that one and whether its components are
/// assigned.
struct DoubtfulRead {
    struct Alternative {
        ir::ValueId condition = 0;
        std::vector<ir::ValueId> assigned;
    };
    const check::Symbol* symbol = nullptr;
    source::Span span;
    ir::ValueId reached = 0;
    std::vector<Alternative> alternatives;
};

class SureTrips {
  public:
    /// Analyses a loop that has ended: `again` and `next` are the condition and the next values of
    /// its LoopEnd. `facts` are the bools of later queries; at `most` so many iterations run. Emits
    /// conditions after the loop. `effort` bounds the time.
    SureTrips(const ir::Stage& stage, ir::ValueId loop, ir::ValueId again,
              const std::vector<ir::ValueId>& next, const std::vector<ir::ValueId>& facts,
              double most, size_t effort, Emitter* emit);

    /// What is left of the effort. Without any, nothing more is known.
    size_t effort() const { return effort_; }

    /// Returns a condition on values from before the loop, emitted after it: where it holds and the
    /// first iteration runs, some iteration ends with `fact`. False where nothing is known.
    ir::ValueId some_gives(ir::ValueId fact, Emitter* emit) const;

    /// The value that an iteration gives, by the placeholder for "an earlier iteration gave it".
    using ByTrips = std::map<ir::ValueId, ir::ValueId>;

    /// Returns what is left of a read: the alternatives of which no iteration that may run is known
    /// to find them assigned, by itself or by earlier ones, as values from before the loop, for the
    /// analysis of the enclosing one. Nothing if that is not known. `given`, conditions from before
    /// the loop, hold.
    std::optional<DoubtfulRead> left_in_doubt(const DoubtfulRead& read,
                                              const std::vector<ir::ValueId>& given,
                                              const ByTrips& by_trips, Emitter* emit);

  private:
    using Bits = std::optional<uint32_t>;
    /// `value == number` or similar: iterations where they are equal are worth checking. An int is
    /// sign-extended, so that numbers are in the order of values.
    using Test = std::pair<ir::ValueId, int64_t>;
    /// The values of conditions.
    using Facts = std::map<ir::ValueId, bool>;
    /// An iteration. The conditions are from before the loop and assume that the first one runs.
    struct Trip {
        std::map<int32_t, uint32_t> counters;  ///< as far as they are known
        ir::ValueId sure_if = 0;               ///< where it holds, the iteration runs
        ir::ValueId may_if = 0;                ///< the iteration runs only where it holds
    };
    /// The condition `lo <= value && value <= hi`.
    struct Window {
        ir::ValueId value = 0;
        int64_t lo = 0;
        int64_t hi = 0;
    };

    const ir::Instr& at(ir::ValueId id) const { return stage_.instrs[id]; }
    bool spend(size_t effort) const;
    bool proves(const std::vector<ir::ValueId>& given, ir::ValueId fact) const;
    bool is_variable(ir::ValueId id) const;
    std::pair<int64_t, int64_t> range(ir::ValueId value) const;
    int64_t number(ir::ValueId value, uint32_t bits) const;
    std::vector<Test> tests(ir::ValueId fact) const;
    std::optional<Window> half_window(ir::ValueId comparison) const;
    std::optional<Window> window(ir::ValueId condition) const;
    std::map<ir::ValueId, Window> windows(ir::ValueId fact, const Facts& facts, int depth) const;
    std::vector<ir::ValueId> needed_for(std::vector<ir::ValueId> roots) const;
    void follow(ir::ValueId again, const std::vector<ir::ValueId>& roots, double most,
                Emitter* emit);
    void assume(ir::ValueId value, bool truth, Facts* facts) const;
    ir::ValueId chosen(ir::ValueId value, const Facts& facts) const;
    bool go_on(ir::ValueId again, const Facts& facts, Trip* next, Emitter* emit);
    ir::ValueId both(ir::ValueId earlier, ir::ValueId now, Emitter* emit);
    std::vector<size_t> candidates(ir::ValueId fact, size_t end, bool ends) const;
    Bits known(ir::ValueId value, size_t trip, int depth) const;
    Bits stride(ir::ValueId value, size_t end, int depth) const;
    ir::ValueId exactly(ir::ValueId value, size_t trip, int depth, const Facts& facts,
                        Emitter* emit) const;
    ir::ValueId at_most(ir::ValueId value, size_t trip, int depth, const Facts& facts,
                        Emitter* emit) const;
    ir::ValueId at_least(ir::ValueId value, size_t trip, int depth, const ByTrips& by_trips,
                         Emitter* emit) const;
    ir::ValueId some_is_in(const Window& window, size_t end, bool all_ran, Emitter* emit) const;
    ir::ValueId some_gives(ir::ValueId fact, size_t end, bool all_ran, Emitter* emit) const;
    bool leaves(const DoubtfulRead::Alternative& alternative, size_t trip,
                const std::vector<ir::ValueId>& where, const ByTrips& by_trips, Emitter* emit,
                DoubtfulRead* left);

    const ir::Stage& stage_;
    const ir::ValueId loop_;
    const std::vector<ir::ValueId>& next_;
    std::vector<Trip> trips_;
    size_t certain_ = 0;      ///< iterations that run if the first one does
    size_t sure_ = 0;         ///< iterations that run under a known condition
    size_t conditional_ = 0;  ///< conditions that were emitted
    mutable size_t effort_;   ///< what may still be spent on formulas
    bool all_ = false;        ///< there are no further iterations
    std::map<Test, std::vector<size_t>> trips_where_;  ///< where they are equal
};

}  // namespace openfab::translate

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Finds what a real loop certainly does: its counters are evaluated iteration by iteration as long
// as their values and the loop's condition are compile-time constants. This is how `for (int i = 0;
// i < 300; ++i) a[i] = x;` is found to assign all of `a`, for any number of iterations, upwards or
// downwards and in nested loops; a `break` ends the analysis.

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
    /// its LoopEnd. `facts` are the bools of later queries.
    SureTrips(const ir::Stage& stage, ir::ValueId loop, ir::ValueId again,
              const std::vector<ir::ValueId>& next, const std::vector<ir::ValueId>& facts);

    /// Returns a condition on values from before the loop, emitted after it: where it holds and the
    /// first iteration runs, some iteration ends with `fact`. False where nothing is known.
    ir::ValueId some_gives(ir::ValueId fact, Emitter* emit) const;

    /// The value that an iteration gives, by the placeholder for "an earlier iteration gave it".
    using ByTrips = std::map<ir::ValueId, ir::ValueId>;

    /// Returns whether every iteration that may run finds its reads assigned, by itself or by
    /// earlier ones. Emitted instructions are of no further use.
    bool always_assigned(const DoubtfulRead& read, const ByTrips& by_trips, Emitter* emit);

  private:
    using Bits = std::optional<uint32_t>;
    /// `value == number` or similar: iterations where they are equal are worth checking.
    using Test = std::pair<ir::ValueId, uint32_t>;

    const ir::Instr& at(ir::ValueId id) const { return stage_.instrs[id]; }
    bool is_variable(ir::ValueId id) const;
    std::vector<Test> tests(ir::ValueId fact) const;
    std::vector<ir::ValueId> needed_for(std::vector<ir::ValueId> roots) const;
    void follow(ir::ValueId again, const std::vector<ir::ValueId>& roots);
    std::vector<size_t> candidates(ir::ValueId fact, size_t end) const;
    Bits known(ir::ValueId value, size_t trip, int depth) const;
    ir::ValueId exactly(ir::ValueId value, size_t trip, int depth, Emitter* emit) const;
    ir::ValueId at_least(ir::ValueId value, size_t trip, int depth, const ByTrips& by_trips,
                         Emitter* emit) const;
    ir::ValueId some_gives(ir::ValueId fact, size_t end, Emitter* emit) const;
    bool is_assigned(const DoubtfulRead::Alternative& alternative, size_t trip,
                     const ByTrips& by_trips, Emitter* emit);

    const ir::Stage& stage_;
    const ir::ValueId loop_;
    const std::vector<ir::ValueId>& next_;
    std::vector<std::map<int32_t, uint32_t>> trips_;   ///< the counters' values in each iteration
    size_t sure_ = 0;                                  ///< iterations that certainly run
    size_t looks_ = size_t{1} << 16;                   ///< remaining lookups for reads
    bool all_ = false;                                 ///< there are no further iterations
    std::map<Test, std::vector<size_t>> trips_where_;  ///< where they are equal
};

}  // namespace openfab::translate

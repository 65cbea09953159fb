// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Finds what a real loop surely does: its counters are followed from trip to trip for as long as
// their values and the loop's condition are known when compiled. This is how `for (int i = 0; i <
// 300; ++i) a[i] = x;` is found to assign all of `a`, at any number of trips, upwards or downwards
// and in nested loops, while a `break` ends what is known.

#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "compiler/check/tree.h"
#include "compiler/translate/emitter.h"

namespace openfab::translate {

/// A read in a loop of what an earlier trip may have to assign: as bools, where it is reached, and
/// of each place that it may be of, where it is that one and whether its components are assigned.
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
    /// Takes a loop that has ended: `again` and `next` are the condition and the next values that
    /// its LoopEnd has. `facts` are the bools that will be asked about.
    SureTrips(const ir::Stage& stage, ir::ValueId loop, ir::ValueId again,
              const std::vector<ir::ValueId>& next, const std::vector<ir::ValueId>& facts);

    /// A condition on values from before the loop, emitted behind it: where it holds and the first
    /// trip runs, some trip ends with `fact`. False where nothing is known.
    ir::ValueId some_gives(ir::ValueId fact, Emitter* emit) const;

    /// The value that a trip gives under what stands for "an earlier trip gave it".
    using ByTrips = std::map<ir::ValueId, ir::ValueId>;

    /// True where each trip that may run finds assigned what it reads, by itself or by those before
    /// it. What is emitted is of no use.
    bool always_assigned(const DoubtfulRead& read, const ByTrips& by_trips, Emitter* emit);

  private:
    using Bits = std::optional<uint32_t>;
    /// `value == number` or the like: a trip where they are equal is worth a look.
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
    std::vector<std::map<int32_t, uint32_t>> trips_;   ///< of each trip: its counters' values
    size_t sure_ = 0;                                  ///< trips that surely run; others may
    size_t looks_ = size_t{1} << 16;                   ///< more that reads may take
    bool all_ = false;                                 ///< there are no other trips
    std::map<Test, std::vector<size_t>> trips_where_;  ///< the first ones in which they are equal
};

}  // namespace openfab::translate

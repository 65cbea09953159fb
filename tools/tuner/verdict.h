// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether a schedule is faster than the first one: a statement about noisy seconds, so with an error
// that is known. A schedule wins by what 99 of 100 repetitions of the comparison would confirm.

#include <cstdint>
#include <vector>

#include "base/vec.h"

namespace openfab::tuner {

/// A gain below this is not worth a schedule of its own.
constexpr double kLeastGain = 0.01;

/// Seconds of one place of the print with the first schedule, the contender, and the first again.
struct Triple {
    double before = 0, contender = 0, after = 0;
};

struct Verdict {
    double ratio = 1;  ///< of the contender's seconds to the first's; the mean of the runs
    double bound = 1;  ///< that the ratio is below, with 99 % confidence
    Vec2<double> of_places{1, 1};  ///< the least and the greatest ratio of a place
    int32_t runs = 0, places = 0;
    /// The ratio is at least kLeastGain below 1, its bound below 1, and it is below 1 at four of five
    /// places.
    bool faster = false;

    /// Returns whether it wins. One that has won before stays where its ratio is still kLeastGain below
    /// 1: what it was judged by then counts, too.
    bool wins(bool has_won) const { return faster || (has_won && ratio <= 1 - kLeastGain); }
};

/// Judges `runs` [run][place], all of the same places. In a run the seconds of all places are summed up.
/// The bound is Student's for the mean of the logarithms; as their deviation counts the larger of theirs and
/// that of the first schedule's own two runs, before and after.
Verdict judge(const std::vector<std::vector<Triple>>& runs);

}  // namespace openfab::tuner

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Schedules that a search tries: those of one change each, then those near the best.

#include <cstddef>
#include <deque>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "tools/tuner/journal.h"
#include "tools/tuner/space.h"
#include "tools/tuner/stand.h"
#include "tools/tuner/verdict.h"

namespace openfab::tuner {

/// Rounds that a schedule stays in at most, of which each leaves the better half.
constexpr size_t kRounds = 4;
/// A schedule that is tried.
struct Candidate {
    Setting setting;
    std::string text;
    Trial trial;
    Contender contender;

    bool usable() const { return trial.refused.empty(); }
    double ratio() const { return trial.ratios.empty() ? 1.0 : median(trial.ratios); }
};

/// Leaves those that were measured, the fastest first.
void sort_by_ratio(std::vector<Candidate*>* candidates);

class Candidates {
  public:
    /// All are kept; `first_text` is the schedule that others are compared with.
    Candidates(const Space* space, const Journal* journal, const std::string& first_text)
        : space_(*space), journal_(*journal), first_text_(first_text) {}

    /// Returns each change alone.
    std::vector<Candidate*> first_generation();
    /// Returns settings near the best one: good changes added to it, and knobs of it set otherwise.
    std::vector<Candidate*> next_generation();
    /// Returns the candidate of the least ratio among those that stayed in for a few rounds.
    Candidate* best();
    /// Returns the candidate with the schedule of a file, which the search may not have tried.
    Candidate* with_text(const std::string& text);
    std::deque<Candidate>& all() { return candidates_; }

  private:
    /// Returns a new candidate, or null where it was tried or its text is not a schedule.
    Candidate* propose(Setting setting);

    const Space& space_;
    const Journal& journal_;
    const std::string& first_text_;
    std::deque<Candidate> candidates_;
    std::set<std::string> tried_;
    std::mt19937 random_{1};
};

}  // namespace openfab::tuner

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The schedules that `openfab tune` tries: the one that it begins with, changed at some knobs. A
// knob's changes are lines of the schedule language; which there are follows from the schedule's
// parameters and from where the kernel's Funcs are read.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "compiler/lower/schedule/list_sites.h"
#include "compiler/schedule/schedule.h"

namespace openfab::tuner {

/// One way to set a knob.
struct Change {
    std::string text;                ///< what it is: a line, or `columns = 32`
    std::vector<std::string> lines;  ///< added to the schedule
    std::optional<int64_t> value;    ///< of the parameter that the knob is named after
    std::optional<int64_t> lanes;    ///< in each vectorized loop
};

struct Knob {
    std::string name;
    std::vector<Change> changes;
};

/// Which change each changed knob has, by index. Empty: the schedule to begin with.
using Setting = std::map<size_t, size_t>;

class Space {
  public:
    /// `file` is the schedule to begin with, `params` values in place of its own, `sites` those of a
    /// kernel under it.
    Space(const schedule::File& file, std::string target, std::map<std::string, int64_t> params,
          const schedule::Schedule& bound, const std::vector<lower::FuncSites>& sites);

    /// Returns the knobs, those that mostly matter first.
    const std::vector<Knob>& knobs() const { return knobs_; }
    /// Returns the lines of a setting; they need no parameters.
    std::variant<std::string, schedule::Fault> text(const Setting& setting) const;
    /// Returns what is changed, one text a knob.
    std::vector<std::string> changes(const Setting& setting) const;

  private:
    void add_params(const schedule::Schedule& bound);
    void add_loops(const std::vector<lower::FuncSites>& sites);
    void add_placements(const std::vector<lower::FuncSites>& sites);

    schedule::File file_;
    std::string target_;
    std::map<std::string, int64_t> params_;
    std::vector<Knob> knobs_;
};

/// Returns the pattern that a schedule would name a Func by: `values_*`. Halide numbers what has a
/// name again: `slab$1`.
std::string pattern_of(const std::string& func);

}  // namespace openfab::tuner

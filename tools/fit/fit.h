// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// `openfab fit`: finds the uniforms of a world for which its print is what is wanted.

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "compiler/driver/schedules.h"
#include "tools/fit/goals.h"
#include "tools/fit/print_values.h"
#include "tools/fit/search.h"

namespace openfab::fit {

struct FitOptions {
    std::vector<std::string> print;  ///< words of a print: the world, the goals, options
    std::string output;              ///< a world to write; empty: none
    bool write = false;              ///< into the world itself
    std::string json_file, history_file;
    uint64_t search_seed = 0;
    driver::ScheduleOptions schedules;
};

/// The numbers of a goal.
struct GoalNumbers {
    double searched = 0;  ///< of mixtures, on the voxels that were searched on
    double mixed = 0;     ///< of mixtures, on the printer's voxels
    double printed = 0;   ///< of the printer's dithered voxels; not a number where it is not known

    /// Returns the one that is nearest to what comes out.
    double last() const { return std::isnan(printed) ? mixed : printed; }
};

struct Fit {
    Goals goals;
    std::vector<std::string> given;     ///< `OBJECT.UNIFORM=VALUE` of the command line
    std::vector<std::string> settings;  ///< those that were found
    std::vector<double> unknowns;       ///< as those of a trial
    std::vector<GoalNumbers> numbers;   ///< by goal
    std::vector<Trial> history;
    std::vector<std::string> notes;
    std::string currency;
    bool reached = false;      ///< on the printed voxels
    bool interrupted = false;  ///< only `searched` is known then
    int32_t rounds = 0;        ///< the second aims off by what the first print was off
    double set_up_seconds = 0, search_seconds = 0;
    double search_pitch = 1;  ///< of the voxels that were searched on, in the printer's
};

/// Returns the report for people, and that for programs.
std::string fit_table(const Fit& fit);
std::string fit_json(const Fit& fit);
/// Returns the history as a table (.csv) or a picture (.svg).
std::string history_csv(const Fit& fit);
std::string history_svg(const Fit& fit);

Result<void> run_fit(const FitOptions& options);

}  // namespace openfab::fit

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The values of goals at any values of the unknowns: of a print that is kept.

#include <atomic>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "compiler/lower/code/jit.h"
#include "program/kept_print.h"
#include "program/options.h"
#include "tools/fit/goals.h"
#include "tools/fit/mechanics_values.h"
#include "tools/tuner/workload.h"

namespace openfab::fit {

/// One evaluation.
struct Trial {
    std::vector<double> unknowns;  ///< as uniforms have them; of one with choices its index
    std::vector<double> values;
};

/// Which choice each unknown has: an index, of those that have choices.
using Choices = std::vector<size_t>;

class PrintValues {
  public:
    /// Compiles, reads the goals, which are checked before meshes are read and trees are built, and sets the print up.
    /// The flag must outlive it.
    static Result<std::unique_ptr<PrintValues>> create(const program::Options& print,
                                                       const driver::ScheduleOptions& schedules,
                                                       const std::string& goals,
                                                       const std::atomic<bool>& interrupt);

    const Goals& goals() const { return goals_; }
    /// Of what costs are counted in; empty where no goal asks.
    const std::string& currency() const { return currency_; }
    /// Returns the edge of the voxels that are searched on, in the printer's.
    double search_pitch() const;
    /// Returns all evaluations, in order.
    const std::vector<Trial>& history() const { return history_; }

    /// Returns what a point of the unit cube, of the unknowns without choices, and choices of the others are as values
    /// of uniforms; of those with choices the index.
    std::vector<double> unknowns_at(std::span<const double> x, const Choices& choices) const;
    /// Returns these as `OBJECT.UNIFORM=VALUE`.
    std::vector<std::string> settings_of(const std::vector<double>& unknowns) const;

    /// Returns the values of all goals, of mixtures on the voxels that are searched on. What was asked before costs
    /// nothing.
    Result<std::vector<double>> searched(const std::vector<double>& unknowns);

    /// Whether a goal is about voxels of which none has ever held anything.
    bool is_always_empty(const Goal& goal) const {
        return goal.is_amount() && !filled_[goal.region];
    }
    /// Returns where the print is, in mm.
    Box3d extent_mm() const;

    /// Whether goals have slopes: many unknowns of floats, amounts alone, fablets without jumps.
    bool has_slopes() const { return slopes_ != nullptr; }
    void drop_slopes() { slopes_.reset(); }
    /// Returns the derivatives of these values by the unknowns without choices, each over its range: [goal][unknown].
    Result<std::vector<double>> slopes(const std::vector<double>& unknowns);

    struct Counted {
        std::vector<double> mixed, printed;  ///< by goal; not a number where it is not known
        std::vector<std::string> notes;
    };
    /// Prints to nowhere at the printer's own voxels, and counts mixtures and what is printed.
    Result<Counted> count(const std::vector<double>& unknowns);

  private:
    PrintValues(const program::Options& print, const std::atomic<bool>& interrupt)
        : print_(print), interrupt_(interrupt) {}
    Result<void> set_up(const driver::ScheduleOptions& schedules, const std::string& goals);
    std::optional<pipeline::PrintCost> cost_of(const std::vector<double>& ml) const;
    std::map<std::string, std::vector<size_t>> regions_by_object() const;
    double value_of(const Goal& goal, const std::vector<double>& ml) const;
    /// Returns the sums of all regions.
    Result<std::vector<program::RegionSums>> amounts(const std::vector<std::string>& settings,
                                                     program::SumPitch pitch, bool printed);
    Result<void> set_up_slopes();
    double mixed_value(const Goal& goal, const program::RegionSums& sums) const;
    /// Returns the materials of mixtures, and the support that is printed.
    std::vector<double> mixed_ml(const program::RegionSums& sums) const;
    void show_progress() const;

    program::Options print_;
    const std::atomic<bool>& interrupt_;
    Goals goals_;
    std::string currency_;
    std::unique_ptr<tuner::Workload> workload_;
    std::unique_ptr<lower::LoadedProgram> program_;
    std::unique_ptr<program::KeptPrint> kept_;
    std::map<std::string, std::unique_ptr<program::KeptPrint>> objects_;  ///< of these alone
    std::unique_ptr<MechanicsValues> mechanics_;  ///< null where no goal asks
    /// Prints with derivatives, like the ones above.
    struct Slopes {
        std::unique_ptr<tuner::Workload::Derivatives> compiled;
        std::map<std::string, std::unique_ptr<program::KeptPrint>>
            prints;                    ///< by object; "": of all
        std::vector<int32_t> columns;  ///< by unknown; -1: one with choices
        std::vector<double> scales;    ///< by column
    };
    std::unique_ptr<Slopes> slopes_;  ///< null: there are none
    std::vector<bool> filled_;        ///< by region
    std::map<std::vector<double>, std::vector<double>> known_;
    std::vector<Trial> history_;
};

}  // namespace openfab::fit

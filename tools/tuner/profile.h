// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// `openfab profile`: where the time of a print goes. Seconds are measured in the print itself, with
// the kernels that every print has; kernels that note the Func they are at run apart, and only divide
// the slab kernel's seconds. Bytes are those of the arrays between the stages, each read or written
// once: what a stage reads of its own, such as trees, is not in them.

#include <string>
#include <vector>

#include "base/result.h"
#include "compiler/driver/options.h"
#include "tools/tuner/machine.h"

namespace openfab::tuner {

struct ProfileOptions {
    driver::ScheduleOptions schedules;
    double seconds = 10;  ///< for the print, unless it is whole
    bool whole = false;
    std::string json_file;
    std::vector<std::string> print;  ///< the print's own options
};

/// One row of the table.
struct StageCost {
    std::string name;
    double seconds = 0;             ///< of a processor, all threads together
    std::vector<double> by_thread;  ///< none of a Func
    int64_t voxels = 0;
    int64_t bytes_read = 0, bytes_written = 0;
    double operations = 0;  ///< 0: not known
    std::string bound;      ///< memory, arithmetic, sink, waiting
};

struct Profile {
    std::string title;
    Machine machine;
    bool whole = false;
    int32_t slabs = 0, slabs_total = 0;
    int64_t voxels = 0;  ///< of the grid, in the slices that were printed
    double set_up_seconds = 0;
    double seconds = 0;            ///< on the clock, from the first slab to the last slice
    double processor_seconds = 0;  ///< of the process meanwhile
    std::vector<StageCost> stages;
    std::vector<StageCost> funcs;  ///< of the slab kernels
    int64_t samples = 0;           ///< in which their shares were seen
    /// Seconds of the whole print in which one thread works alone, and of all of it: measured, or
    /// scaled from the slabs that were printed.
    double alone_seconds = 0, print_seconds = 0;

    double thread_seconds() const { return seconds * machine.threads; }
};

/// Says what bounds a stage.
std::string bound_of(const StageCost& stage, const Machine& machine);

std::string profile_table(const Profile& profile);
std::string profile_json(const Profile& profile);

/// Runs the command.
Result<void> run_profile(const ProfileOptions& options);

}  // namespace openfab::tuner

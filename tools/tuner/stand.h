// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A stand on which schedules of the slab kernel are compared: one print, set up once, some of whose
// slabs are printed with the kernels of one schedule after the other. Figures are seconds of the
// processor, which a busy machine leaves as they are; what it does to them all at once, such as a
// slower clock, cancels in the ratio to a run just before and after.

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "tools/tuner/workload.h"

namespace openfab::tuner {

/// Kernels of one schedule.
struct Contender {
    std::unique_ptr<lower::LoadedProgram> program;
    std::string refused;  ///< why there is none
};

class Stand {
  public:
    /// Compiles the schedule to compare with, the command line's, and sets the print up. `workload` must
    /// outlive the stand.
    static Result<std::unique_ptr<Stand>> create(Workload* workload,
                                                 const std::atomic<bool>& interrupt);

    /// Compiles schedules of the slab kernel, several at once.
    std::vector<Contender> compile(const std::vector<std::string>& texts) const;

    /// Prints slabs with the kernels of a contender, null for those of the first schedule, a few times
    /// where that is too quick to be measured. Returns the seconds of the processor of one time; fails where voxels differ from those of the first schedule, which a
    /// first run over the same slabs has found.
    Result<double> run(const Contender* contender, const std::vector<int32_t>& slabs,
                       const std::atomic<bool>& interrupt);

    /// Returns how many slabs take about so many seconds of the processor.
    Result<int32_t> slabs_in(double seconds, const std::atomic<bool>& interrupt);
    Vec2<int32_t> slabs() const { return job_->slabs(); }
    const pipeline::PrintInfo& info() const { return job_->info(); }
    /// Returns whether the print finds its memory with these kernels; else why not.
    Result<void> fits(const Contender& contender) const;

  private:
    explicit Stand(Workload* workload) : workload_(workload) {}

    Workload* workload_;
    /// The one that is printed with, whose slab kernels are replaced, and its own once more.
    std::unique_ptr<lower::LoadedProgram> program_, first_;
    std::unique_ptr<pipeline::PrintJob> job_;
    /// Of slabs under the first schedule.
    struct Known {
        uint64_t hash = 0;
        int32_t times = 1;  ///< that they are printed in a run
    };
    Result<pipeline::SlabsRun> print(const std::vector<int32_t>& slabs,
                                     const std::atomic<bool>& interrupt);
    std::map<std::vector<int32_t>, Known> known_;
};

double median(std::vector<double> values);

}  // namespace openfab::tuner

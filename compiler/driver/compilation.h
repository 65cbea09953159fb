// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Source files to stages that are ready to compile, for `build` and `run`.

#include <deque>
#include <string>
#include <vector>

#include "compiler/driver/back_end.h"
#include "compiler/driver/commands.h"
#include "compiler/driver/schedules.h"
#include "compiler/lower/program.h"
#include "compiler/passes/pipeline.h"

namespace openfab::driver {

/// Returns lines of how long each kernel took that was compiled, and how many were not.
std::string kernel_report(const std::vector<lower::KernelTime>& kernels);

class Compilation {
  public:
    /// The options must outlive this object.
    Compilation(const CompilationOptions& options, const CommonOptions& common)
        : options_(options), common_(common) {}

    /// Runs the front end and the passes. Returns an exit code; errors have been printed.
    int prepare();

    /// The fablets of all files, after prepare.
    const std::vector<lower::FabletUnit>& fablets() const { return fablets_; }
    /// `cache` may be null.
    lower::ProgramOptions program_options(lower::KernelCache* cache) const;
    /// Prints why a compilation of the fablets failed. Returns an exit code.
    int report(const lower::Fault& fault) const { return report_fault(fault, sources_, common_); }
    const source::SourceManager& sources() const { return sources_; }
    const Schedules& schedules() const { return schedules_; }
    /// Prints the time that a step took, if --time was given.
    void report_time(const std::string& step, double seconds) const;
    /// Likewise for kernels.
    void report_kernels(const std::vector<lower::KernelTime>& kernels) const;

  private:
    /// One source file. Units point into it, so it does not move.
    struct SourceUnit {
        ir::Module module;
        std::vector<passes::PipelineResult> results;
    };

    int run_front_end();
    int run_all_passes();
    std::vector<openfab_isa> isas() const;
    /// Reports that a fablet is too long. Returns an exit code.
    int refuse(const ir::Fablet& fablet, size_t operations) const;

    const CompilationOptions& options_;
    const CommonOptions& common_;
    source::SourceManager sources_;
    std::deque<SourceUnit> units_;
    std::vector<lower::FabletUnit> fablets_;
    Schedules schedules_{&sources_, common_};
};

}  // namespace openfab::driver

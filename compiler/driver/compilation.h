// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Source files to stages that are ready to compile, for `build` and `run`.

#include <deque>
#include <string>
#include <vector>

#include "compiler/diag/sink.h"
#include "compiler/driver/back_end.h"
#include "compiler/driver/commands.h"
#include "compiler/driver/schedules.h"
#include "compiler/lower/code/program.h"
#include "compiler/passes/pipeline.h"

namespace openfab::driver {

/// Returns lines of how long each kernel took that was compiled, and how many were not.
std::string kernel_report(const std::vector<lower::KernelTime>& kernels);

class Compilation {
  public:
    /// The options must outlive this object.
    Compilation(const CompilationOptions& options, const CommonOptions& common)
        : options_(options), common_(common) {}

    /// What the front end and the passes have to say.
    struct Outcome {
        int code = 0;       ///< the exit code
        diag::Sink sink;    ///< errors and warnings with a place
        std::string fault;  ///< an error without one; empty where there is none
    };
    /// Runs the front end and the passes, and prints nothing but what options ask for, and errors
    /// of schedules.
    Outcome run();
    /// Does the same and prints what there is to say. Returns the exit code.
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
        std::vector<std::vector<int32_t>> directions;  ///< of each fablet
    };

    void run_front_end(Outcome* out);
    void refuse_equal_names(Outcome* out);
    void take_derivatives(Outcome* out);
    void run_all_passes(Outcome* out);
    std::vector<openfab_isa> isas() const;

    const CompilationOptions& options_;
    const CommonOptions& common_;
    source::SourceManager sources_;
    std::deque<SourceUnit> units_;
    std::vector<lower::FabletUnit> fablets_;
    Schedules schedules_{&sources_, common_};
};

}  // namespace openfab::driver

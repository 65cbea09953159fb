// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Source files to stages that are ready to be compiled: what `build` and `run` share.

#include <deque>
#include <string>
#include <vector>

#include "compiler/driver/back_end.h"
#include "compiler/driver/commands.h"
#include "compiler/lower/program.h"
#include "compiler/passes/pipeline.h"

namespace openfab::driver {

class Compilation {
  public:
    /// The options must outlive this object.
    Compilation(const CompilationOptions& options, const CommonOptions& common)
        : options_(options), common_(common) {}

    /// Front end and passes. An exit code; what is wrong was printed.
    int prepare();

    /// Of all files, after prepare.
    const std::vector<lower::FabletUnit>& fablets() const { return fablets_; }
    lower::ProgramOptions program_options() const;
    /// Prints why a compilation of the fablets failed; exit code.
    int report(const lower::Fault& fault) const {
        return report_fault(fault, schedule_, sources_, common_);
    }
    const source::SourceManager& sources() const { return sources_; }
    /// Prints the time of a phase where that is asked for.
    void spent(const char* phase, double seconds) const;

  private:
    /// One source file on its way. Units point into it, so it does not move.
    struct SourceUnit {
        ir::Module module;
        std::vector<passes::PipelineResult> results;
    };

    int front();
    int schedule();
    int middle();
    /// Says that a fablet is too long; exit code.
    int refuse(const ir::Fablet& fablet, size_t operations) const;

    const CompilationOptions& options_;
    const CommonOptions& common_;
    source::SourceManager sources_;
    std::deque<SourceUnit> units_;
    std::vector<lower::FabletUnit> fablets_;
    UserSchedule schedule_;
};

}  // namespace openfab::driver

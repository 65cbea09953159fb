// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A print whose fablets are compiled into this process, to be run in parts, again and again, with
// other kernels.

#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "compiler/driver/compilation.h"
#include "compiler/lower/code/jit.h"
#include "compiler/lower/code/kernel_cache.h"
#include "program/job.h"
#include "program/options.h"
#include "runtime/pipeline/print_job.h"

namespace openfab::tuner {

/// The options of a print that change what it computes, or how fast. Fails where one asks for
/// outputs or for a single voxel: nothing is kept of these prints. `outputs` are what the command
/// itself writes.
Result<program::Options> parse_print(const std::vector<std::string>& words,
                                     const std::string& program,
                                     std::vector<program::NamedOutput> outputs);

class Workload {
  public:
    /// Reads the world's fablets and the schedules, and runs all passes; where that fails it has been
    /// said, and the error has no message. Checks that outputs overwrite none of what it has read, as
    /// set_up does with all that the print reads.
    static Result<std::unique_ptr<Workload>> create(const program::Options& print,
                                                    const driver::ScheduleOptions& schedules);

    const program::Options& print() const { return print_; }
    const driver::Compilation& compilation() const { return *compilation_; }
    openfab_isa isa() const { return *print_.isa; }

    /// Returns the options of a program with the schedules of the command line.
    lower::ProgramOptions program_options() { return compilation_->program_options(cache_.get()); }
    /// Compiles all kernels.
    std::variant<std::unique_ptr<lower::LoadedProgram>, lower::Fault> compile(
        const lower::ProgramOptions& options) const {
        return lower::load_program(compilation_->fablets(), options);
    }
    /// The fablets with derivatives of their fractions, and by which values, by fablet.
    struct Derivatives {
        std::unique_ptr<lower::LoadedProgram> program;
        std::vector<std::vector<int32_t>> directions;
    };
    /// Compiles the fablets once more, with derivatives by uniforms, or elements of them, of these names. Null where a
    /// fablet has none, or jumps, so that sums of its derivatives are not those of its sums.
    std::unique_ptr<Derivatives> compile_derivatives(const std::vector<std::string>& names) const;
    /// Says what is wrong, and returns the error of it.
    Error report(const lower::Fault& fault) const;

    /// Binds the world to compiled fablets, which must outlive the job, and sets the print up.
    Result<std::unique_ptr<pipeline::PrintJob>> set_up(const openfab_fablet_list& fablets,
                                                       const std::atomic<bool>& interrupt);
    /// Opens an output of the print's format in a folder.
    Result<std::unique_ptr<pipeline::SliceSink>> open_sink(
        const std::filesystem::path& folder) const;

  private:
    Workload() = default;

    program::Options print_;
    driver::CompilationOptions options_;
    driver::CommonOptions common_;
    std::unique_ptr<driver::Compilation> compilation_;
    std::unique_ptr<lower::KernelCache> cache_;
    world::Printer printer_;
};

/// Puts the slab kernels of one program into another of the same fablets, whose prints run them from
/// now on.
void use_slab_kernels(const openfab_fablet_list& from, const openfab_fablet_list& to,
                      openfab_isa isa);

/// Returns `count` slabs of [range.x, range.y), rising: runs of `run` neighbours at equal distances, which
/// begin `shift` (0 to 1) of their distance above the lowest; all if there are no more.
std::vector<int32_t> spread_slabs(const Vec2<int32_t>& range, int32_t count, int32_t run,
                                  double shift);

}  // namespace openfab::tuner

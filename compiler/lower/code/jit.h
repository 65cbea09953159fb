// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fablets compiled into this process, for `openflc run` and tests: the kernels that `build` links,
// without files or a linker.

#include <deque>
#include <memory>
#include <variant>
#include <vector>

#include "compiler/lower/code/later_kernels.h"
#include "compiler/lower/code/load_code.h"
#include "compiler/lower/code/program.h"

namespace openfab::lower {

class LoadedProgram {
  public:
    LoadedProgram(const LoadedProgram&) = delete;
    LoadedProgram& operator=(const LoadedProgram&) = delete;

    /// Returns the fablets, valid while this object lives.
    const openfab_fablet_list& fablets() const { return list_; }
    /// Returns what each of its different kernels took to make, but for those that come later.
    const std::vector<KernelTime>& times() const { return times_; }
    /// Returns those that are compiled while it runs (ProgramOptions::bounds_later).
    LaterKernels& later() { return later_; }

  private:
    friend std::variant<std::unique_ptr<LoadedProgram>, Fault> load_program(
        const std::vector<FabletUnit>& fablets, const ProgramOptions& options);
    explicit LoadedProgram(KernelCache* cache) : later_(cache) {}

    std::deque<FabletData> data_;
    std::vector<LoadedKernel> kernels_;
    std::vector<KernelTime> times_;
    std::vector<const openfab_fablet*> tables_;
    openfab_fablet_list list_{};
    LaterKernels later_;  ///< last: it reads `data_` until it is gone
};

/// Loads the object of a kernel.
std::variant<LoadedKernel, Fault> load_kernel(const KernelUnit& unit, const KernelObject& object);

/// Compiles fablets into this process. The units may be destroyed afterwards; a cache must outlive
/// the program.
std::variant<std::unique_ptr<LoadedProgram>, Fault> load_program(
    const std::vector<FabletUnit>& fablets, const ProgramOptions& options = {});

}  // namespace openfab::lower

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fablets compiled into this process, for `openflc run` and tests: the kernels that `build` links,
// without files or a linker.

#include <deque>
#include <memory>
#include <variant>
#include <vector>

#include "compiler/lower/program.h"

namespace openfab::lower {

class LoadedProgram {
  public:
    LoadedProgram(const LoadedProgram&) = delete;
    LoadedProgram& operator=(const LoadedProgram&) = delete;

    /// Returns the fablets, valid while this object lives.
    const openfab_fablet_list& fablets() const { return list_; }

  private:
    friend std::variant<std::unique_ptr<LoadedProgram>, Fault> load_program(
        const std::vector<FabletUnit>& fablets, const ProgramOptions& options);
    LoadedProgram() = default;

    std::deque<FabletData> data_;
    std::vector<LoadedKernel> kernels_;
    std::vector<const openfab_fablet*> tables_;
    openfab_fablet_list list_{};
};

/// Compiles fablets into this process. The units may be destroyed afterwards.
std::variant<std::unique_ptr<LoadedProgram>, Fault> load_program(
    const std::vector<FabletUnit>& fablets, const ProgramOptions& options = {});

}  // namespace openfab::lower

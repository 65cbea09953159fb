// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fablets compiled and loaded into this process, for tests and `openflc run`: the very objects that
// `build` links, in a shared library of their own with a Halide runtime inside. Kernels return an
// error code where they fail; the library's halide_error keeps quiet.

#include <memory>
#include <variant>

#include "compiler/lower/program.h"

namespace openfab::lower {

class LoadedProgram {
  public:
    ~LoadedProgram();
    LoadedProgram(const LoadedProgram&) = delete;
    LoadedProgram& operator=(const LoadedProgram&) = delete;

    /// Valid while this object lives.
    const openfab_fablet_list& fablets() const { return *list_; }

  private:
    friend std::variant<std::unique_ptr<LoadedProgram>, Fault> load_program(
        const std::vector<FabletUnit>& fablets, const ProgramOptions& options);
    LoadedProgram() = default;

    void* library_ = nullptr;
    const openfab_fablet_list* list_ = nullptr;
};

std::variant<std::unique_ptr<LoadedProgram>, Fault> load_program(
    const std::vector<FabletUnit>& fablets, const ProgramOptions& options = {});

/// All fablets of a module through the whole pipeline; a fault of the passes is a Fault too.
std::variant<std::unique_ptr<LoadedProgram>, Fault> load_module(
    const ir::Module& module, const ProgramOptions& options = {},
    const passes::PipelineOptions& pipeline = {});

}  // namespace openfab::lower

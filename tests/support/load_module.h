// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fablets from IR to kernels in this process. Link openfab_lower.

#include <memory>
#include <variant>
#include <vector>

#include "compiler/lower/code/jit.h"

namespace openfab::testing {

/// Runs all passes on the fablets of a module and compiles them; errors of the passes are returned
/// as a Fault, too.
inline std::variant<std::unique_ptr<lower::LoadedProgram>, lower::Fault> load_module(
    const ir::Module& module, const lower::ProgramOptions& options = {}) {
    std::vector<passes::PipelineResult> results;
    results.reserve(module.fablets.size());
    std::vector<lower::FabletUnit> units;
    for (const ir::Fablet& fablet : module.fablets) {
        results.push_back(passes::run_pipeline(fablet));
        if (!results.back().fault.empty()) {
            lower::Fault fault;
            fault.trouble = results.back().fault;
            return fault;
        }
        units.push_back({&fablet, &results.back().stages, "", 0});
    }
    return lower::load_program(units, options);
}

}  // namespace openfab::testing

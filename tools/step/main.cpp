// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab-step FILE -o FILE.3mf`: makes triangles of the solids of a STEP file; `openfab import` executes this
// program. It is separate because it links OpenCASCADE, which not every machine has.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

#include "base/clean_exit.h"
#include "base/command_line.h"
#include "base/run_main.h"
#include "base/say.h"
#include "base/units.h"
#include "tools/step/messages.h"
#include "tools/step/solids_package.h"
#include "tools/step/step_solids.h"
#include "tools/texture/guarded.h"

namespace {

/// A jail lets a reader take twice its budget.
constexpr int64_t kOfBudget = 2;

int step_main(int argc, char** argv) {
    using openfab::Result;
    openfab::prepare_streams();
    openfab::clean_up_on_signals();
    std::string memory, input, output, tolerance;
    CLI::App app("Makes triangles of the solids of a STEP file; `openfab import` calls it.",
                 "openfab-step");
    app.add_option("FILE", input, "a .step or .stp file")->required();
    app.add_option("-o,--output", output, "the .3mf file")->required();
    app.add_option("--tolerance", tolerance, "how far triangles may be from surfaces (0.01mm)");
    app.add_option("--memory", memory, "how much it may take, like 2GB (default: 8GB)");
    return openfab::run_command_line(&app, argc, argv, "openfab-step", [&]() -> Result<void> {
        double mm = 0.01;
        if (!tolerance.empty()) {
            const Result<double> length = openfab::parse_length_mm(tolerance);
            if (!length) return openfab::usage_error("`--tolerance`: " + length.error().text());
            mm = *length;
        }
        const Result<int64_t> bytes = openfab::parse_memory_option(memory.empty() ? "8GB" : memory);
        if (!bytes) return bytes.error();
        if (!(mm > 0)) return openfab::usage_error(openfab::tools::messages::kToleranceAboveZero);
        return openfab::tools::guarded(
            *bytes / kOfBudget, input,
            [&]() -> Result<void> {
                const Result<openfab::tools::StepFile> solids =
                    openfab::tools::read_step(input, mm);
                if (!solids) return solids.error();
                for (const std::string& text : solids->notes)
                    openfab::note(text);
                return openfab::tools::write_solids(*solids, output);
            },
            output);
    });
}

}  // namespace

int main(int argc, char** argv) {
    return openfab::run_main(step_main, argc, argv);
}

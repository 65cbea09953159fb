// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab-vdb FILE -o FILE.vdb`: makes an OpenVDB file of a print or of fractions; `openfab export`
// executes this program. It is separate because it links OpenVDB, which not every machine has.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

#include "base/clean_exit.h"
#include "base/command_line.h"
#include "base/run_main.h"
#include "base/say.h"
#include "base/units.h"
#include "tools/vdb/convert.h"

namespace {

int vdb_main(int argc, char** argv) {
    using openfab::Result;
    openfab::prepare_streams();
    openfab::clean_up_on_signals();
    std::string input, output, memory;
    CLI::App app("Makes an OpenVDB file of a print or of fractions; `openfab export` calls it.",
                 "openfab-vdb");
    app.add_option("FILE", input, "an .ofr file, - for standard input, or an .npy of --fractions")
        ->required();
    app.add_option("-o,--output", output, "the .vdb file")->required();
    app.add_option("--memory", memory, "memory budget (default: 1.5GB)");
    return openfab::run_command_line(&app, argc, argv, "openfab-vdb", [&]() -> Result<void> {
        const Result<int64_t> bytes = openfab::parse_memory_option(memory);
        if (!bytes) return bytes.error();
        return input.ends_with(".npy")
                   ? openfab::tools::make_vdb_of_fractions(input, output, *bytes)
                   : openfab::tools::make_vdb_of_print(input, output, *bytes);
    });
}

}  // namespace

int main(int argc, char** argv) {
    return openfab::run_main(vdb_main, argc, argv);
}

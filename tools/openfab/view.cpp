// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab view FILE`: the viewer (tools/viewer) with the options of the command line.

#include "base/units.h"
#include "tools/openfab/commands.h"
#include "tools/openfab/programs.h"

namespace openfab::tools {

Result<void> run_view(ViewArguments arguments) {
    const Result<int64_t> memory = parse_memory_option(arguments.memory);
    if (!memory) return memory.error();
    Result<std::filesystem::path> programs = program_folder();
    if (!programs) return programs.error();
    arguments.view.memory_bytes = *memory;
    arguments.view.programs = *programs;
    return viewer::view(arguments.view);
}

}  // namespace openfab::tools

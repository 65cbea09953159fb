// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// From the command line to what the pipeline runs on: world or mesh, printer, fablets and uniforms
// joined.

#include <filesystem>
#include <string>
#include <vector>

#include "abi/fablet_table.h"
#include "program/options.h"
#include "runtime/pipeline/print.h"
#include "world/printer.h"
#include "world/world.h"

namespace openfab::print {

struct Job {
    slab::PrintInput input;
    scene::Printer printer;
    scene::Tray tray = scene::Tray::kAnywhere;
    std::vector<std::string> notes;            ///< for the person: what was chosen in their place
    std::vector<std::filesystem::path> files;  ///< what the world is made from
    /// These and all else that no output may take the place of: sources of fablets, the printer's
    /// file, the program.
    std::vector<std::filesystem::path> inputs;
};

Result<Job> load_job(const Options& options, const openfab_fablet_list& fablets);

}  // namespace openfab::print

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Turns the command line into the input of the pipeline: world or mesh, printer, fablets and
// uniforms joined.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "abi/fablet_table.h"
#include "program/options.h"
#include "runtime/pipeline/print_job.h"
#include "runtime/process/effect.h"
#include "world/printer.h"
#include "world/world.h"

namespace openfab::program {

struct Job {
    pipeline::PrintInput input;
    world::Printer printer;
    std::vector<std::unique_ptr<process::Effect>> effects;  ///< of the machine
    world::Tray tray = world::Tray::kAnywhere;
    std::string printer_source;                      ///< the name or file of the printer
    std::vector<std::vector<std::string>> programs;  ///< commands that the world names
    std::vector<std::string> notes;                  ///< for the user: defaults that were chosen
    std::vector<std::filesystem::path> files;        ///< files of the world
    /// These and all other files that no output may overwrite: sources of fablets, the printer's
    /// file, the program.
    std::vector<std::filesystem::path> inputs;
};

/// Returns the dither rule that the world of the print names, with which kernels are compiled; none for a mesh.
Result<std::optional<world::DitherRef>> load_rule(const Options& options);

/// Returns the world and the files that it names, as they are known before any of them is read; of a world with
/// mistakes itself alone.
std::vector<std::filesystem::path> named_files(const Options& options);

/// Reads the world, or makes one of a mesh; what stands by its box stands by what its fablet makes.
Result<world::World> load_whole_world(const Options& options, const openfab_fablet_list& fablets);

/// `kept`, where it is not null, receives what the parts were bound of.
Result<Job> load_job(const Options& options, const openfab_fablet_list& fablets,
                     world::World* kept = nullptr);

}  // namespace openfab::program

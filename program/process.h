// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The machine's process in a print: what of the printer's profile, of `--process` and of options changes
// voxels.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "program/options.h"
#include "runtime/pipeline/print_input.h"
#include "runtime/process/kind.h"
#include "world/printer.h"
#include "world/world.h"

namespace openfab::program {

/// Replaces items of the printer's process by those of `--process`, and leaves out what `--as-built` does.
Result<void> load_process_options(const Options& options, world::Printer* printer);

/// Scales what is built; the provenance goes to `input`.
void scale_build(const world::Process& process, world::World* world, pipeline::PrintInput* input);

/// Warns of prices under names that no material has, where a material has none.
void warn_of_costs(const world::Process& process, pipeline::PrintInput* input);

/// Returns the effects of the machine on the voxels of a print. The provenance goes to `input`, and names that fit
/// no material to its warnings.
Result<std::vector<std::unique_ptr<process::Effect>>> open_effects(const Options& options,
                                                                   const world::Printer& printer,
                                                                   pipeline::PrintInput* input);

/// Returns how materials are named.
std::vector<process::PrintMaterial> named_materials(const pipeline::PrintInput& input);

}  // namespace openfab::program

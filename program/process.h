// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The machine's process in a print: what of the printer's profile, of `--process` and of `--nozzles`
// changes voxels.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "program/options.h"
#include "runtime/pipeline/print_input.h"
#include "runtime/process/bleed/bleed.h"
#include "runtime/process/nozzles/nozzles.h"
#include "world/printer.h"
#include "world/world.h"

namespace openfab::program {

/// Replaces items of the printer's process by those of `--process`, and leaves out what `--as-built` does.
Result<void> load_process_options(const Options& options, world::Printer* printer);

/// Scales what is built; the provenance goes to `input`.
void scale_build(const world::Process& process, world::World* world, pipeline::PrintInput* input);

/// Returns the code of a material by its name, or its channel; 0 where there is none.
uint8_t material_code(const std::vector<pipeline::SliceMaterial>& materials,
                      const std::string& name);

/// Returns the end of a message about a name that none of the materials has.
std::string suggest_material(const std::vector<pipeline::SliceMaterial>& materials,
                             const std::string& name);

/// Warns of prices under names that no material has, where a material has none.
void warn_of_costs(const world::Process& process, pipeline::PrintInput* input);

/// Returns what the print's materials do to each other, null where they do nothing that `--bleed` asks
/// about. The provenance goes to `input`, and names that fit no material to its warnings.
Result<std::shared_ptr<const process::Bleed>> open_bleed(const Options& options,
                                                         const world::Printer& printer,
                                                         pipeline::PrintInput* input);

/// Returns the dead nozzles of a print, null where there are none and no `--nozzles`, which is read
/// again where it has changed. The provenance goes to `input`, and names that fit no material to its warnings.
Result<std::shared_ptr<process::NozzleSource>> open_nozzles(const Options& options,
                                                            const world::Printer& printer,
                                                            pipeline::PrintInput* input);

}  // namespace openfab::program

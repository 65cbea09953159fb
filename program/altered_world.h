// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A world that options alter once it is read, so that no program has to write another one: one object of it
// alone (`--only-object`), in the grid of the whole build; a box of an object's fablet in place of the build;
// a texture that is another file.

#include "abi/fablet_table.h"
#include "base/result.h"
#include "program/options.h"
#include "runtime/pipeline/print_input.h"
#include "world/world.h"

namespace openfab::program {

/// Alters the world. An object that is printed alone and that the build does not have is placed where its
/// mesh lies: last, beside the grid.
Result<void> alter_world(const Options& options, const openfab_fablet_list& fablets,
                         world::World* world, pipeline::PrintInput* input);

/// Marks what is printed, of parts in the order of the build.
void print_only(const Options& options, const world::World& world, pipeline::PrintInput* input);

}  // namespace openfab::program

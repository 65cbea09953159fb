// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The displacement field of the machine's process: where the machine builds what it was sent, as it was
// measured, whose inverse is sent instead.

#include "base/result.h"
#include "program/options.h"
#include "runtime/pipeline/print_input.h"
#include "world/process.h"
#include "world/world.h"

namespace openfab::program {

/// Moves what is built. The provenance goes to `input`.
Result<void> displace_build(const world::Process& process, const Options& options,
                            world::World* world, pipeline::PrintInput* input);

}  // namespace openfab::program

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Checks that a print fits the printer.

#include <vector>

#include "base/result.h"
#include "runtime/part/part.h"
#include "runtime/pipeline/slice_sink.h"
#include "world/printer.h"
#include "world/world.h"

namespace openfab::program {

/// Fails for prints larger than the build volume, with the excess. Where the world's coordinates
/// are those of the tray, also for parts beside or below it, by name. Otherwise the printer's front
/// end places the print where it fits, its lowest slice on the bed.
Result<void> check_build_volume(const pipeline::PrintInfo& info, const world::Printer& printer,
                                const std::vector<part::Part>& parts, world::Tray tray);

/// Returns the build volume in build space; kAnywhere is treated as kCorner.
Box3d tray_box(const world::Printer& printer, world::Tray tray);

}  // namespace openfab::program

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether a print fits the printer.

#include <vector>

#include "base/result.h"
#include "runtime/part/part.h"
#include "runtime/pipeline/slice_sink.h"
#include "world/printer.h"
#include "world/world.h"

namespace openfab::print {

/// Refuses what is larger than the printer builds, with the excess. Where the world's places are
/// those of the tray, also what stands beside it or below, and names the part. Elsewhere the
/// printer's front end puts the print where it fits, its lowest slice on the bed.
Result<void> check_build_volume(const backends::PrintInfo& info, const scene::Printer& printer,
                                const std::vector<scene::Part>& parts, scene::Tray tray);

/// What the printer builds, in build space; anywhere is as the corner.
Box3d tray_box(const scene::Printer& printer, scene::Tray tray);

}  // namespace openfab::print

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Worlds of trays: what a build holds, whole objects and pieces, each in its place on one of as many trays
// as it takes.

#include <string>
#include <vector>

#include "base/result.h"
#include "tools/openfab/machine_tray.h"
#include "tools/openfab/trays.h"
#include "world/edit/world_edit.h"
#include "world/world.h"

namespace openfab::tools {

struct TrayOptions {
    MachineTray machine;
    double gap_mm = 5;
    Turns turns = Turns::kAll;
    std::string output;     ///< of the first tray; the next are NAME-2.fab.json, …
    std::string misplaced;  ///< what helps a thing that fits no tray
};

/// Returns an error unless `output` is the name of another world beside `world`, which can name the same files.
Result<void> check_beside(const std::string& output, const std::string& world);

/// Returns `pieces` of `pieces.fab.json`.
std::string world_stem(const std::string& output);

/// Writes a world for each tray; `text` is what `world` was read from. What was cut comes in pieces.
Result<void> write_tray_worlds(const world::World& world, const world::WorldEdit& text,
                               const TrayOptions& options);

}  // namespace openfab::tools

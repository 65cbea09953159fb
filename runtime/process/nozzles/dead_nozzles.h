// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Nozzles that give no drops, as a profile or the file of `--nozzles` has them.

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "world/json_reader.h"

namespace openfab::process {

/// Nozzles of a head that give no drops, and what is printed in place of their material.
struct DeadNozzles {
    std::string material, substitute;
    std::vector<Vec2<int32_t>> nozzles;  ///< ranges, both ends included
    int32_t head = 0;                    ///< nozzles of the head; 0: as many as there are rows
    int32_t passes = 1;                  ///< that rows of the tray take turns in
    int32_t pass = -1;                   ///< the one that these are of; -1: all of them
    int32_t jog = 0;                     ///< rows that the head moves from one layer to the next
};

/// Reads an array of them; an error goes to `json`.
std::vector<DeadNozzles> read_dead_nozzles(const JsonValue& value, world::JsonReader* json);
Result<std::vector<DeadNozzles>> load_dead_nozzles(const std::filesystem::path& file);

}  // namespace openfab::process

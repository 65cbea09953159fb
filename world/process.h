// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a machine is known to do to a print: the `process` of a printer's profile, or the file of
// `--process`. Each item is off unless it is given. Materials are named as in worlds, or by channel.

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/json.h"
#include "base/result.h"
#include "base/vec.h"

namespace openfab::world {

class JsonReader;

/// A number for each material: those that are named, and the others (`*`).
struct ByMaterial {
    std::map<std::string, double> named;
    std::optional<double> others;

    bool empty() const { return named.empty() && !others; }
};

struct Cost {
    std::string currency = "EUR";
    ByMaterial price_ml;        ///< of what lands, and of waste
    ByMaterial waste_ml_swath;  ///< that a pass of the head over the tray wastes of each material
    double swath_mm = 0;        ///< that a pass covers along y; 0: all of it
    int32_t passes = 1;         ///< over each swath in a layer
    double seconds_pass = 0;
    std::optional<double> seconds_layer;  ///< besides passes
};

/// Nozzles of a head that give no drops, and what is printed in place of their material.
struct DeadNozzles {
    std::string material, substitute;
    std::vector<Vec2<int32_t>> nozzles;  ///< ranges, both ends included
    int32_t head = 0;                    ///< nozzles of the head; 0: as many as there are rows
    int32_t passes = 1;                  ///< that rows of the tray take turns in
    int32_t pass = -1;                   ///< the one that these are of; -1: all of them
    int32_t jog = 0;                     ///< rows that the head moves from one layer to the next
};

/// How far two materials run into each other before they set.
struct PairBleed {
    std::string a,
        b;  ///< `void` is where nothing is printed; `*` all materials that no other entry has
    Vec3d sigma_um;
};

struct Bleed {
    Vec3d sigma_um;  ///< of pairs that are not listed, void not among them
    std::vector<PairBleed> pairs;
    int32_t steps = 2;  ///< in which it is undone
};

/// What `openfab check` finds fault with. Of a material alone where it is named, of all that is solid
/// where `*` is.
struct Checks {
    ByMaterial wall_mm, gap_mm, hole_mm;  ///< thinner ones
    ByMaterial island_mm3;                ///< loose ones that are smaller
    std::optional<double> trapped_mm3;    ///< larger voids and larger support that cannot get out
    std::vector<std::pair<std::string, std::string>> apart;  ///< must not touch
};

struct Process {
    std::filesystem::path field;  ///< how far what is built is displaced; empty: not
    Vec3d scale{1, 1, 1};         ///< of all that is built, about `about_mm`
    Vec3d about_mm{0, 0, 0};      ///< in build space
    std::vector<DeadNozzles> dead;
    std::optional<Cost> cost;
    std::optional<Bleed> bleed;
    std::optional<Checks> checks;
};

/// Reads the object; an error goes to `json`.
/// `folder`: that files are named from.
void read_process(const JsonValue& value, const std::filesystem::path& folder, JsonReader* json,
                  Process* out);

/// Reads the file of `--process`, whose items replace those of `profile`.
Result<Process> load_process(const std::filesystem::path& file, const Process& profile);

/// Reads nozzles alone from a file of `--nozzles`: an array as under `dead`.
Result<std::vector<DeadNozzles>> load_dead_nozzles(const std::filesystem::path& file);

}  // namespace openfab::world

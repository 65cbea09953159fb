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
#include <string_view>
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

/// What the effects on voxels read (runtime/process/kinds).
struct ProcessEntry {
    JsonMember member;
    std::string file;
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
    std::optional<Cost> cost;
    std::optional<Checks> checks;
    std::vector<ProcessEntry> effects;  ///< all other entries
};

/// The largest file of a process, or of an entry of it.
constexpr int64_t kLargestProcess = 4'000'000;

/// Returns the keys that are no effects'.
std::vector<std::string_view> process_keys();

/// Reads the object of a file; an error goes to `json`.
void read_process(const JsonValue& value, const std::filesystem::path& file, JsonReader* json,
                  Process* out);

/// Reads the file of `--process`, whose items replace those of `profile`.
Result<Process> load_process(const std::filesystem::path& file, const Process& profile);

}  // namespace openfab::world

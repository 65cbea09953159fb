// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Printer profiles: built in, or read from a `NAME.printer.json` file.

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "world/process.h"

namespace openfab::world {

/// The material of support, where the slices contain it.
struct SupportMaterial {
    std::string name = "support";
    std::array<uint8_t, 4> key{0xff, 0xc8, 0x28, 0xff};
    std::array<uint8_t, 4> preview{0xff, 0xe6, 0xa0, 0x60};
    double density_g_cm3 = 1.18;
    std::string channel = "support";
};

/// An ink that a printer's maker sells for it.
struct Ink {
    std::string name;
    double density_g_cm3 = 0;  ///< 0: unknown
};

/// How far a document that a profile cites was seen by who wrote the profile.
enum class Seen : uint8_t { kRead, kQuoted, kUnread };

/// A public document, and the keys of the profile that are taken from it.
struct PrinterSource {
    std::string document;
    std::string url;  ///< empty: none
    Seen seen = Seen::kRead;
    std::vector<std::string> gives;
};

struct Printer {
    std::string name;
    std::string maker, model;                 ///< empty: no machine of a maker
    Vec3d pitch_mm{0.1, 0.1, 0.1};            ///< 0: unknown along that axis
    std::vector<double> layers_um;            ///< all that the machine builds; empty: not listed
    Vec3d build_volume_mm{1000, 1000, 1000};  ///< 0: unknown
    int32_t max_materials = 254;
    std::string native_format = "ofr";  ///< see backends/formats; whoever opens an output checks it
    std::vector<std::string> formats;   ///< that the front end takes; empty: not listed
    /// The machine chooses inks by the colours of a mesh's faces, so that a 3MF has those of mixtures.
    bool mesh_colors = false;
    std::vector<Ink> inks;
    bool makes_support = true;  ///< the printer's front end adds support, so slices contain none
    SupportMaterial support_material;
    double layer_time_s = 0;  ///< 0: unknown
    Process process;
    std::string handoff;  ///< text for the operator, in HANDOFF.txt
    std::vector<PrinterSource> sources;
    /// What is not known, and why.
    std::vector<std::pair<std::string, std::string>> unknown;

    bool knows_pitch() const { return pitch_mm.x > 0 && pitch_mm.y > 0 && pitch_mm.z > 0; }
    bool knows_build_volume() const { return build_volume_mm.x > 0; }
};

/// Returns the names of the built-in profiles, sorted.
std::vector<std::string> printer_names();

/// Loads a printer by name or by path of a `.printer.json` file.
Result<Printer> load_printer(const std::string& name_or_path);

}  // namespace openfab::world

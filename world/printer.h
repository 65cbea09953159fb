// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Printer profiles: built in, or read from a `NAME.printer.json` file.

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/vec.h"

namespace openfab::world {

/// The material of support, where the slices contain it.
struct SupportMaterial {
    std::string name = "support";
    std::array<uint8_t, 4> key{0xff, 0xc8, 0x28, 0xff};
    std::array<uint8_t, 4> preview{0xff, 0xe6, 0xa0, 0x60};
    double density_g_cm3 = 1.18;
    std::string channel = "support";
};

struct Printer {
    std::string name;
    Vec3d pitch_mm{0.1, 0.1, 0.1};
    Vec3d build_volume_mm{1000, 1000, 1000};
    int32_t max_materials = 64;
    std::string native_format = "ofr";  ///< see backends/formats; whoever opens an output checks it
    bool makes_support = true;  ///< the printer's front end adds support, so slices contain none
    SupportMaterial support_material;
    double layer_time_s = 0;  ///< 0: unknown
    std::string handoff;      ///< text for the operator, in HANDOFF.txt
};

/// Returns the names of the built-in profiles, sorted.
std::vector<std::string> printer_names();

/// Loads a printer by name (`connex500`, `j750`, `j750_hq`, `filament`, `generic`) or by path of a
/// `.printer.json` file.
Result<Printer> load_printer(const std::string& name_or_path);

}  // namespace openfab::world

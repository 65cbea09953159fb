// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Optical properties of a print's materials: what light meets in the voxels, for red, green and blue
// (linear light with the primaries of sRGB), and the outer surface. They come from a file
// (`openfab_optics`), the built-in one unless told; a material that is in none is guessed from the
// colour of its previews.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::render {

using Rgb = std::array<double, 3>;

struct MaterialOptics {
    Rgb extinction{};       ///< per mm: absorption and scattering
    Rgb albedo{};           ///< share of the extinction that is scattering, 0 … 1
    double anisotropy = 0;  ///< mean cosine of the scattering angle (Henyey-Greenstein), -1 … 1
    bool operator==(const MaterialOptics&) const = default;
};

/// The boundary of resin and air. Resins of one print are taken to have one refractive index, so that
/// light bends at the outer surface alone.
struct SurfaceOptics {
    double refractive_index = 1;
    double roughness = 0;  ///< of a GGX distribution; 0: smooth
};

struct Optics {
    SurfaceOptics surface;
    std::vector<MaterialOptics> by_code;  ///< [0] void, then as the print's materials
    std::vector<std::string> guessed;     ///< names of materials that no file knows
};

/// A file that was read.
struct OpticsTable {
    struct Entry {
        std::vector<std::string> names;
        MaterialOptics optics;
    };
    SurfaceOptics surface;
    std::vector<Entry> entries;

    /// Returns the optics of a name, whose case does not count, or null.
    const MaterialOptics* find(const std::string& name) const;
};

/// Parses a file; errors are located in `name`.
Result<OpticsTable> parse_optics(const std::string& text, const std::string& name);
/// Returns the table that is compiled in.
const OpticsTable& builtin_optics();

/// Guesses from a preview's colour: a thick body behind that surface, smooth, looks like it (look_of_albedo).
MaterialOptics guess_optics(const std::array<uint8_t, 4>& preview, const SurfaceOptics& surface);

/// Looks all materials of a print up: in `own` (may be null), then in the built-in table.
Optics optics_of(const pipeline::PrintInfo& info, const OpticsTable* own);

/// Returns the optics of codes that are mixtures (Mixtures::by_code) of the print's materials `codes`: the mean of what
/// light meets.
Optics optics_of_mixtures(const Optics& optics, const std::vector<uint8_t>& codes,
                          const std::vector<std::vector<uint8_t>>& mixtures);

}  // namespace openfab::render

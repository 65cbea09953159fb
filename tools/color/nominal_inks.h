// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a print of given inks may look like before anything was measured: Kubelka and Munk's two
// fluxes of light in a layer of mixed materials over a white core, in three bands of light. The
// materials come from a table (CSV), `#` starts a comment:
//
//   material,absorption_r,absorption_g,absorption_b,scattering_r,scattering_g,scattering_b   1/mm
//   cyan,...   magenta,...   yellow,...   black,...   white,...

#include <array>
#include <filesystem>
#include <string_view>

#include "base/result.h"
#include "tools/color/samples.h"

namespace openfab::color {

class NominalInks {
  public:
    /// Parses the table; errors have a line but not the file's name.
    static Result<NominalInks> parse(std::string_view text);
    /// Reads a file; errors name it.
    static Result<NominalInks> read(const std::filesystem::path& file);

    /// Returns the colour of a skin of these amounts, the rest white, over a core of white that is
    /// as thick as light goes. What the surface mirrors is left out, as instruments do
    /// (45°:0°).
    Lab predict(const Inks& inks, double skin_mm) const;

  private:
    struct Band {
        double absorption = 0, scattering = 0;
    };
    static constexpr size_t kMaterials = 5;  ///< white is the last
    std::array<std::array<Band, 3>, kMaterials> bands_{};
};

}  // namespace openfab::color

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Filaments that slicers of 2026 mix of others, by layers or lines: their shares of volume. Three
// programs write them in three ways. Sources: BambuStudio and OrcaSlicer, PrintConfig.cpp
// (`filament_is_mixed`); Snapmaker's OrcaSlicer, MixedFilament.cpp (`mixed_filament_definitions`);
// PrusaSlicer 2.9.6, VirtualExtruder.cpp.

#include <string_view>

#include "base/json.h"
#include "mesh/read/threemf_project.h"

namespace openfab::mesh {

/// Gives filaments of the settings of Bambu Studio, OrcaSlicer and Snapmaker's OrcaSlicer their
/// mixtures; the last one's are filaments behind the others. What is no mixture of them, and
/// gradients, are told.
void mix_filaments(const JsonValue& settings, std::string_view place,
                   std::vector<ThreemfFilament>* filaments, ThreemfTold* told);

/// The same of PrusaSlicer's virtual extruders.
void mix_extruders(const JsonValue& spectrum, std::string_view place,
                   std::vector<ThreemfFilament>* filaments, ThreemfTold* told);

}  // namespace openfab::mesh

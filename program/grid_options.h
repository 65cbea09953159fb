// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The voxels of a print: how large they are, and which of them are printed.

#include <cstdint>
#include <optional>

#include "base/vec.h"

namespace openfab::program {

/// Default pitch of the voxels that meshes are made from.
constexpr double kMeshPitchMm = 0.1;

struct GridOptions {
    std::optional<double> voxel_mm;
    std::optional<Vec2<double>> dpi;
    std::optional<double> layer_mm;
    std::optional<double> mesh_pitch_mm;  ///< for stl and 3mf
    std::optional<Vec3d> pitch_mm;        ///< of a print that was made already; no draft of it
    std::optional<Vec3d> probe_mm;        ///< evaluate the voxel at this point of build space alone
    int32_t draft = 1;
    std::optional<Vec2<double>> z_range_mm;
    std::optional<Vec2<int32_t>> slices;
    std::optional<Vec2<int32_t>> part;  ///< x-th of y parts of the slices
    bool any_pitch =
        false;  ///< what a printer's profile does not know of its pitch is as for meshes
    bool crop_tray = false;  ///< the grid is the tray, not the box of the parts
};

/// Returns whether any option sets a pitch.
bool pitch_is_given(const GridOptions& options);

/// Returns the pitch of a print: from the options, else the printer's, times --draft. Printers that
/// take meshes do not print the voxels these are made from, so meshes have a pitch of their own.
Vec3d print_pitch(const GridOptions& options, const Vec3d& printer_pitch_mm,
                  bool to_meshes = false);

}  // namespace openfab::program

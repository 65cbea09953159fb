// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/grid_options.h"

namespace openfab::program {

bool pitch_is_given(const GridOptions& options) {
    return options.voxel_mm || options.dpi || options.layer_mm || options.pitch_mm;
}

Vec3d print_pitch(const GridOptions& options, const Vec3d& printer_pitch_mm, bool to_meshes) {
    if (options.pitch_mm) return *options.pitch_mm;
    Vec3d pitch = printer_pitch_mm;
    if (to_meshes && !pitch_is_given(options)) {
        const double mm = options.mesh_pitch_mm.value_or(kMeshPitchMm);
        pitch = {mm, mm, mm};
    }
    if (options.voxel_mm) pitch = {*options.voxel_mm, *options.voxel_mm, *options.voxel_mm};
    if (options.dpi) {
        pitch.x = 25.4 / options.dpi->x;
        pitch.y = 25.4 / options.dpi->y;
    }
    if (options.layer_mm) pitch.z = *options.layer_mm;
    return pitch * static_cast<double>(options.draft);
}

}  // namespace openfab::program

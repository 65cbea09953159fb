// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Grids that a file places in space by any affine map, as scanners and simulations do. A texture lies
// along the axes: what is merely mirrored or has its axes exchanged is put in order, what is turned is
// sampled anew.

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "texture/volume.h"
#include "tools/texture/volume_reader.h"

namespace openfab::tools {

/// Where texels lie, mm.
struct GridFrame {
    Vec3d first;                 ///< the centre of texel (0, 0, 0)
    std::array<Vec3d, 3> steps;  ///< from a texel to the next along each index
};

/// Returns whether each step runs along an axis of its own, so that taking it as straight moves no texel of a
/// grid of this size by more than 1e-4 of a texel, beside rounding of direction cosines to 1e-7.
bool is_along_axes(const GridFrame& frame, const Vec3i& size);

/// The size in mm of one of the options' unit; 1 where they name none.
double unit_mm(const texture::VolumeOptions& options);

/// The box of texels that a resampled volume has.
struct ResampledBox {
    Vec3d origin;  ///< lowest corner
    double pitch_mm = 1;
    Vec3i size;

    Vec3d center(int32_t x, int32_t y, int32_t z) const {
        return {origin.x + (x + 0.5) * pitch_mm, origin.y + (y + 0.5) * pitch_mm,
                origin.z + (z + 0.5) * pitch_mm};
    }
    /// Sets the reader's size and place.
    void place(VolumeReader* reader) const;
};

/// Returns the box with texels of `pitch_mm` that covers `box`. Fails where it has too many.
Result<ResampledBox> resampled_box(const Box3d& box, double pitch_mm);

/// Places a reader of the file's texels: as it is, slice by slice, where the steps rise along x, y and
/// z; else its values are read into memory, for open_placed_grid.
MadeReader place_reader(std::unique_ptr<VolumeReader> reader, const GridFrame& frame,
                        const texture::VolumeOptions& options, const texture::ReadLimits& limits);

/// Reads a grid whose values lie in memory: channels innermost, then x, y, z of the file. One that is
/// turned is interpolated between the centres of its texels, at `pitch_mm` of the options or the least
/// of its steps. A texel beyond the outermost one continues it, so that look-ups within the grid are of the
/// grid alone; points farther out have `outside`, or `beyond` where the options give none. Fails where a
/// step is 0 or the steps lie in a plane.
MadeReader open_placed_grid(const Vec3i& size, int32_t channels, std::vector<float> values,
                            const GridFrame& frame, const texture::VolumeOptions& options,
                            std::array<float, 4> beyond = {});

}  // namespace openfab::tools

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The layout of the levels of a pyramid, of a picture or a volume, and the filter that makes them.
// One implementation serves the file writer and pyramids in memory, so that both have the same
// bits.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "base/result.h"
#include "base/vec.h"

namespace openfab::texture {

/// The box that a volume covers in the coordinates it is sampled in, mm for a fablet.
struct VolumeDomain {
    std::array<float, 3> origin{};         ///< the lowest corner
    std::array<float, 3> extent{1, 1, 1};  ///< size along each axis, above 0
    /// A look-up table: read from the finest level alone, clamped at its ends.
    bool table = false;
};

/// What lies beyond a picture along u and along v: values of world::Wrap. A volume has one for all
/// axes.
struct WrapModes {
    int32_t u = 0, v = 0;
    constexpr WrapModes(int32_t both) : u(both), v(both) {}  // NOLINT(*-explicit-*): the usual case
    constexpr WrapModes(int32_t along_u, int32_t along_v) : u(along_u), v(along_v) {}
};

struct PyramidLayout {
    struct Level {
        int64_t texels = 0;  ///< offset of the level in floats
        int32_t width = 0;
        int32_t height = 0;
        int64_t minmax = 0;  ///< offset in the min-max floats: twice `texels`
        int32_t depth = 1;
    };
    int32_t channels = 0;
    bool alpha = false;  ///< the last channel of a picture is alpha, its colours are as on white
    std::vector<Level> levels;
    int64_t texel_floats = 0;
    int64_t minmax_floats = 0;
    std::optional<VolumeDomain> volume;  ///< absent for a picture
};

/// Lays out a picture. Fails for sizes that are not positive, for other than 1 to 4 channels, for a
/// side above 16384, and where the min-max floats no longer have 31-bit offsets (16384 x 16384 with
/// 4 channels).
Result<PyramidLayout> pyramid_layout(int32_t width, int32_t height, int32_t channels);

/// Lays out a volume of size.x by size.y by size.z; x is innermost.
Result<PyramidLayout> volume_layout(const Vec3i& size, int32_t channels,
                                    const VolumeDomain& domain);

/// Fills the levels above level 0 of `texels`, and all of `minmax`. Texel i of a level covers the
/// interval [i n / m, (i + 1) n / m) of the n texels below for its own m, so that means are kept
/// for odd sizes too; its min-max covers every texel that it touches. Calls `wrote` for every few
/// thousand bytes written.
void fill_pyramid(const PyramidLayout& layout, float* texels, float* minmax,
                  const std::function<void(int64_t bytes)>& wrote = {});

/// Returns the int32 block that kernels read (pyramid.h).
std::vector<int32_t> pyramid_info(const PyramidLayout& layout, WrapModes wrap, int32_t filter);

}  // namespace openfab::texture

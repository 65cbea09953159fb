// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A filtered texture pyramid (`.oftx`), memory-mapped. `openfab texture` (OpenImageIO) makes it
// once per image; it is cached by content hash. Generated code and the interpreter read the same
// arrays.
//
//   texels   float, linear values, level after level; within a level row-major from the BOTTOM row
//            (v = 0), channels interleaved: texels[offset + (y * width + x) * channels + c]
//   info     int32: [0] channels, [1] levels, [2] wrap along u (world::Wrap), [3] filter
//            (world::Filter), [4] 0, [5] wrap along v, [6] 1 if the last channel is alpha, [7]
//            reserved 0, then for each level 4 values: texel offset, width, height, min-max offset.
//            A volume has the value of a texel at texels[offset + ((z * height + y) * width + x) *
//            channels + c]; [4] is 1, the header is followed by 6 floats as bits, the lowest corner
//            and the size in mm (kVolumeInfoHeader in all), and a level has 5 values: texel offset,
//            width, height, depth, min-max offset. Filter kFilterFinest reads level 0 alone.
//   minmax   float: for each level l, per texel and channel the least and greatest level-0 value
//            under it: minmax[offset + ((y * width + x) * channels + c) * 2 + {0, 1}]; level 0
//            holds its texel twice
// Level 0 is the image; level l+1 has ceil(n / 2) texels a side, down to 1 x 1, each the mean over
// its footprint in the level below (fractions of texels for odd n); its min-max covers
// every texel that the footprint touches.
// Colours of a picture with alpha a are stored as they look on white, a c + (1 - a). That is linear in
// a and in a c, so that means and interpolation are those of premultiplied colours; colours below
// full transparency are not in it. A lookup finds c again where it is asked for (texture/sample.h).

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "texture/pyramid_layout.h"

namespace openfab::texture {

constexpr int32_t kInfoHeader = 8;
constexpr int32_t kInfoPerLevel = 4;
constexpr int32_t kInfoWrapV = 5;
constexpr int32_t kInfoAlpha = 6;
constexpr int32_t kVolumeInfoHeader = 14;
constexpr int32_t kVolumeInfoPerLevel = 5;
// Values of world::Wrap and world::Filter.
constexpr int32_t kWrapRepeat = 1;
constexpr int32_t kWrapMirror = 2;
constexpr int32_t kWrapBlack = 3;
constexpr int32_t kFilterTrilinear = 0;
constexpr int32_t kFilterNearest = 2;
constexpr int32_t kFilterFinest = 3;  ///< trilinear, for look-up tables

/// Returns where the notes of a pyramid's converter lie: beside it, a line each, if there are any.
std::filesystem::path notes_file(const std::filesystem::path& pyramid);

class Pyramid {
  public:
    /// Maps a file; wrap and filter come from the world, not from the file.
    static Result<std::shared_ptr<const Pyramid>> open(const std::filesystem::path& file,
                                                       WrapModes wrap, int32_t filter);
    /// Makes a pyramid in memory from level 0 (bottom row first, interleaved), without alpha. For
    /// tests and small pictures. Null where the size is not possible or `level0` has another number of values.
    static std::shared_ptr<const Pyramid> from_texels(int32_t width, int32_t height,
                                                      int32_t channels,
                                                      std::span<const float> level0, WrapModes wrap,
                                                      int32_t filter);
    /// Same for a volume.
    static std::shared_ptr<const Pyramid> from_volume(const Vec3i& size, int32_t channels,
                                                      const VolumeDomain& domain,
                                                      std::span<const float> level0, WrapModes wrap,
                                                      int32_t filter);
    ~Pyramid();
    Pyramid(const Pyramid&) = delete;
    Pyramid& operator=(const Pyramid&) = delete;

    std::span<const float> texels() const { return texels_; }
    std::span<const int32_t> info() const { return info_; }
    std::span<const float> minmax() const { return minmax_; }
    int32_t channels() const { return info_[0]; }
    int32_t levels() const { return info_[1]; }
    bool is_volume() const { return info_[4] != 0; }
    /// What the converter told of the file that this was made of (notes_file).
    const std::vector<std::string>& notes() const { return notes_; }

  private:
    Pyramid() = default;
    static std::shared_ptr<const Pyramid> fill(const PyramidLayout& layout,
                                               std::span<const float> level0, WrapModes wrap,
                                               int32_t filter);

    std::vector<int32_t> info_;
    std::vector<std::string> notes_;
    std::vector<float> owned_;
    void* mapping_ = nullptr;
    size_t mapping_bytes_ = 0;
    std::span<const float> texels_;
    std::span<const float> minmax_;
};

}  // namespace openfab::texture

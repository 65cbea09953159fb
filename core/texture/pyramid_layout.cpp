// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "texture/pyramid_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include "base/infinity.h"
#include "texture/messages.h"
#include "texture/pyramid.h"

namespace openfab::texture {
namespace {

constexpr int32_t kLargestSide = 16384;
// Values of world::Wrap and world::Filter.
constexpr int32_t kWrapOfTables = 0;

/// The texels of the level below that one texel averages along one axis: at most three, with
/// weights that sum to 1.
struct Taps {
    int32_t first = 0;
    int32_t count = 0;
    double weight[3]{};
};

std::vector<Taps> taps_for(int32_t below, int32_t above) {
    std::vector<Taps> taps(static_cast<size_t>(above));
    for (int64_t i = 0; i < above; ++i) {
        // In units of 1 / above texel: child j is [j above, (j + 1) above), the parent [i below, (i
        // + 1) below).
        const int64_t lo = i * below;
        const int64_t hi = lo + below;
        Taps& t = taps[i];
        t.first = static_cast<int32_t>(lo / above);
        for (int64_t j = t.first; j * above < hi; ++j) {
            const int64_t overlap = std::min(hi, (j + 1) * above) - std::max(lo, j * above);
            t.weight[t.count++] = static_cast<double>(overlap) / static_cast<double>(below);
        }
    }
    return taps;
}

/// The filter of one level, along x, y and z.
std::array<std::vector<Taps>, 3> taps_between(const PyramidLayout::Level& below,
                                              const PyramidLayout::Level& above) {
    return {taps_for(below.width, above.width), taps_for(below.height, above.height),
            taps_for(below.depth, above.depth)};
}

using Wrote = std::function<void(int64_t bytes)>;

/// Calls visit(x taps, y taps, z taps) for each texel of a level in order, and `wrote` after each
/// row.
template <typename Visit>
void each_texel(const std::array<std::vector<Taps>, 3>& taps, int64_t texel_bytes,
                const Wrote& wrote, const Visit& visit) {
    const int64_t row_bytes = static_cast<int64_t>(taps[0].size()) * texel_bytes;
    for (const Taps& tz : taps[2]) {
        for (const Taps& ty : taps[1]) {
            for (const Taps& tx : taps[0])
                visit(tx, ty, tz);
            if (wrote) wrote(row_bytes);
        }
    }
}

/// Texels from the first of the level to the first of a row.
int64_t row_start(const PyramidLayout::Level& level, int32_t y, int32_t z) {
    return (static_cast<int64_t>(z) * level.height + y) * level.width;
}

void filter_level(const PyramidLayout& layout, size_t level, float* texels, const Wrote& wrote) {
    const PyramidLayout::Level& below = layout.levels[level - 1];
    const PyramidLayout::Level& above = layout.levels[level];
    const int32_t channels = layout.channels;
    const float* from = texels + below.texels;
    float* to = texels + above.texels;
    each_texel(taps_between(below, above), 4 * channels, wrote,
               [&](const Taps& tx, const Taps& ty, const Taps& tz) {
                   for (int32_t c = 0; c < channels; ++c) {
                       double sum = 0;
                       for (int32_t k = 0; k < tz.count; ++k) {
                           double plane = 0;
                           for (int32_t j = 0; j < ty.count; ++j) {
                               const float* row =
                                   from +
                                   (row_start(below, ty.first + j, tz.first + k) + tx.first) *
                                       channels +
                                   c;
                               double along = 0;
                               for (int32_t i = 0; i < tx.count; ++i) {
                                   along += tx.weight[i] * static_cast<double>(row[i * channels]);
                               }
                               plane += ty.weight[j] * along;
                           }
                           sum += tz.weight[k] * plane;
                       }
                       *to++ = static_cast<float>(sum);
                   }
               });
}

void minmax_level(const PyramidLayout& layout, size_t level, float* minmax, const Wrote& wrote) {
    const PyramidLayout::Level& below = layout.levels[level - 1];
    const PyramidLayout::Level& above = layout.levels[level];
    const int32_t channels = layout.channels;
    const float* from = minmax + below.minmax;
    float* to = minmax + above.minmax;
    each_texel(
        taps_between(below, above), 8 * channels, wrote,
        [&](const Taps& tx, const Taps& ty, const Taps& tz) {
            for (int32_t c = 0; c < channels; ++c) {
                float least = kInfinity;
                float greatest = -kInfinity;
                for (int32_t k = 0; k < tz.count; ++k) {
                    for (int32_t j = 0; j < ty.count; ++j) {
                        const float* row =
                            from +
                            ((row_start(below, ty.first + j, tz.first + k) + tx.first) * channels +
                             c) *
                                2;
                        for (int32_t i = 0; i < tx.count; ++i) {
                            least = std::min(least, row[i * channels * 2]);
                            greatest = std::max(greatest, row[i * channels * 2 + 1]);
                        }
                    }
                }
                *to++ = least;
                *to++ = greatest;
            }
        });
}

/// Halves the sides until all are 1.
void add_levels(int32_t width, int32_t height, int32_t depth, PyramidLayout* layout) {
    for (;;) {
        layout->levels.push_back(
            {layout->texel_floats, width, height, layout->minmax_floats, depth});
        layout->texel_floats += static_cast<int64_t>(width) * height * depth * layout->channels;
        layout->minmax_floats = 2 * layout->texel_floats;
        if (width == 1 && height == 1 && depth == 1) return;
        width = (width + 1) / 2;
        height = (height + 1) / 2;
        depth = (depth + 1) / 2;
    }
}

uint32_t bits_of(float x) {
    return std::bit_cast<uint32_t>(x);
}

}  // namespace

Result<PyramidLayout> pyramid_layout(int32_t width, int32_t height, int32_t channels) {
    if (width < 1 || height < 1)
        return user_error(fmt::format(messages::kPictureEmpty, width, height));
    if (width > kLargestSide || height > kLargestSide) {
        return user_error(fmt::format(messages::kPictureTooWide, width, height),
                          fmt::format(messages::kPictureTooWideHelp, kLargestSide));
    }
    if (channels < 1 || channels > 4) {
        return user_error(fmt::format(messages::kPictureChannels, channels),
                          messages::kChannelsHelp);
    }
    PyramidLayout layout;
    layout.channels = channels;
    add_levels(width, height, 1, &layout);
    if (layout.minmax_floats > std::numeric_limits<int32_t>::max()) {
        return user_error(fmt::format(messages::kPictureTooLarge, layout.levels[0].width,
                                      layout.levels[0].height, channels),
                          messages::kPictureTooLargeHelp);
    }
    return layout;
}

Result<PyramidLayout> volume_layout(const Vec3i& size, int32_t channels,
                                    const VolumeDomain& domain) {
    const std::string shape = fmt::format("{} x {} x {}", size.x, size.y, size.z);
    int64_t texels = 1;
    for (int a = 0; a < 3; ++a) {
        if (size[a] < 1) return user_error(fmt::format(messages::kVolumeEmpty, shape));
        if (size[a] > kLargestSide)
            return user_error(fmt::format(messages::kVolumeTooWide, shape),
                              fmt::format(messages::kVolumeTooWideHelp, kLargestSide));
        texels *= size[a];
        const auto k = static_cast<size_t>(a);
        if (!(domain.extent[k] > 0) || !std::isfinite(domain.extent[k]) ||
            !std::isfinite(domain.origin[k])) {
            return user_error(messages::kVolumePlaceNotFinite);
        }
    }
    if (channels < 1 || channels > 4) {
        return user_error(fmt::format(messages::kVolumeChannels, channels),
                          messages::kChannelsHelp);
    }
    constexpr int64_t kMostTexels = int64_t{1} << 30;
    PyramidLayout layout;
    layout.channels = channels;
    layout.volume = domain;
    if (texels < kMostTexels) add_levels(size.x, size.y, size.z, &layout);
    if (texels >= kMostTexels || layout.minmax_floats > std::numeric_limits<int32_t>::max()) {
        return user_error(fmt::format(messages::kVolumeTooLarge, shape, channels),
                          messages::kVolumeTooLargeHelp);
    }
    return layout;
}

void fill_pyramid(const PyramidLayout& layout, float* texels, float* minmax, const Wrote& wrote) {
    const int64_t finest = layout.levels.size() > 1 ? layout.levels[1].texels : layout.texel_floats;
    constexpr int64_t kAtOnce = 1 << 16;
    for (int64_t begin = 0; begin < finest; begin += kAtOnce) {
        const int64_t end = std::min(begin + kAtOnce, finest);
        for (int64_t i = begin; i < end; ++i)
            minmax[2 * i] = minmax[2 * i + 1] = texels[i];
        if (wrote) wrote(8 * (end - begin));
    }
    for (size_t level = 1; level < layout.levels.size(); ++level) {
        filter_level(layout, level, texels, wrote);
        minmax_level(layout, level, minmax, wrote);
    }
}

std::vector<int32_t> pyramid_info(const PyramidLayout& layout, WrapModes wrap, int32_t filter) {
    std::vector<int32_t> info(static_cast<size_t>(kInfoHeader));
    info[0] = layout.channels;
    info[1] = static_cast<int32_t>(layout.levels.size());
    info[2] = wrap.u;
    info[3] = filter;
    info[kInfoWrapV] = wrap.v;
    info[kInfoAlpha] = layout.alpha ? 1 : 0;
    if (layout.volume) {
        const VolumeDomain& domain = *layout.volume;
        info[4] = 1;
        if (domain.table) {
            info[2] = info[kInfoWrapV] = kWrapOfTables;
            if (filter != kFilterNearest) info[3] = kFilterFinest;
        }
        for (const auto& three : {domain.origin, domain.extent}) {
            for (const float x : three)
                info.push_back(static_cast<int32_t>(bits_of(x)));
        }
    }
    for (const PyramidLayout::Level& level : layout.levels) {
        info.push_back(static_cast<int32_t>(level.texels));
        info.push_back(level.width);
        info.push_back(level.height);
        if (layout.volume) info.push_back(level.depth);
        info.push_back(static_cast<int32_t>(level.minmax));
    }
    return info;
}

}  // namespace openfab::texture

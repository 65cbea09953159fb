// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/texture/pyramid_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "runtime/texture/pyramid.h"

namespace openfab::texture {
namespace {

constexpr int32_t kLargestSide = 16384;

/// The texels below that one texel of a level takes in along one axis: at most three, with weights
/// that sum to 1.
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
        Taps& t = taps[static_cast<size_t>(i)];
        t.first = static_cast<int32_t>(lo / above);
        for (int64_t j = t.first; j * above < hi; ++j) {
            const int64_t overlap = std::min(hi, (j + 1) * above) - std::max(lo, j * above);
            t.weight[t.count++] = static_cast<double>(overlap) / static_cast<double>(below);
        }
    }
    return taps;
}

void filter_level(const PyramidLayout& layout, size_t level, float* texels) {
    const PyramidLayout::Level& below = layout.levels[level - 1];
    const PyramidLayout::Level& above = layout.levels[level];
    const std::vector<Taps> across = taps_for(below.width, above.width);
    const std::vector<Taps> up = taps_for(below.height, above.height);
    const int32_t channels = layout.channels;
    const float* from = texels + below.texels;
    float* to = texels + above.texels;
    for (const Taps& ty : up) {
        for (const Taps& tx : across) {
            for (int32_t c = 0; c < channels; ++c) {
                double sum = 0;
                for (int32_t j = 0; j < ty.count; ++j) {
                    const float* row =
                        from +
                        (static_cast<int64_t>(ty.first + j) * below.width + tx.first) * channels +
                        c;
                    double along = 0;
                    for (int32_t i = 0; i < tx.count; ++i) {
                        along += tx.weight[i] * static_cast<double>(row[i * channels]);
                    }
                    sum += ty.weight[j] * along;
                }
                *to++ = static_cast<float>(sum);
            }
        }
    }
}

void minmax_level(const PyramidLayout& layout, size_t level, float* minmax) {
    const PyramidLayout::Level& below = layout.levels[level - 1];
    const PyramidLayout::Level& above = layout.levels[level];
    const std::vector<Taps> across = taps_for(below.width, above.width);
    const std::vector<Taps> up = taps_for(below.height, above.height);
    const int32_t channels = layout.channels;
    const float* from = minmax + below.minmax;
    float* to = minmax + above.minmax;
    for (const Taps& ty : up) {
        for (const Taps& tx : across) {
            for (int32_t c = 0; c < channels; ++c) {
                float least = std::numeric_limits<float>::infinity();
                float greatest = -std::numeric_limits<float>::infinity();
                for (int32_t j = 0; j < ty.count; ++j) {
                    const float* row =
                        from +
                        ((static_cast<int64_t>(ty.first + j) * below.width + tx.first) * channels +
                         c) *
                            2;
                    for (int32_t i = 0; i < tx.count; ++i) {
                        least = std::min(least, row[i * channels * 2]);
                        greatest = std::max(greatest, row[i * channels * 2 + 1]);
                    }
                }
                *to++ = least;
                *to++ = greatest;
            }
        }
    }
}

}  // namespace

Result<PyramidLayout> pyramid_layout(int32_t width, int32_t height, int32_t channels) {
    if (width < 1 || height < 1)
        return user_error(fmt::format("the picture is empty ({} x {})", width, height));
    if (width > kLargestSide || height > kLargestSide) {
        return user_error(
            fmt::format("the picture is {} x {}; at most {} pixels a side are possible", width,
                        height, kLargestSide));
    }
    if (channels < 1 || channels > 4) {
        return user_error(
            fmt::format("the picture has {} channels; 1 to 4 are possible", channels));
    }
    PyramidLayout layout;
    layout.channels = channels;
    for (;;) {
        layout.levels.push_back({layout.texel_floats, width, height, layout.minmax_floats});
        layout.texel_floats += static_cast<int64_t>(width) * height * channels;
        layout.minmax_floats = 2 * layout.texel_floats;
        if (width == 1 && height == 1) break;
        width = (width + 1) / 2;
        height = (height + 1) / 2;
    }
    if (layout.minmax_floats > std::numeric_limits<int32_t>::max()) {
        return user_error(
            fmt::format("the picture is {} x {} with {} channels, which is too large; scale it "
                        "down, or read one channel of it "
                        "with \"channels\": \"luminance\"",
                        layout.levels[0].width, layout.levels[0].height, channels));
    }
    return layout;
}

void fill_pyramid(const PyramidLayout& layout, float* texels, float* minmax) {
    const int64_t finest = layout.levels.size() > 1 ? layout.levels[1].texels : layout.texel_floats;
    for (int64_t i = 0; i < finest; ++i)
        minmax[2 * i] = minmax[2 * i + 1] = texels[i];
    for (size_t level = 1; level < layout.levels.size(); ++level) {
        filter_level(layout, level, texels);
        minmax_level(layout, level, minmax);
    }
}

std::vector<int32_t> pyramid_info(const PyramidLayout& layout, int32_t wrap, int32_t filter) {
    std::vector<int32_t> info(static_cast<size_t>(kInfoHeader));
    info[0] = layout.channels;
    info[1] = static_cast<int32_t>(layout.levels.size());
    info[2] = wrap;
    info[3] = filter;
    for (const PyramidLayout::Level& level : layout.levels) {
        info.push_back(static_cast<int32_t>(level.texels));
        info.push_back(level.width);
        info.push_back(level.height);
        info.push_back(static_cast<int32_t>(level.minmax));
    }
    return info;
}

}  // namespace openfab::texture

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <random>

#include "tests/exec/compiled_stage.h"

namespace openfab::testing {

TestTexture make_texture(int32_t width, int32_t height, int32_t channels, int32_t wrap,
                         int32_t filter, uint32_t seed, float ramp) {
    std::mt19937 random(seed);
    TestTexture out;
    struct Level {
        int32_t w, h;
        std::vector<float> texels, lo, hi;
    };
    Level level{width, height, {}, {}, {}};
    for (int32_t k = 0; k < width * height * channels; ++k) {
        const float noise = static_cast<float>(random() >> 8) * 0x1p-24f;
        const auto along = static_cast<float>(k / channels % width) / static_cast<float>(width);
        level.texels.push_back(ramp * along + (1.0f - ramp) * noise);
    }
    level.lo = level.hi = level.texels;
    out.info = {channels, 0, wrap, filter, 0, wrap, 0, 0};
    while (true) {
        out.info[1]++;
        out.info.insert(out.info.end(), {static_cast<int32_t>(out.texels.size()), level.w, level.h,
                                         static_cast<int32_t>(out.minmax.size())});
        out.texels.insert(out.texels.end(), level.texels.begin(), level.texels.end());
        for (size_t k = 0; k < level.lo.size(); ++k) {
            out.minmax.push_back(level.lo[k]);
            out.minmax.push_back(level.hi[k]);
        }
        if (level.w == 1 && level.h == 1) return out;
        Level next{(level.w + 1) / 2, (level.h + 1) / 2, {}, {}, {}};
        for (int32_t y = 0; y < next.h; ++y) {
            for (int32_t x = 0; x < next.w; ++x) {
                for (int32_t c = 0; c < channels; ++c) {
                    float sum = 0;
                    float number = 0;
                    float lo = 2;
                    float hi = -1;
                    for (int32_t j = 2 * y; j < std::min(2 * y + 2, level.h); ++j) {
                        for (int32_t i = 2 * x; i < std::min(2 * x + 2, level.w); ++i) {
                            const auto at = static_cast<size_t>((j * level.w + i) * channels + c);
                            sum += level.texels[at];
                            number += 1;
                            lo = std::min(lo, level.lo[at]);
                            hi = std::max(hi, level.hi[at]);
                        }
                    }
                    next.texels.push_back(sum / number);
                    next.lo.push_back(lo);
                    next.hi.push_back(hi);
                }
            }
        }
        level = std::move(next);
    }
}

}  // namespace openfab::testing

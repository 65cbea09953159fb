// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Writes the mask of the ordered dither as C++: blue_noise_gen OUT.cpp

#include <cstdio>

#include "runtime/dither/blue_noise.h"
#include "runtime/dither/void_and_cluster.h"

int main(int argc, char** argv) {
    std::FILE* out = argc == 2 ? std::fopen(argv[1], "w") : nullptr;
    if (out == nullptr) {
        std::fprintf(stderr, "usage: blue_noise_gen OUT.cpp\n");
        return 2;
    }
    using namespace openfab::dither;
    const auto side = static_cast<int32_t>(kBlueNoiseSide);
    const auto step_x = static_cast<int32_t>(kBlueNoiseStepX);
    const auto step_y = static_cast<int32_t>(kBlueNoiseStepY);
    std::fprintf(out,
                 "// Written by blue_noise_gen: void_and_cluster(%d, %d, %d).\n"
                 "#include \"runtime/dither/blue_noise.h\"\n\n"
                 "namespace openfab::dither {\n\n"
                 "const uint16_t kBlueNoiseMask[kBlueNoiseSide * kBlueNoiseStride] = {\n",
                 side, step_x, step_y);
    const std::vector<uint16_t> ranks = void_and_cluster(side, step_x, step_y);
    for (int32_t y = 0; y < side; ++y) {
        for (int32_t x = 0; x < 2 * side; ++x) {
            const int32_t rank = ranks[static_cast<size_t>(y * side + x % side)];
            // The center of the rank's interval.
            std::fprintf(out, "%d,%s", (2 * rank + 1) * 32768 / (side * side),
                         x % side == side - 1 ? "\n" : " ");
        }
    }
    std::fprintf(out, "};\n\n}  // namespace openfab::dither\n");
    return std::fclose(out) == 0 ? 0 : 1;
}

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Writes the masks of the ordered dither as C++: blue_noise_gen OUT.cpp

#include <cstdio>

#include "runtime/dither/blue_noise.h"
#include "runtime/dither/void_and_cluster.h"

namespace openfab::dither {
namespace {

/// `step` in pixels from slice to slice.
void write_mask(const char* name, MaskUse use, uint32_t step, std::FILE* out) {
    const std::vector<uint16_t> ranks = void_and_cluster(static_cast<int32_t>(kBlueNoiseRow), use,
                                                         static_cast<int32_t>(kBlueNoiseSliceStep));
    std::fprintf(out, "const BlueNoiseMask %s = {\n", name);
    for (uint32_t pixel = 0; pixel < kBlueNoisePixels; ++pixel) {
        for (uint32_t slice = 0; slice < 8; ++slice) {
            const uint32_t rank = ranks[(pixel + step * slice) % kBlueNoisePixels];
            // The center of the rank's interval.
            std::fprintf(out, "%s%u", slice == 0 ? "{" : ", ",
                         (2 * rank + 1) * 32768 / kBlueNoisePixels);
        }
        std::fprintf(out, "},\n");
    }
    std::fprintf(out, "};\n\n");
}

}  // namespace
}  // namespace openfab::dither

int main(int argc, char** argv) {
    std::FILE* out = argc == 2 ? std::fopen(argv[1], "w") : nullptr;
    if (out == nullptr) {
        std::fprintf(stderr, "usage: blue_noise_gen OUT.cpp\n");
        return 2;
    }
    using namespace openfab::dither;
    std::fprintf(out,
                 "// Written by blue_noise_gen.\n"
                 "#include \"runtime/dither/blue_noise.h\"\n\n"
                 "namespace openfab::dither {\n\n");
    write_mask("kBlueNoiseInside", MaskUse::kInside, kBlueNoiseSliceStep, out);
    write_mask("kBlueNoiseSides", MaskUse::kSides, kBlueNoisePixels - kBlueNoiseRow, out);
    std::fprintf(out, "}  // namespace openfab::dither\n");
    return std::fclose(out) == 0 ? 0 : 1;
}

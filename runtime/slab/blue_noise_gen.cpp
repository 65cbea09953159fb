// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Writes the mask of the ordered dither as C++: blue_noise_gen OUT.cpp

#include <cstdio>

#include "runtime/slab/blue_noise.h"
#include "runtime/slab/void_and_cluster.h"

int main(int argc, char** argv) {
    std::FILE* out = argc == 2 ? std::fopen(argv[1], "w") : nullptr;
    if (out == nullptr) {
        std::fprintf(stderr, "usage: blue_noise_gen OUT.cpp\n");
        return 2;
    }
    const int32_t side = openfab::slab::kBlueNoiseSide;
    std::fprintf(out,
                 "// Written by blue_noise_gen: void_and_cluster(%d).\n"
                 "#include \"runtime/slab/blue_noise.h\"\n\n"
                 "namespace openfab::slab {\n\n"
                 "const uint16_t kBlueNoiseRanks[kBlueNoiseSide * kBlueNoiseSide] = {\n",
                 side);
    int column = 0;
    for (uint16_t rank : openfab::slab::void_and_cluster(side)) {
        std::fprintf(out, "%d,%s", rank, ++column % 16 == 0 ? "\n" : " ");
    }
    std::fprintf(out, "};\n\n}  // namespace openfab::slab\n");
    return std::fclose(out) == 0 ? 0 : 1;
}

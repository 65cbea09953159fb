// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The fixed-function stages alone, one thread: normalise on batches of blocks; dither and pack on
// rows of blocks as wide as a postcard at 600 dpi, all voxels mixed. Items are voxels.

#include <benchmark/benchmark.h>

#include <random>

#include "runtime/dither/band.h"

namespace openfab {
namespace {

constexpr int32_t kBlocks = 296;

openfab_isa isa_of(int64_t i) {
    return static_cast<openfab_isa>(i);
}

void make_band(dither::RowBand* band, int32_t row, int32_t channels, std::mt19937& random) {
    band->reset(row, kBlocks, 0, kBlocks);
    std::vector<uint8_t> owned(64, 255), codes(512, OPENFAB_CODE_MIXED);
    std::vector<uint16_t> tile(static_cast<size_t>(512) * channels);
    for (int32_t b = 0; b < kBlocks; ++b) {
        for (size_t v = 0; v < 64; ++v) {
            for (size_t z = 0; z < 8; ++z) {
                int32_t left = 65535;
                for (int32_t m = 0; m + 1 < channels; ++m) {
                    const auto share = static_cast<int32_t>(
                        random() % (2 * 65535 / static_cast<uint32_t>(channels)));
                    tile[(v * channels + m) * 8 + z] = static_cast<uint16_t>(std::min(share, left));
                    left -= std::min(share, left);
                }
                tile[(v * channels + channels - 1) * 8 + z] = static_cast<uint16_t>(left);
            }
        }
        band->merge(b, owned.data(), codes.data(), tile.data(), channels);
    }
}

void dither_and_pack(benchmark::State& state) {
    const openfab_stage_set& set = *abi::find_stage_set(static_cast<int32_t>(state.range(0)));
    std::mt19937 random(1);
    dither::RowBand bands[2];
    for (int32_t i = 0; i < 2; ++i)
        make_band(&bands[i], i, set.materials + 1, random);
    const auto rule = static_cast<dither::DitherRule>(state.range(2));
    dither::SlabDither dither(set, isa_of(state.range(1)), rule, 1, {8 * kBlocks, 16, 8});
    dither::SlabPlanes planes;
    if (!planes.reset(8 * kBlocks, 16, abi::voxel_bits(set.materials)))
        state.SkipWithError("there is no memory");
    for (auto _ : state) {
        dither.begin(0, 255, &planes);
        dither::RowBand* released = nullptr;
        bool ok = true;
        for (int32_t i = 0; i < 2; ++i)
            ok = dither.add(&bands[i], &released).ok() && ok;
        ok = dither.end(&released).ok() && ok;
        if (!ok) state.SkipWithError("a kernel failed");
    }
    state.SetItemsProcessed(state.iterations() * 2 * kBlocks * 512);
}
BENCHMARK(dither_and_pack)
    ->ArgNames({"materials", "isa", "rule"})
    ->ArgsProduct({{1, 2, 4, 8, 15, 32, 64}, {OPENFAB_ISA_SSE41, OPENFAB_ISA_AVX2}, {0, 1, 2, 3}});

void pack(benchmark::State& state) {
    abi::StageCalls calls(*abi::find_stage_set(1), isa_of(state.range(0)));
    std::vector<uint8_t> codes(static_cast<size_t>(kBlocks) * 512, 1),
        planes(static_cast<size_t>(kBlocks) * 256);
    for (auto _ : state) {
        if (!calls
                 .pack(4, codes.data(), kBlocks * 64, 4 * kBlocks, 8, planes.data(), 4 * kBlocks,
                       32 * kBlocks)
                 .ok()) {
            state.SkipWithError("a kernel failed");
        }
    }
    state.SetItemsProcessed(state.iterations() * kBlocks * 512);
}
BENCHMARK(pack)->ArgName("isa")->Arg(OPENFAB_ISA_SSE41)->Arg(OPENFAB_ISA_AVX2);

void normalise(benchmark::State& state) {
    const auto materials = static_cast<int32_t>(state.range(0));
    abi::StageCalls calls(*abi::find_stage_set(materials), isa_of(state.range(1)));
    const int32_t n = 16;
    std::mt19937 random(1);
    std::uniform_real_distribution<float> unit(0, 1);
    std::vector<float> weights(static_cast<size_t>(512) * n * materials);
    for (float& w : weights)
        w = unit(random);
    std::vector<int32_t> slots;
    for (int32_t s = 0; s < materials; ++s)
        slots.push_back(s + 1);
    std::vector<uint8_t> owned(64 * n, 255), codes(512 * n);
    std::vector<uint16_t> fractions(static_cast<size_t>(calls.tile_values()) * n);
    std::vector<int32_t> unusable(8 * n);
    for (auto _ : state) {
        if (!calls
                 .normalise(weights.data(), materials, slots.data(), owned.data(), n,
                            fractions.data(), codes.data(), unusable.data())
                 .ok()) {
            state.SkipWithError("a kernel failed");
        }
    }
    state.SetItemsProcessed(state.iterations() * 512 * n);
}
BENCHMARK(normalise)
    ->ArgNames({"materials", "isa"})
    ->ArgsProduct({{1, 2, 4, 8, 15}, {OPENFAB_ISA_SSE41, OPENFAB_ISA_AVX2}});

}  // namespace
}  // namespace openfab

BENCHMARK_MAIN();

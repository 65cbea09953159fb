// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The fixed-function stages alone, one thread: normalise on batches of columns; dither and pack on
// rows of blocks as wide as a postcard at 600 dpi, all voxels mixed. Items are voxels.

#include <benchmark/benchmark.h>

#include <numeric>
#include <random>

#include "runtime/dither/band.h"

namespace openfab {
namespace {

constexpr int32_t kBlocks = 296;

openfab_isa isa_of(int64_t i) {
    return static_cast<openfab_isa>(i);
}

void make_band(dither::RowBand* band, int32_t row, int32_t channels, std::mt19937& random) {
    band->reset(row, kBlocks, channels, 0, kBlocks);
    std::vector<uint8_t> owned(64, 255), codes(512, OPENFAB_CODE_MIXED);
    std::vector<uint16_t> tile(static_cast<size_t>(512) * channels);
    std::vector<int32_t> all(64);
    std::iota(all.begin(), all.end(), 0);
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
        const int32_t first = band->add_columns(64);
        std::copy(tile.begin(), tile.end(), band->fractions_at(first));
        band->merge(b, owned.data(), {all, codes.data(), first});
    }
}

void dither_and_pack(benchmark::State& state) {
    const auto materials = static_cast<int32_t>(state.range(0));
    const int32_t channels = dither::fraction_channels(materials);
    std::mt19937 random(1);
    dither::RowBand bands[2];
    for (int32_t i = 0; i < 2; ++i)
        make_band(&bands[i], i, channels, random);
    const auto rule = static_cast<dither::DitherRule>(state.range(2));
    dither::SlabDither dither(channels, isa_of(state.range(1)), rule, 1, {8 * kBlocks, 16, 8});
    dither::SlabPlanes planes;
    if (!planes.reset(8 * kBlocks, 16, abi::voxel_bits(materials)))
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
    std::vector<uint8_t> codes(static_cast<size_t>(kBlocks) * 512, 1),
        planes(static_cast<size_t>(kBlocks) * 256);
    for (auto _ : state) {
        if (!abi::pack(isa_of(state.range(0)), 4, codes.data(), kBlocks * 64, 4 * kBlocks, 8,
                       planes.data(), 4 * kBlocks, 32 * kBlocks)
                 .ok()) {
            state.SkipWithError("a kernel failed");
        }
    }
    state.SetItemsProcessed(state.iterations() * kBlocks * 512);
}
BENCHMARK(pack)->ArgName("isa")->Arg(OPENFAB_ISA_SSE41)->Arg(OPENFAB_ISA_AVX2);

void normalise(benchmark::State& state) {
    const auto materials = static_cast<int32_t>(state.range(0));
    constexpr size_t kColumns = 1024;
    std::mt19937 random(1);
    std::uniform_real_distribution<float> unit(0, 1);
    std::vector<float> weights(8 * kColumns * static_cast<size_t>(materials));
    for (float& w : weights)
        w = unit(random);
    std::vector<int32_t> slots(static_cast<size_t>(materials)), columns(kColumns);
    std::iota(slots.begin(), slots.end(), 1);
    std::iota(columns.begin(), columns.end(), 0);
    const abi::Channels channels(slots);
    std::vector<uint8_t> codes(8 * kColumns);
    std::vector<uint16_t> fractions(8 * kColumns * static_cast<size_t>(channels.count())),
        unusable(8 * kColumns);
    for (auto _ : state) {
        if (!abi::normalise(isa_of(state.range(1)), columns, channels, weights.data(), 8 * kColumns,
                            fractions.data(), codes.data(), unusable.data())
                 .ok()) {
            state.SkipWithError("a kernel failed");
        }
    }
    state.SetItemsProcessed(state.iterations() * int64_t{8 * kColumns});
}
BENCHMARK(normalise)
    ->ArgNames({"materials", "isa"})
    ->ArgsProduct({{1, 2, 4, 8, 15}, {OPENFAB_ISA_SSE41, OPENFAB_ISA_AVX2}});

}  // namespace
}  // namespace openfab

BENCHMARK_MAIN();

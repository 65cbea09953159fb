// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Dicing and voxelising the postcard's shape: a card of 100 x 70 mm at 600 x 300 dpi and 27 um, its
// back displaced by a relief of up to 1 mm with detail down to half a millimetre. The surface stage
// is a cheap one in plain C++, so that the engine dominates the time; one thread.

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include "runtime/surface/surface.h"
#include "runtime/voxel/coverage.h"
#include "tests/support/surface/worlds.h"

namespace openfab {
namespace {

const Vec3d kPitch{25.4 / 600, 25.4 / 300, 0.027};

struct Postcard {
    part::Part part;
    part::Grid grid;
    surface::SurfaceOptions options;

    Postcard()
        : part(make_part(testing::Scenario{"", testing::card(100, 70, 1.7),
                                           testing::HandMode::kRelief, 1.0f, 0})) {
        options.micro_edge_mm = std::cbrt(kPitch.x * kPitch.y * kPitch.z);
        grid = testing::grid_around(part, kPitch, 1.0);
    }
    std::unique_ptr<surface::Surface> create() const {
        return std::move(*surface::Surface::create(part, options));
    }
};

void BM_SetUp(benchmark::State& state) {
    const Postcard card;
    for (auto _ : state)
        benchmark::DoNotOptimize(card.create());
    state.counters["patches"] = static_cast<double>(card.create()->patches().size());
}
BENCHMARK(BM_SetUp)->Unit(benchmark::kMillisecond);

void BM_DiceAll(benchmark::State& state) {
    const Postcard card;
    int64_t triangles = 0;
    for (auto _ : state) {
        state.PauseTiming();
        const auto surface = card.create();
        state.ResumeTiming();
        triangles = 0;
        for (size_t p = 0; p < surface->patches().size(); ++p) {
            triangles +=
                static_cast<int64_t>(surface->micro(static_cast<int32_t>(p))->triangles.size());
        }
    }
    state.counters["micropolygons"] = static_cast<double>(triangles);
    state.counters["micropolygons/s"] = benchmark::Counter(
        static_cast<double>(triangles), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(BM_DiceAll)->Unit(benchmark::kMillisecond);

void BM_ExactBox(benchmark::State& state) {
    const Postcard card;
    for (auto _ : state) {
        state.PauseTiming();
        const auto surface = card.create();
        state.ResumeTiming();
        benchmark::DoNotOptimize(surface->exact_box(card.part.local_to_build));
    }
}
BENCHMARK(BM_ExactBox)->Unit(benchmark::kMillisecond);

/// All slabs of the card, dicing included; the argument is the cache's budget in MB.
void BM_Coverage(benchmark::State& state) {
    Postcard card;
    card.options.cache_bytes = static_cast<size_t>(state.range(0)) << 20;
    int64_t solid = 0, misses = 0;
    size_t bytes = 0;
    for (auto _ : state) {
        state.PauseTiming();
        const auto surface = card.create();
        state.ResumeTiming();
        const voxel::Voxeliser voxeliser(card.part, *surface, card.grid);
        voxel::SlabMask mask;
        solid = 0;
        for (int32_t g = 0; 8 * g < card.grid.size.z; ++g) {
            voxeliser.coverage(g, &mask);
            bytes = std::max(bytes, voxeliser.bytes());
            for (const uint8_t bits : mask.mask)
                solid += __builtin_popcount(bits);
        }
        misses = surface->counts().cache_misses;
    }
    const double voxels =
        static_cast<double>(card.grid.size.x) * card.grid.size.y * card.grid.size.z;
    state.counters["voxels"] = voxels;
    state.counters["voxeliser_bytes"] = static_cast<double>(bytes);
    state.counters["solid"] = static_cast<double>(solid);
    state.counters["patches_diced"] = static_cast<double>(misses);
    state.counters["voxels/s"] =
        benchmark::Counter(voxels, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(BM_Coverage)->Arg(256)->Arg(4)->Unit(benchmark::kMillisecond);

/// The same with everything diced before: voxelisation alone.
void BM_CoverageOfDiced(benchmark::State& state) {
    Postcard card;
    card.options.cache_bytes = size_t{4} << 30;
    const auto surface = card.create();
    for (size_t p = 0; p < surface->patches().size(); ++p)
        surface->micro(static_cast<int32_t>(p));
    for (auto _ : state) {
        const voxel::Voxeliser voxeliser(card.part, *surface, card.grid);
        voxel::SlabMask mask;
        for (int32_t g = 0; 8 * g < card.grid.size.z; ++g)
            voxeliser.coverage(g, &mask);
        benchmark::DoNotOptimize(mask);
    }
}
BENCHMARK(BM_CoverageOfDiced)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace openfab

int main(int argc, char** argv) {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    benchmark::Initialize(&argc, argv);
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}

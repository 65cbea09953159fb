// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// A displaced surface that is diced on demand against the same micropolygons written down as a mesh
// beforehand: nearest queries of the block engine at 150 x 150 dpi x 60 um, one micropolygon edge a
// voxel, on one thread. "warm": all patches diced; "whole": with trees made and patches diced,
// every block of the part once, as a print visits them. Interleaved rounds, medians, processor
// time. Then what each step costs by itself, for base triangles of few and of many micropolygons:
// dicing and trees, in ns a micropolygon, and warm queries, in ns a voxel.
//   bench_displaced [ROUNDS]

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "base/infinity.h"
#include "runtime/nearest/engine.h"
#include "runtime/nearest/tree/lattice_tree.h"
#include "runtime/nearest/tree/packed_tree.h"
#include "runtime/nearest/tree/patch_units.h"
#include "runtime/voxel/coverage.h"
#include "tests/support/mesh_surface.h"
#include "tests/support/surface/worlds.h"

namespace openfab::bench {
namespace {

const Vec3d kPitch{25.4 / 150, 25.4 / 150, 0.06};

struct Block {
    Vec3i lowest;  ///< part-relative
    std::array<uint8_t, 64> demand;
    int32_t asked;
};

/// The part and its grid, all blocks with a voxel inside in the order of a print.
struct Scene {
    part::Part part;
    part::Grid grid;
    surface::SurfaceOptions options;
    std::vector<Block> blocks;

    explicit Scene(float amplitude_mm, int32_t around = 96)
        : part(testing::make_part(testing::Scenario{"", testing::torus(14, 6, around, around / 2),
                                                    testing::HandMode::kBumps, amplitude_mm, 0})),
          grid(testing::grid_around(part, kPitch, 2 * static_cast<double>(amplitude_mm))) {
        options.micro_edge_mm = std::cbrt(kPitch.x * kPitch.y * kPitch.z);
        options.cache_bytes = size_t{1} << 30;
        const auto surface = make_surface();
        const voxel::Voxeliser voxeliser(part, *surface, grid);
        const Vec3i base = part::part_base_voxel(part, grid);
        voxel::SlabMask mask;
        for (int32_t g = 0; 8 * g < grid.size.z; ++g) {
            voxeliser.coverage(g, &mask);
            for (int32_t y = 0; y < mask.height; y += 8) {
                for (int32_t x = 0; x < mask.width; x += 8) {
                    Block block{Vec3i{mask.x0 + x, mask.y0 + y, 8 * g} - base, {}, 0};
                    for (int32_t v = 0; v < 64; ++v) {
                        const uint8_t bits =
                            mask.mask[static_cast<size_t>((y + v / 8) * mask.width + x + v % 8)];
                        block.demand[v] = bits;
                        block.asked += __builtin_popcount(bits);
                    }
                    if (block.asked != 0) blocks.push_back(block);
                }
            }
        }
    }
    std::unique_ptr<surface::Surface> make_surface() const {
        return std::move(*surface::Surface::create(part, options));
    }
};

testing::TriangleMesh micropolygons(const surface::Surface& surface) {
    testing::TriangleMesh mesh;
    for (size_t p = 0; p < surface.patches().size(); ++p) {
        if ((surface.patches()[p].use & surface::kForQuery) == 0) continue;
        const auto micro = surface.micro(static_cast<int32_t>(p));
        const auto first = static_cast<int32_t>(mesh.positions.size());
        mesh.positions.insert(mesh.positions.end(), micro->positions.begin(),
                              micro->positions.end());
        for (const auto& t : micro->triangles)
            mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
    return mesh;
}

double thread_seconds() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Sum of distances.
double ask(const nearest::Engine& engine, const std::vector<Block>& blocks, size_t every,
           float radius) {
    static nearest::BlockAnswer answer;
    const auto scratch = engine.make_scratch();
    double sum = 0;
    constexpr size_t kRun = 6;  // blocks that follow each other, as in a print
    for (size_t i = 0; i < blocks.size(); ++i) {
        if (i / kRun % every != 0) continue;
        nearest::BlockQuery query;
        query.block = blocks[i].lowest;
        query.active = blocks[i].demand.data();
        query.radius_mm = radius;
        engine.query(query, scratch.get(), &answer);
        for (int v = 0; v < nearest::kBlockVoxels; ++v) {
            if (answer.item[v] >= 0) sum += std::sqrt(static_cast<double>(answer.distance2[v]));
        }
    }
    return sum;
}

struct Timed {
    std::vector<double> seconds;
    double sum = 0;

    template <typename Work>
    void add(const Work& work) {
        const double start = thread_seconds();
        sum = work();
        seconds.push_back(thread_seconds() - start);
    }
    double median() const {
        std::vector<double> sorted = seconds;
        std::sort(sorted.begin(), sorted.end());
        return sorted[sorted.size() / 2];
    }
};

void print_row(float amplitude, const char* work, int64_t voxels, const Timed& demand,
               const Timed& before) {
    const auto rate = [&](const Timed& t) {
        return static_cast<double>(voxels) / t.median() * 1e-6;
    };
    fmt::print("{:6.2f} mm  {:18} {:9} {:9.2f} {:9.2f} {:8.2f}{}\n", amplitude, work, voxels,
               rate(demand), rate(before), demand.median() / before.median(),
               std::abs(demand.sum - before.sum) > 1e-9 * before.sum ? "  sums differ" : "");
}

void measure(float amplitude_mm, int rounds) {
    const Scene scene(amplitude_mm);
    const auto surface = scene.make_surface();
    const testing::TriangleMesh mesh = micropolygons(*surface);
    const testing::MeshSurface written(mesh);
    const auto frame = part::make_frame(scene.part, scene.grid);
    const nearest::BlockEngineOptions roomy{.cache_bytes = size_t{2} << 30};
    const auto on_demand = nearest::make_block_engine(*surface, frame, roomy);
    const auto beforehand = nearest::make_block_engine(written, frame, roomy);
    fmt::print("{} micropolygons in {} patches, {} blocks\n", mesh.triangles.size(),
               surface->patches().size(), scene.blocks.size());
    int64_t voxels = 0, some = 0;
    constexpr size_t kEvery = 16;
    for (size_t i = 0; i < scene.blocks.size(); ++i) {
        voxels += scene.blocks[i].asked;
        if (i / 6 % kEvery == 0) some += scene.blocks[i].asked;
    }
    ask(*on_demand, scene.blocks, 1, 0.5f);
    for (const float radius : {kInfinity, 0.5f}) {
        Timed demand, before;
        for (int round = 0; round < rounds; ++round) {
            demand.add([&] { return ask(*on_demand, scene.blocks, kEvery, radius); });
            before.add([&] { return ask(*beforehand, scene.blocks, kEvery, radius); });
        }
        print_row(amplitude_mm, radius < kInfinity ? "warm, to 0.5 mm" : "warm, unbounded", some,
                  demand, before);
    }
    Timed demand, before;
    for (int round = 0; round < rounds; ++round) {
        demand.add([&] {
            const auto fresh = scene.make_surface();
            return ask(*nearest::make_block_engine(*fresh, frame, roomy), scene.blocks, 1, 0.5f);
        });
        before.add([&] {
            const testing::MeshSurface fresh(mesh);
            return ask(*nearest::make_block_engine(fresh, frame, roomy), scene.blocks, 1, 0.5f);
        });
    }
    print_row(amplitude_mm, "whole, to 0.5 mm", voxels, demand, before);
}

/// The steps apart, on a torus of `around` x `around` / 2 squares.
void measure_apart(int32_t around, int rounds) {
    constexpr float kAmplitude = 0.5f;
    const Scene scene(kAmplitude, around);
    Timed dicing, trees, warm;
    int64_t micropolygons = 0, voxels = 0;
    size_t lattices = 0;
    for (const Block& block : scene.blocks)
        voxels += block.asked;
    for (int round = 0; round < rounds; ++round) {
        const auto surface = scene.make_surface();
        std::vector<nearest::LatticePatch> diced;
        std::vector<std::shared_ptr<const surface::MicroMesh>> meshes;
        dicing.add([&] {
            for (size_t p = 0; p < surface->patches().size(); ++p)
                meshes.push_back(surface->micro(static_cast<int32_t>(p)));
            return 0.0;
        });
        std::vector<nearest::InputPatch> boxes;
        micropolygons = 0;
        for (size_t p = 0; p < surface->patches().size(); ++p) {
            micropolygons += static_cast<int64_t>(meshes[p]->triangles.size());
            const auto id = static_cast<int32_t>(p);
            if (surface->patches()[p].kind == surface::PatchKind::kLattice)
                boxes.push_back({surface->patches()[p].bounds, id});
        }
        lattices = boxes.size();
        const nearest::PatchUnits units(*surface, &boxes);
        trees.add([&] {
            nearest::LatticeTreeBuilder builder;
            size_t bytes = 0;
            for (const nearest::InputPatch& box : boxes) {
                diced.clear();
                for (const int32_t patch : units.patches(box.patch)) {
                    const auto p = static_cast<size_t>(patch);
                    diced.push_back({meshes[p].get(), &surface->patches()[p], patch});
                }
                bytes += nearest::PackedTree(*builder.build(diced)).bytes();
            }
            return static_cast<double>(bytes);
        });
        const auto engine = nearest::make_block_engine(
            *surface, part::make_frame(scene.part, scene.grid), {.cache_bytes = size_t{2} << 30});
        ask(*engine, scene.blocks, 1, 0.5f);
        warm.add([&] { return ask(*engine, scene.blocks, 1, 0.5f); });
    }
    const auto ns = [](const Timed& t, int64_t of) {
        return 1e9 * t.median() / static_cast<double>(of);
    };
    fmt::print("{:9} {:9} {:12.1f} {:9.1f} {:9.0f} {:12.1f}\n", lattices, micropolygons,
               ns(dicing, micropolygons), ns(trees, micropolygons),
               trees.sum / static_cast<double>(micropolygons), ns(warm, voxels));
}

}  // namespace
}  // namespace openfab::bench

int main(int argc, char** argv) {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const int rounds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 5;
    fmt::print(
        "M queries/s, one thread: diced on demand, beforehand; time on demand by time "
        "beforehand\n");
    for (const float amplitude : {0.1f, 0.5f, 2.0f})
        openfab::bench::measure(amplitude, rounds);
    fmt::print(
        "\n  patches, micropolygons, dicing and tree (ns a micropolygon), bytes of tree, warm "
        "query to "
        "0.5 mm (ns a voxel)\n");
    for (const int32_t around : {24, 96, 384})
        openfab::bench::measure_apart(around, rounds);
    return 0;
}

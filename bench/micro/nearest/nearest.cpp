// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Nearest-surface queries per second on one core: the block engine against Embree, fresh for each
// voxel and seeded from the previous one, on the same voxels, in interleaved rounds. Prints a table
// of medians with ratios.

#include <time.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "base/infinity.h"
#include "bench/micro/nearest/embree_baseline.h"
#include "runtime/nearest/engine.h"
#include "runtime/nearest/engine/attributes.h"
#include "tests/support/mesh_surface.h"

namespace openfab::bench {
namespace {

using nearest::BlockAnswer;
using nearest::BlockQuery;
using testing::TriangleMesh;
using Clock = std::chrono::steady_clock;

// 150 x 150 dpi x 60 um.
const Vec3f kPitch{25.4f / 150, 25.4f / 150, 0.06f};

struct Options {
    int rounds = 5;
    int64_t voxels = 2000000;
    int64_t triangles = int64_t{1} << 40;  ///< skip larger meshes
    bool embree = true;
    std::string only;
    std::string work;  ///< empty: both, and bounds
};

struct Block {
    Vec3i lowest;
    std::array<uint8_t, 64> demand;
    int32_t asked;
};

/// Inside bits of all voxels of a grid around the mesh, by crossings along x; voxel (0,0,0) is at
/// `lowest`.
struct Inside {
    Vec3i lowest, size;
    std::vector<uint8_t> bit;  // [z][y][x]
};

Inside fill(const TriangleMesh& mesh) {
    Inside grid;
    const Box3f box = mesh.box();
    for (int a = 0; a < 3; ++a) {
        grid.lowest[a] = static_cast<int32_t>(std::floor(box.lo[a] / kPitch[a] / 8)) * 8;
        const auto end = static_cast<int32_t>(std::ceil(box.hi[a] / kPitch[a] / 8)) * 8;
        grid.size[a] = end - grid.lowest[a];
    }
    std::vector<std::vector<float>> rows(static_cast<size_t>(grid.size.y) *
                                         static_cast<size_t>(grid.size.z));
    for (const auto& t : mesh.triangles) {
        Vec3d v[3];
        Box3d b;
        for (size_t k = 0; k < 3; ++k) {
            const Vec3f& p = mesh.positions[t[k]];
            for (int a = 0; a < 3; ++a)
                v[k][a] = static_cast<double>(p[a]) / kPitch[a] - grid.lowest[a] - 0.5;
            b.add(v[k]);
        }
        const double area =
            (v[1].y - v[0].y) * (v[2].z - v[0].z) - (v[1].z - v[0].z) * (v[2].y - v[0].y);
        if (area == 0) continue;
        for (auto z = static_cast<int32_t>(std::ceil(b.lo.z)); z < b.hi.z; ++z) {
            for (auto y = static_cast<int32_t>(std::ceil(b.lo.y)); y < b.hi.y; ++y) {
                double w[3];
                for (int k = 0; k < 3; ++k) {
                    const Vec3d& p = v[(k + 1) % 3];
                    const Vec3d& q = v[(k + 2) % 3];
                    w[k] = ((q.y - p.y) * (z - p.z) - (q.z - p.z) * (y - p.y)) / area;
                }
                if (w[0] < 0 || w[1] < 0 || w[2] < 0) continue;
                rows[static_cast<size_t>(z) * static_cast<size_t>(grid.size.y) +
                     static_cast<size_t>(y)]
                    .push_back(static_cast<float>(w[0] * v[0].x + w[1] * v[1].x + w[2] * v[2].x));
            }
        }
    }
    grid.bit.assign(rows.size() * static_cast<size_t>(grid.size.x), 0);
    for (size_t r = 0; r < rows.size(); ++r) {
        std::sort(rows[r].begin(), rows[r].end());
        for (size_t k = 0; k + 1 < rows[r].size(); k += 2) {
            for (auto x = std::max(0, static_cast<int32_t>(std::ceil(rows[r][k])));
                 x < std::min<float>(rows[r][k + 1], static_cast<float>(grid.size.x)); ++x) {
                grid.bit[r * static_cast<size_t>(grid.size.x) + static_cast<size_t>(x)] = 1;
            }
        }
    }
    return grid;
}

/// The blocks of a slab of 8 slices that have voxels inside, in the order of a print.
void add_slab(const Inside& grid, int32_t z, std::vector<Block>* blocks) {
    for (int32_t y = 0; y < grid.size.y; y += 8) {
        for (int32_t x = 0; x < grid.size.x; x += 8) {
            Block block{grid.lowest + Vec3i{x, y, z}, {}, 0};
            for (int32_t v = 0; v < 512; ++v) {
                const int32_t vz = v & 7, vx = v >> 3 & 7, vy = v >> 6;
                const size_t at = (static_cast<size_t>(z + vz) * static_cast<size_t>(grid.size.y) +
                                   static_cast<size_t>(y + vy)) *
                                      static_cast<size_t>(grid.size.x) +
                                  static_cast<size_t>(x + vx);
                if (grid.bit[at] == 0) continue;
                block.demand[static_cast<size_t>(v >> 3)] |= static_cast<uint8_t>(1u << (v & 7));
                ++block.asked;
            }
            if (block.asked != 0) blocks->push_back(block);
        }
    }
}

/// Whole slabs, three in a row as in a print, spread evenly over the part: the caches of any engine
/// depend on neighbours in all directions.
std::vector<Block> choose_blocks(const Inside& grid, int64_t voxels) {
    int64_t inside = 0;
    for (const uint8_t b : grid.bit)
        inside += b;
    constexpr int32_t kRun = 3;
    const int64_t slabs = grid.size.z / 8;
    const int64_t runs = std::clamp<int64_t>(voxels * slabs / (kRun * std::max<int64_t>(inside, 1)),
                                             1, slabs / kRun);
    std::vector<Block> blocks;
    for (int64_t r = 0; r < runs; ++r) {
        const auto first = static_cast<int32_t>((2 * r + 1) * slabs / (2 * runs) - kRun / 2);
        for (int32_t s = first; s < first + kRun; ++s)
            add_slab(grid, s * 8, &blocks);
    }
    return blocks;
}

Vec3f center(const Vec3i& voxel) {
    return {(static_cast<float>(voxel.x) + 0.5f) * kPitch.x,
            (static_cast<float>(voxel.y) + 0.5f) * kPitch.y,
            (static_cast<float>(voxel.z) + 0.5f) * kPitch.z};
}

/// Processor time of this thread: on a shared machine wall-clock time includes other processes.
double thread_seconds() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

enum class Seed { kFresh, kPrevious, kBlockFirst };

/// Returns the sum of distances, so that nothing is optimised away; it is compared with the
/// engine's.
double run_embree(const EmbreeBaseline& embree, const std::vector<Block>& blocks, float radius,
                  Seed seed) {
    double sum = 0;
    EmbreeHit hit{};
    bool have_hit = false;
    for (const Block& block : blocks) {
        if (seed == Seed::kBlockFirst) {
            // One query from the block's center decides whether any voxel of the block can be in
            // the band.
            const Vec3f middle =
                (center(block.lowest) + center(block.lowest + Vec3i{7, 7, 7})) * 0.5f;
            const Vec3f half = center(block.lowest + Vec3i{7, 7, 7}) - middle;
            if (!embree.query(&middle.x, radius + length(half) * 1.0001f, &hit)) continue;
        }
        for (int32_t v = 0; v < 512; ++v) {
            if ((block.demand[static_cast<size_t>(v >> 3)] >> (v & 7) & 1) == 0) continue;
            const Vec3f p = center(block.lowest + Vec3i{v >> 3 & 7, v >> 6, v & 7});
            float r = radius;
            if (seed == Seed::kPrevious && have_hit) {
                const Vec3f d = p - Vec3f{hit.point[0], hit.point[1], hit.point[2]};
                r = std::min(r, length(d) * 1.00001f + 1e-6f);
            }
            have_hit = embree.query(&p.x, r, &hit);
            if (have_hit && hit.distance2 <= radius * radius)
                sum += static_cast<double>(hit.distance2);
        }
    }
    return sum;
}

double run_engine(const nearest::Engine& engine, const std::vector<Block>& blocks, float radius,
                  nearest::QueryCounts* counts) {
    double sum = 0;
    const auto scratch = engine.make_scratch();
    static BlockAnswer answer;
    for (const Block& block : blocks) {
        BlockQuery q;
        q.block = block.lowest;
        q.active = block.demand.data();
        q.radius_mm = radius;
        engine.query(q, scratch.get(), &answer);
        // Eight accumulators break the dependency chain.
        float part[8] = {};
        for (int v = 0; v < nearest::kBlockVoxels; v += 8) {
            for (int l = 0; l < 8; ++l) {
                const float d2 = answer.distance2[v + l];
                part[l] += d2 < kInfinity ? d2 : 0.0f;
            }
        }
        for (const float p : part)
            sum += static_cast<double>(p);
    }
    *counts = scratch->counts;
    return sum;
}

double median(std::vector<double> v) {
    std::sort(v.begin(), v.end());
    return v[v.size() / 2];
}

void report(const char* mesh, size_t triangles, const char* work, const nearest::Engine& engine,
            const EmbreeBaseline* embree, const std::vector<Block>& blocks, float radius,
            const Options& options) {
    int64_t voxels = 0;
    for (const Block& b : blocks)
        voxels += b.asked;
    const Seed other = radius < kInfinity ? Seed::kBlockFirst : Seed::kPrevious;
    std::vector<double> ours, fresh, seeded;
    nearest::QueryCounts counts;
    double sum = 0, fresh_sum = 0, seeded_sum = 0;
    const auto timed = [](std::vector<double>* times, const auto& work_once) {
        const double start = thread_seconds();
        const double result = work_once();
        times->push_back(thread_seconds() - start);
        return result;
    };
    for (int round = 0; round < options.rounds; ++round) {
        sum = timed(&ours, [&] { return run_engine(engine, blocks, radius, &counts); });
        if (embree == nullptr) continue;
        fresh_sum =
            timed(&fresh, [&] { return run_embree(*embree, blocks, radius, Seed::kFresh); });
        seeded_sum = timed(&seeded, [&] { return run_embree(*embree, blocks, radius, other); });
    }
    const double n = static_cast<double>(voxels);
    const double rate = n / median(ours) / 1e6;
    std::printf("%-10s %8zu  %-9s %7lld  %8.3f", mesh, triangles, work,
                static_cast<long long>(voxels), rate);
    if (embree != nullptr) {
        const double rate_fresh = n / median(fresh) / 1e6, rate_seeded = n / median(seeded) / 1e6;
        std::printf("  %8.3f %8.3f  %7.1fx %7.1fx", rate_fresh, rate_seeded, rate / rate_fresh,
                    rate / rate_seeded);
        if (std::abs(sum - fresh_sum) > 1e-4 * sum || std::abs(sum - seeded_sum) > 1e-4 * sum) {
            std::printf("  sums differ: %.9g, Embree %.9g, %.9g", sum, fresh_sum, seeded_sum);
        }
    }
    std::printf("  %6.1f %6.2f\n", static_cast<double>(counts.triangle_tests) * 8 / n,
                static_cast<double>(counts.node_tests) / n);
    std::fflush(stdout);
}

void run_mesh(const char* name, const TriangleMesh& mesh, const Options& options) {
    if (mesh.triangles.empty() || static_cast<int64_t>(mesh.triangles.size()) > options.triangles)
        return;
    if (!options.only.empty() && options.only != name) return;
    const Inside grid = fill(mesh);
    const std::vector<Block> blocks = choose_blocks(grid, options.voxels);
    const testing::MeshSurface surface(mesh);
    const auto frame = testing::make_test_frame(kPitch, {});
    const auto start = Clock::now();
    const auto engine = nearest::make_block_engine(surface, frame);
    const double setup = std::chrono::duration<double>(Clock::now() - start).count();
    std::unique_ptr<EmbreeBaseline> embree;
    if (options.embree) {
        std::vector<float> positions;
        std::vector<uint32_t> triangles;
        for (const Vec3f& p : mesh.positions)
            positions.insert(positions.end(), {p.x, p.y, p.z});
        for (const auto& t : mesh.triangles) {
            for (const int32_t v : t)
                triangles.push_back(static_cast<uint32_t>(v));
        }
        embree = std::make_unique<EmbreeBaseline>(positions, triangles);
    }
    if (options.work.empty() || options.work == "unbounded") {
        report(name, mesh.triangles.size(), "unbounded", *engine, embree.get(), blocks, kInfinity,
               options);
    }
    if (options.work.empty() || options.work == "bounded") {
        report(name, mesh.triangles.size(), "0.5 mm", *engine, embree.get(), blocks, 0.5f, options);
    }
    if (!options.work.empty()) return;
    const auto scratch = engine->make_scratch();
    nearest::BoxBounds bounds;
    for (const int32_t size : {8, 64}) {
        int64_t cubes = 0;
        const double begin = thread_seconds();
        for (const Block& block : blocks) {
            engine->bounds(block.lowest, size, scratch.get(), &bounds);
            ++cubes;
        }
        std::printf("%-10s           bounds of %2d voxels a side: %.2f us a cube\n", name, size,
                    (thread_seconds() - begin) / static_cast<double>(cubes) * 1e6);
    }
    std::printf("%-10s           set-up %.3f s\n", name, setup);
}

/// A closed blob, about 50 mm high: long waves, and a fine one about a millimetre long.
TriangleMesh make_blob(int n) {
    return testing::make_ball(n, [](const Vec3d& d) {
        const double waves =
            std::sin(3 * d.x + 1) * std::cos(4 * d.y) + 0.6 * std::sin(7 * d.z + 2 * d.x);
        const double fine = std::sin(90 * d.x) * std::sin(83 * d.y) * std::sin(97 * d.z);
        return 22.0 * (1 + 0.22 * waves) + 0.12 * fine;
    });
}

/// Spot, a cow, with each triangle in n² and a fine displacement along vertex normals.
TriangleMesh make_spot(int32_t n) {
    TriangleMesh m = testing::subdivide(
        testing::read_obj(OPENFAB_SOURCE_DIR "/tests/data/meshes/spot.obj", 50.0), n);
    std::vector<Vec3f> normals(m.positions.size());
    for (const auto& t : m.triangles) {
        const auto at = [&](size_t k) { return m.positions[t[k]]; };
        const Vec3f n = cross(at(1) - at(0), at(2) - at(0));
        for (const int32_t v : t)
            normals[v] = normals[v] + n;
    }
    for (size_t i = 0; i < m.positions.size(); ++i) {
        const float l = length(normals[i]);
        const Vec3f p = m.positions[i];
        const float h = 0.08f * std::sin(4.1f * p.x) * std::sin(3.7f * p.y) * std::sin(4.4f * p.z);
        if (l > 0) m.positions[i] = p + normals[i] * (h / l);
    }
    return m;
}

int usage() {
    std::fprintf(stderr,
                 "usage: bench_nearest [--rounds N] [--voxels N] [--max-triangles N] [--no-embree] "
                 "[--mesh NAME]\n"
                 "  meshes: blob70k blob280k spot53k spot94k spot287k spot375k; with "
                 "--max-triangles over 989664 also blob1100k spot990k\n");
    return 2;
}

}  // namespace
}  // namespace openfab::bench

int main(int argc, char** argv) {
    using namespace openfab::bench;
    Options options;
    options.triangles = 500000;
    for (int i = 1; i < argc; ++i) {
        const std::string arg = argv[i];
        if (arg == "--no-embree") {
            options.embree = false;
        } else if (i + 1 == argc) {
            return usage();
        } else if (arg == "--rounds") {
            options.rounds = std::max(1, std::atoi(argv[++i]));
        } else if (arg == "--voxels") {
            options.voxels = std::max(1, std::atoi(argv[++i]));
        } else if (arg == "--max-triangles") {
            options.triangles = std::atoll(argv[++i]);
        } else if (arg == "--work") {
            options.work = argv[++i];
        } else if (arg == "--mesh") {
            options.only = argv[++i];
        } else {
            return usage();
        }
    }
    std::printf(
        "M queries a second of processor time on one core, medians of %d interleaved rounds; last "
        "columns: triangle tests "
        "(lanes) and node\n"
        "tests (of 8 lanes) a voxel. Embree seeded: from the previous voxel, or bounded, one query "
        "a block first.\n"
        "mesh       triangles work       voxels   OpenFab    Embree   seeded    /fresh  /seeded   "
        "tests  nodes\n",
        options.rounds);
    const auto wanted = [&](const char* name, int64_t triangles) {
        return triangles <= options.triangles && (options.only.empty() || options.only == name);
    };
    if (wanted("blob70k", 69312)) run_mesh("blob70k", make_blob(76), options);
    if (wanted("blob280k", 277248)) run_mesh("blob280k", make_blob(152), options);
    if (wanted("spot53k", 52704)) run_mesh("spot53k", make_spot(3), options);
    if (wanted("spot94k", 93696)) run_mesh("spot94k", make_spot(4), options);
    if (wanted("spot287k", 286944)) run_mesh("spot287k", make_spot(7), options);
    if (wanted("spot375k", 374784)) run_mesh("spot375k", make_spot(8), options);
    if (wanted("spot990k", 989664)) run_mesh("spot990k", make_spot(13), options);
    if (wanted("blob1100k", 1108992)) run_mesh("blob1100k", make_blob(304), options);
    return 0;
}

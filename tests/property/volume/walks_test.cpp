// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Random walks of a volume stage: to the bit as by a lattice whose nodes are asked one by one, by brute force; whatever is
// kept of the lattice, and whoever made it.

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>
#include <thread>

#include "base/rotation.h"
#include "runtime/nearest/engine/winding.h"
#include "runtime/solid/mesh/mesh_solid.h"
#include "runtime/volume/point_queries.h"
#include "tests/support/meshes/meshes.h"
#include "tests/support/reference/brute_force.h"
#include "tests/support/reference/plain_walk.h"
#include "tests/support/surface/hand_fablet.h"

namespace openfab::volume {
namespace {

using testing::HandMode;

// States: 0 guard, 1..3 point, stop, seed, then where walks end.
constexpr int32_t kGuard = 0, kPoint = 1, kStop = 4, kSeed = 5, kEnd = 6, kOn = 9, kOwnEnd = 10,
                  kStates = 13;
constexpr size_t kVoxels = 512;

const openfab_query_output kEnds[] = {{OPENFAB_QUERY_END, 0, 0, kEnd},
                                      {OPENFAB_QUERY_END, 0, 1, kEnd + 1},
                                      {OPENFAB_QUERY_END, 0, 2, kEnd + 2},
                                      {OPENFAB_QUERY_END_ON, 0, 0, kOn}};
const openfab_query_output kOwnEnds[] = {{OPENFAB_QUERY_END, 0, 0, kOwnEnd},
                                         {OPENFAB_QUERY_END, 0, 1, kOwnEnd + 1},
                                         {OPENFAB_QUERY_END, 0, 2, kOwnEnd + 2}};
const openfab_query kQueries[] = {
    {0, kGuard, {kPoint, kPoint + 1, kPoint + 2}, kStop, kSeed, 4, kEnds},
    {-1, kGuard, {kPoint, kPoint + 1, kPoint + 2}, kStop, kSeed, 3, kOwnEnds},
};

const openfab_fablet& walking_fablet() {
    static const openfab_fablet fablet = [] {
        openfab_fablet f = testing::hand_fablet(true);
        f.object_count = 1;
        f.volume_segments.query_count = 2;
        f.volume_segments.queries = kQueries;
        return f;
    }();
    return fablet;
}

/// A displaced ball with a bent ring inside.
struct Scene {
    std::vector<part::Part> parts;
    std::vector<std::shared_ptr<const surface::Surface>> surfaces;
    std::vector<std::shared_ptr<solid::Solid>> solids;
    std::vector<std::unique_ptr<PlacedPart>> print;
    part::Grid grid;

    Scene() {
        add(walking_fablet(), testing::sphere(5, 24, 12),
            placement_transform({1, 1, 1}, {20, -35, 60}, {3, 2, 1}), 0.6f);
        add(testing::hand_fablet(true), testing::torus(2, 0.9, 16, 8),
            placement_transform({1.2, 0.7, 1}, {75, 10, 5}, {3.5, 2, 1}), 0.1f);
        parts[0].objects = {{1}};
        grid = testing::grid_around(parts[0], {0.25, 0.2, 0.125}, 1);
        surface::SurfaceOptions options;
        options.micro_edge_mm = 0.4;
        const auto trees = nearest::make_patch_cache(1 << 20);
        for (size_t i = 0; i < parts.size(); ++i) {
            print.push_back(std::make_unique<PlacedPart>(parts[i]));
            print[i]->index = static_cast<int32_t>(i);
            surfaces.push_back(std::move(*surface::Surface::create(parts[i], options)));
            solids.push_back(solid::make_solid_of(parts[i], surfaces[i]));
            print[i]->solid = solids[i];
            print[i]->set_grid(grid, {OPENFAB_ISA_AVX2, trees}, 1 << 20, *print[i]);
        }
        resolve_object_queries(print, {OPENFAB_ISA_AVX2, trees});
    }
    void add(const openfab_fablet& fablet, const mesh::Mesh& mesh, const Affine3d& transform,
             float amplitude) {
        testing::PartOptions options;
        options.transform = transform;
        options.uniform_values = testing::hand_uniforms(HandMode::kBumps, amplitude);
        options.instance = static_cast<int32_t>(parts.size());
        parts.push_back(testing::make_part(fablet, mesh, options));
    }
};

/// The points of a block, all of it owned.
struct Batch {
    std::array<int32_t, 3> corner{};
    std::vector<uint8_t> owned = std::vector<uint8_t>(kVoxels / 8, 0xff);
    std::vector<uint32_t> values = std::vector<uint32_t>(kStates * kVoxels, 77);
    std::vector<int32_t> groups;

    explicit Batch(const PlacedPart& part) {
        std::mt19937 random(3);
        const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-23f - 1; };
        const Box3f box = part.solid->bounds();
        for (size_t v = 0; v < kVoxels; ++v) {
            // Some of them outside, or nowhere.
            for (int a = 0; a < 3; ++a)
                set(kPoint + a, v,
                    box.center()[a] + (v % 16 == 0 ? 0.6f : 0.3f) * uniform() * box.size()[a]);
            if (v % 64 == 5) set(kPoint, v, std::nanf(""));
            set(kStop, v, v % 3 == 0 ? 0.3f : 0.6f);
            values[static_cast<size_t>(kSeed) * kVoxels + v] = static_cast<uint32_t>(v) - 100;
            values[v] = v % 5 == 0 ? 1 : 0;
        }
        for (int32_t g = 0; g < 64; ++g)
            groups.push_back(g);
    }
    void set(int32_t state, size_t v, float x) {
        values[static_cast<size_t>(state) * kVoxels + v] = std::bit_cast<uint32_t>(x);
    }
    float at(int32_t state, size_t v) const {
        return std::bit_cast<float>(values[static_cast<size_t>(state) * kVoxels + v]);
    }
    Vec3f point(int32_t state, size_t v) const {
        return {at(state, v), at(state + 1, v), at(state + 2, v)};
    }
    void ask(const Scene& scene, openfab_isa isa = OPENFAB_ISA_AVX512) {
        PointQueries queries(scene.print.size());
        const segments::States states(values.data(), kVoxels);
        queries.begin(*scene.print[0], corner.data(), owned.data(), isa);
        for (const openfab_query& query : kQueries)
            ASSERT_TRUE(queries.answer(query, groups, states).ok());
    }
};

/// A signed distance by brute force, negative inside.
class PlainDistance {
  public:
    PlainDistance(const Scene& scene, size_t part)
        : engine_(
              reference::make_brute_force_engine(*scene.surfaces[part], scene.print[part]->frame)),
          scratch_(engine_->make_scratch()),
          winding_(*scene.surfaces[part]) {}
    float at(const Vec3f& p) {
        nearest::PointPacket one;
        for (size_t a = 0; a < 3; ++a)
            one.p[a][0] = p[static_cast<int>(a)];
        one.mask = 1;
        nearest::PointAnswer answer;
        engine_->query_points({&one, 1}, std::numeric_limits<float>::infinity(), scratch_.get(),
                              &answer);
        const float d = std::sqrt(answer.distance2[0]);
        return winding_.number(p) > 0 ? 0.0f - d : d;
    }

  private:
    std::unique_ptr<nearest::Engine> engine_;
    std::unique_ptr<nearest::Engine::Scratch> scratch_;
    nearest::Winding winding_;
};

TEST(Walks, EndWhereTheirTwinSays) {
    const Scene scene;
    ASSERT_EQ(make_walk_lattices(scene.print, 64 << 20), 2u);
    Batch batch(*scene.print[0]);
    batch.ask(scene);
    const Box3f box = scene.print[0]->solid->bounds();
    const Affine3d move = part::local_to_local(scene.parts[0], scene.parts[1]);
    PlainDistance own_distance(scene, 0), ring_distance(scene, 1);
    const auto inward = [&](const Vec3f& p) { return 0.0f - own_distance.at(p); };
    reference::PlainWalks own(box, inward, {}), both(box, inward, [&](const Vec3f&p) {
        return ring_distance.at(vec_cast<float>(move.apply(vec_cast<double>(p))));
    });
    int walked = 0, on_ring = 0;
    for (size_t v = 0; v < kVoxels; ++v) {
        const Vec3f p = batch.point(kPoint, v), end = batch.point(kEnd, v),
                    own_end = batch.point(kOwnEnd, v);
        const uint32_t on = batch.values[static_cast<size_t>(kOn) * kVoxels + v];
        if (batch.values[v] == 0 || std::isnan(p.x)) {
            EXPECT_TRUE(end == Vec3f() && own_end == Vec3f() && on == 0);
            continue;
        }
        const auto seed =
            static_cast<int32_t>(batch.values[static_cast<size_t>(kSeed) * kVoxels + v]);
        const reference::WalkEnd want = both.end(p, batch.at(kStop, v), seed);
        EXPECT_TRUE(end == want.at) << v;
        EXPECT_EQ(on, want.on_object ? 1u : 0u);
        EXPECT_TRUE(own_end == own.end(p, batch.at(kStop, v), seed).at) << v;
        walked += length(p - end) > 0.5f ? 1 : 0;
        on_ring += on != 0 ? 1 : 0;
    }
    EXPECT_GT(walked, 50);
    EXPECT_GT(on_ring, 15);
}

TEST(Walks, AreTheSameWhateverIsKept) {
    Scene scene;
    make_walk_lattices(scene.print, 64 << 20);
    Batch want(*scene.print[0]);
    want.ask(scene);
    // Nothing, something, and by threads at once.
    for (const size_t bytes : {size_t{0}, size_t{40'000}, size_t{64} << 20}) {
        make_walk_lattices(scene.print, bytes);
        std::vector<Batch> got(3, Batch(*scene.print[0]));
        std::vector<std::thread> threads;
        for (Batch& batch : got)
            threads.emplace_back([&] { batch.ask(scene); });
        for (std::thread& thread : threads)
            thread.join();
        for (const Batch& batch : got)
            EXPECT_TRUE(batch.values == want.values) << bytes;
    }
}

TEST(Walks, AreTheSameInAllInstructionSets) {
    Scene scene;
    make_walk_lattices(scene.print, 64 << 20);
    Batch want(*scene.print[0]);
    want.ask(scene, OPENFAB_ISA_SSE41);
    for (const openfab_isa isa : {OPENFAB_ISA_AVX2, OPENFAB_ISA_AVX512}) {
        Batch got(*scene.print[0]);
        got.ask(scene, isa);
        EXPECT_TRUE(got.values == want.values) << isa;
    }
}

TEST(Walks, PartsThatShareASurfaceShareTheirLattice) {
    Scene scene;
    scene.print[1]->owner = 0;
    openfab_fablet alone = walking_fablet();
    alone.volume_segments.query_count = 1;
    alone.volume_segments.queries = kQueries + 1;
    part::Part second = scene.parts[0], first = scene.parts[0];
    first.fablet = &testing::hand_fablet(true);
    second.fablet = &alone;
    scene.print[0]->part = &first;  // which does not walk
    scene.print[1]->part = &second;
    EXPECT_EQ(make_walk_lattices(scene.print, 1 << 20), 1u);
    EXPECT_EQ(scene.print[0]->lattices[0], nullptr);
    EXPECT_NE(scene.print[1]->lattices[0], nullptr);
}

}  // namespace
}  // namespace openfab::volume

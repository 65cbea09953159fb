// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Random walks through a part of beams, and through the same as it grows: to the bit as by a lattice whose nodes are
// compared with all beams.

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <vector>

#include "runtime/volume/point_queries.h"
#include "tests/support/reference/plain_walk.h"
#include "tests/unit/solid/growing.h"

namespace openfab::volume {
namespace {

// States: 0 guard, 1..3 point, stop, seed, then where walks end.
constexpr int32_t kPoint = 1, kStop = 4, kSeed = 5, kEnd = 6, kStates = 9;
constexpr size_t kVoxels = 512;
const openfab_query_output kEnds[] = {{OPENFAB_QUERY_END, 0, 0, kEnd},
                                      {OPENFAB_QUERY_END, 0, 1, kEnd + 1},
                                      {OPENFAB_QUERY_END, 0, 2, kEnd + 2}};
const openfab_query kQuery = {-1, 0, {kPoint, kPoint + 1, kPoint + 2}, kStop, kSeed, 3, kEnds};

/// A trunk and branches that are thick enough to walk in.
solid::Node stout(const solid::Node& parent, int32_t child, int32_t level, uint32_t path) {
    solid::Node n = solid::bush(parent, child, level, path);
    for (size_t e = 0; e < 2; ++e)
        n.radius[e] *= 2;
    n.reach += 2;
    n.children = level == 3 ? 0 : 2;
    return n;
}

/// The distance to the nearest of all beams, positive inside.
struct AllBeams {
    std::vector<solid::BeamRecord> records;
    std::vector<Vec3f> middles;  ///< on the axes

    explicit AllBeams(const Vec3d& center) {
        solid::Grove grove;
        grove.add(stout, {}, 0, 0, 0);
        for (const solid::Grove::Beam& one : grove.all) {
            records.push_back(solid::record_of(one.beam, center));
            const Vec3f middle = (one.beam.end[0] + one.beam.end[1]) * 0.5f;
            middles.push_back(vec_cast<float>(vec_cast<double>(middle) - center));
        }
    }
    float at(const Vec3f& p) const {
        float least = std::numeric_limits<float>::infinity();
        for (const solid::BeamRecord& beam : records)
            least = std::min(least, solid::beam_distance(beam, p));
        const float size = std::sqrt(least * least);
        return least < 0 ? size : 0.0f - size;
    }
};

void expect_ends_of_twin(solid::Made* made) {
    ASSERT_TRUE(made->status);
    made->fablet.volume_segments.query_count = 1;
    made->fablet.volume_segments.queries = &kQuery;
    std::vector<std::unique_ptr<PlacedPart>> print;
    print.push_back(std::make_unique<PlacedPart>(made->part));
    const auto trees = nearest::make_patch_cache(1 << 20);
    print[0]->solid = made->solid;
    print[0]->set_grid(made->grid, {OPENFAB_ISA_AVX2, trees}, 1 << 20, *print[0]);
    ASSERT_EQ(make_walk_lattices(print, 64 << 20), 1u);

    const AllBeams all(made->part.mesh->center_part_mm);
    std::vector<uint32_t> values(kStates * kVoxels, 0);
    const auto state = [&](int32_t s) { return values.data() + static_cast<size_t>(s) * kVoxels; };
    std::vector<int32_t> groups;
    for (size_t v = 0; v < kVoxels; ++v) {
        if (v % 8 == 0) groups.push_back(static_cast<int32_t>(v / 8));
        const Vec3f& middle = all.middles[v % all.middles.size()];
        for (int32_t a = 0; a < 3; ++a) {
            const float beside = 0.4f * (solid::chance(static_cast<uint32_t>(v), 20 + a) - 0.5f);
            state(kPoint + a)[v] = std::bit_cast<uint32_t>(middle[a] + beside);
        }
        state(kStop)[v] = std::bit_cast<uint32_t>(v % 3 == 0 ? 0.15f : 0.3f);
        state(kSeed)[v] = static_cast<uint32_t>(v);
        state(0)[v] = v % 7 == 0 ? 1 : 0;
    }
    const std::array<int32_t, 3> corner{};
    const std::vector<uint8_t> owned(kVoxels / 8, 0xff);
    PointQueries queries(1);
    queries.begin(*print[0], corner.data(), owned.data(), OPENFAB_ISA_AVX512);
    ASSERT_TRUE(queries.answer(kQuery, groups, segments::States(values.data(), kVoxels)).ok());

    reference::PlainWalks twin(made->solid->bounds(), [&](const Vec3f& p) { return all.at(p); },
                               {});
    int walked = 0;
    for (size_t v = 0; v < kVoxels; ++v) {
        const auto point = [&](int32_t s) {
            return Vec3f{std::bit_cast<float>(state(s)[v]), std::bit_cast<float>(state(s + 1)[v]),
                         std::bit_cast<float>(state(s + 2)[v])};
        };
        const Vec3f p = point(kPoint), end = point(kEnd);
        if (state(0)[v] == 0) {
            EXPECT_TRUE(end == Vec3f());
            continue;
        }
        const float stop = std::bit_cast<float>(state(kStop)[v]);
        EXPECT_TRUE(end == twin.end(p, stop, static_cast<int32_t>(state(kSeed)[v])).at) << v;
        // Near the surface, from where it began in a beam.
        EXPECT_LT(std::fabs(all.at(end)), stop) << v;
        walked += length(p - end) > 0.3f ? 1 : 0;
    }
    EXPECT_GT(walked, 40);
}

TEST(BeamWalks, EndWhereTheirTwinSays) {
    solid::Made beams(stout, solid::kernel<stout>, 0, solid::all_of(stout));
    expect_ends_of_twin(&beams);
}

TEST(BeamWalks, ThroughWhatGrowsEndWhereTheirTwinSays) {
    solid::Made grown(stout, solid::kernel<stout>, solid::kMuch, nullptr);
    expect_ends_of_twin(&grown);
}

}  // namespace
}  // namespace openfab::volume

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Files for printers of filament whose mixtures a slicer prints, read back by the reader of meshes.

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <map>
#include <random>

#include "backends/boundary/messages.h"
#include "backends/boundary/mixed_sink.h"
#include "mesh/read/threemf.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tests/unit/backends/sample_print.h"

namespace openfab::testing {
namespace {

using Amounts = std::vector<float>;

/// The quarters that are nearest to the shares of the three largest amounts, of all that add up to four.
std::vector<int> nearest_quarters(const Amounts& amounts) {
    std::vector<size_t> order;
    for (size_t i = 0; i < amounts.size(); ++i)
        order.push_back(i);
    std::stable_sort(order.begin(), order.end(),
                     [&](size_t a, size_t b) { return amounts[a] > amounts[b]; });
    double sum = 0;
    for (size_t i = 0; i < 3; ++i)
        sum += static_cast<double>(amounts[order[i]]);
    std::vector<int> best(amounts.size());
    double least = 1e9;
    for (int a = 0; a <= 4; ++a) {
        for (int b = 0; a + b <= 4; ++b) {
            const std::array<int, 3> tried = {a, b, 4 - a - b};
            double off = 0;
            for (size_t i = 0; i < 3; ++i)
                off += std::pow(4 * static_cast<double>(amounts[order[i]]) / sum - tried[i], 2);
            if (off >= least) continue;
            least = off;
            best.assign(amounts.size(), 0);
            for (size_t i = 0; i < 3; ++i)
                best[order[i]] = tried[i];
        }
    }
    return best;
}

TEST(MixedFilaments, AmountsAreTheNearestQuarters) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> amount(0, 1);
    for (int n = 0; n < 5000; ++n) {
        Amounts amounts(3 + random() % 5);
        for (float& a : amounts)
            a = random() % 3 == 0 ? 0 : amount(random);
        if (*std::max_element(amounts.begin(), amounts.end()) == 0) continue;
        const std::vector<int> expected = nearest_quarters(amounts);
        const boundary::Quarters is = boundary::quarters_of(amounts);
        for (size_t i = 0; i < amounts.size(); ++i)
            ASSERT_EQ(boundary::share_of(is, i), static_cast<uint32_t>(expected[i])) << n;
    }
    EXPECT_EQ(boundary::quarters_of(Amounts{0, 0, 0}), 0u);
    EXPECT_EQ(boundary::share_of(boundary::quarters_of(Amounts{1, 1, 1, 1}), 0), 2u);
}

/// A print of blocks of 3 x 3 x 2 voxels, each of a mixture, with void between.
struct Blocks {
    SamplePrint print = make_sample({12, 9, 6}, 4);
    std::vector<Amounts> kinds;

    Blocks() {
        print.info.pitch_mm = {0.5, 0.25, 0.125};
        print.info.origin_mm = {-3.5, 2.25, 0};
        print.info.support_code = 0;
        print.info.materials.resize(3);
        const char* const names[] = {"blue", "yellow", "white"};
        for (size_t m = 0; m < 3; ++m) {
            print.info.materials[m].name = names[m];
            print.info.materials[m].preview = {static_cast<uint8_t>(40 * m + 10), 80, 200, 255};
        }
        kinds = {{1, 0, 0}, {0.5f, 0.5f, 0}, {0.3f, 0.7f, 0}, {0, 0.2f, 0.9f}, {1, 1, 2}};
    }
    size_t kind_at(int32_t x, int32_t y, int32_t z) const {
        return static_cast<size_t>(x / 3 + 2 * (y / 3) + 3 * (z / 2)) % (kinds.size() + 1);
    }
    Result<void> write(const std::string& path, bool backwards = false) {
        backends::MixtureInlet inlet(nullptr);
        boundary::MixedSink sink(path, &inlet);
        Result<void> done = sink.begin(print.info);
        if (done) done = inlet.begin(print.info, static_cast<int32_t>(print.info.materials.size()));
        const Vec3i& size = print.info.size;
        for (int32_t z = 0; z < size.z && done; ++z) {
            for (int32_t row = 0; row < size.y; ++row) {
                const int32_t y = backwards ? size.y - 1 - row : row;
                Amounts all;
                for (int32_t x = 0; x < size.x; ++x) {
                    const size_t kind = kind_at(x, y, z);
                    print.at(x, y, z) = kind < kinds.size() ? 1 : 0;
                    Amounts amounts(print.info.materials.size());
                    if (kind < kinds.size()) amounts = kinds[kind];
                    all.insert(all.end(), amounts.begin(), amounts.end());
                }
                inlet.write(z, y, 0, all);
            }
            const std::vector<uint8_t> rows = print.rows(z);
            done = sink.commit(z, sink.encode(print.view(z, rows)));
        }
        const Result<void> finished = sink.finish(print.totals());
        return done ? finished : done;
    }
};

TEST(MixedFilaments, AreReadBackAsMixtures) {
    const ScratchFolder scratch;
    Blocks blocks;
    ASSERT_TRUE(blocks.write((scratch / "part.3mf").string()));
    const std::string bytes = read_file(scratch / "part.3mf");
    const Result<mesh::MeshSource> source = mesh::parse_threemf(bytes, "part.3mf");
    ASSERT_TRUE(source) << source.error().text();
    EXPECT_TRUE(source->checks.edges.fine());
    std::map<std::string, size_t> seen;
    for (size_t t = 0; t < source->mesh.triangles.size(); ++t) {
        Vec3d middle{}, corner[3];
        for (size_t i = 0; i < 3; ++i) {
            corner[i] = source->mesh.positions[static_cast<size_t>(source->mesh.triangles[t][i])];
            middle = middle + corner[i] * (1.0 / 3);
        }
        const Vec3d normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
        const Vec3d at = middle - normal * (0.01 / length(normal)) - blocks.print.info.origin_mm;
        const size_t kind =
            blocks.kind_at(static_cast<int32_t>(at.x / 0.5), static_cast<int32_t>(at.y / 0.25),
                           static_cast<int32_t>(at.z / 0.125));
        ASSERT_LT(kind, blocks.kinds.size());
        const auto& group = source->groups[static_cast<size_t>(source->face_groups[t])];
        const mesh::Look& look = source->looks[static_cast<size_t>(group.look)];
        std::map<std::string, double> is;
        for (const auto& [part, share] : look.mixture)
            is[source->looks[static_cast<size_t>(part)].name] = share;
        if (is.empty()) is[look.name] = 1;
        const std::vector<int> quarters = nearest_quarters(blocks.kinds[kind]);
        std::map<std::string, double> expected;
        for (size_t m = 0; m < 3; ++m)
            if (quarters[m] > 0) expected[blocks.print.info.materials[m].name] = quarters[m] / 4.0;
        ASSERT_EQ(is, expected) << t;
        ++seen[look.name];
    }
    EXPECT_EQ(seen.size(), blocks.kinds.size());
    // The order in which rows come changes nothing.
    ASSERT_TRUE(blocks.write((scratch / "again.3mf").string(), true));
    EXPECT_EQ(read_file(scratch / "again.3mf"), bytes);
}

TEST(MixedFilaments, MoreThanFitAreRefused) {
    const ScratchFolder scratch;
    Blocks blocks;
    blocks.print.info.materials.resize(5, blocks.print.info.materials[0]);
    blocks.kinds.clear();
    for (size_t a = 0; a < 5; ++a) {
        for (size_t b = a + 1; b < 5; ++b) {
            Amounts& kind = blocks.kinds.emplace_back(5);
            kind[a] = kind[b] = 1;
        }
    }
    EXPECT_TRUE(blocks.write((scratch / "fits.3mf").string()));  // five and ten
    blocks.kinds[3] = {3, 0, 1, 0, 0};
    blocks.kinds.push_back({1, 0, 3, 0, 0});
    blocks.kinds.push_back({2, 1, 1, 0, 0});
    const Result<void> many = blocks.write((scratch / "many.3mf").string());
    ASSERT_FALSE(many);
    EXPECT_THAT(many.error().text(), Says(boundary::messages::kTooManyMixtures, "15", "5"));
    EXPECT_FALSE(std::filesystem::exists(scratch / "many.3mf"));
}

}  // namespace
}  // namespace openfab::testing

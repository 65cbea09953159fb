// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// find_thin against its twin, on random solids.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "tests/support/long_run.h"
#include "tests/unit/inspection/opening_twin.h"
#include "tools/inspection/components.h"
#include "tools/inspection/thickness.h"

namespace openfab::inspection {
namespace {

using Random = std::mt19937;

double between(Random* random, double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(*random);
}

Vec3d direction(Random* random) {
    std::normal_distribution<double> normal;
    const Vec3d v{normal(*random), normal(*random), normal(*random)};
    return v * (1 / length(v));
}

/// Adds a random box, cylinder or ball to what is set, or takes it away.
void change(Random* random, const Vec3d& pitch, Bits* bits) {
    const Vec3d a = direction(random);
    Vec3d b = direction(random);
    b = b - a * dot(a, b);
    b = b * (1 / length(b));
    const Vec3d c = cross(a, b);
    Vec3d half, middle;
    for (int axis = 0; axis < 3; ++axis) {
        half[axis] = between(random, 0.4, 4);
        middle[axis] = between(random, 1, bits->size[axis] - 1) * pitch[axis];
    }
    const int kind = static_cast<int>(between(random, 0, 3));
    const uint8_t value = between(random, 0, 1) < 0.7 ? 1 : 0;
    for (int32_t z = 0; z < bits->size.z; ++z) {
        for (int32_t y = 0; y < bits->size.y; ++y) {
            for (int32_t x = 0; x < bits->size.x; ++x) {
                const Vec3d p =
                    Vec3d{(x + 0.5) * pitch.x, (y + 0.5) * pitch.y, (z + 0.5) * pitch.z} - middle;
                const Vec3d q{std::fabs(dot(p, a)), std::fabs(dot(p, b)), std::fabs(dot(p, c))};
                const bool in = kind == 0   ? q.x < half.x && q.y < half.y && q.z < half.z
                                : kind == 1 ? std::hypot(q.x, q.y) < half.x && q.z < half.z
                                            : length(q) < half.x;
                if (in) bits->values[bits->at(x, y, z)] = value;
            }
        }
    }
}

/// All that the twin finds with balls on all halves of voxels is found, for these are more balls than are tried. What is found,
/// no ball on voxel centres or next to what is left covers; and it belongs to what the twin finds with balls on
/// voxel centres, for these are fewer.
void compare(const Bits& bits, int outside, const Vec3d& pitch, double diameter,
             const std::string& which) {
    Box<uint8_t> found(bits.size);
    std::vector<Vec3i> places;
    OpeningTwin more(bits, outside, pitch, diameter, true),
        fewer(bits, outside, pitch, diameter, false);
    const Box<uint8_t> least = more.thin(), most = fewer.thin();
    for (const Thin& thin : find_thin(bits, outside, pitch, diameter)) {
        ASSERT_GT(thin.thickness_mm, 0) << which;
        ASSERT_LT(thin.thickness_mm, diameter) << which;
        for (const Vec3i& p : thin.voxels)
            found.values[found.at(p.x, p.y, p.z)] = 1;
    }
    const auto on_surface = [&](const Vec3i& p) {
        for (int n = 0; n < 6; ++n) {
            Vec3i q = p;
            q[n / 2] += n % 2 == 0 ? 1 : -1;
            if (!more.set(q)) return true;
        }
        return false;
    };
    const auto near_thin = [&](const Vec3i& p) {
        for (int32_t z = 0; z < bits.size.z; ++z) {
            for (int32_t y = 0; y < bits.size.y; ++y) {
                for (int32_t x = 0; x < bits.size.x; ++x) {
                    const uint8_t state = most.values[bits.at(x, y, z)];
                    if (state == 0) continue;
                    const Vec3d d = more.place(p) - more.place({x, y, z});
                    if (length(d) > more.depth(more.place({x, y, z}))) continue;
                    if (state == 2 || fewer.halfway({x, y, z})) return true;
                }
            }
        }
        return false;
    };
    for (int32_t z = 0; z < bits.size.z; ++z) {
        for (int32_t y = 0; y < bits.size.y; ++y) {
            for (int32_t x = 0; x < bits.size.x; ++x) {
                const size_t at = bits.at(x, y, z);
                if (least.values[at] == 2 && on_surface({x, y, z})) {
                    ASSERT_EQ(found.values[at], 1)
                        << which << ", missed " << x << " " << y << " " << z;
                }
                if (found.values[at] == 0) continue;
                ASSERT_NE(most.values[at], 0) << which << ", covered " << x << " " << y << " " << z;
                ASSERT_TRUE(near_thin({x, y, z}))
                    << which << ", an edge " << x << " " << y << " " << z;
            }
        }
    }
}

TEST(Opening, AgreesWithItsTwin) {
    Random random(19);
    const int trials = testing::long_run() ? 10000 : 60;
    for (int trial = 0; trial < trials; ++trial) {
        Vec3d pitch{1, 1, 1};
        if (trial % 4 == 3)
            pitch = {between(&random, 0.6, 1.2), between(&random, 0.6, 1.2),
                     between(&random, 0.6, 1.2)};
        Bits bits({10, 10, 10});
        const int outside = trial % 3 == 2 ? 1 : 0;
        for (int i = 0; i < 1 + trial % 5; ++i)
            change(&random, pitch, &bits);
        if (outside != 0) {
            for (uint8_t& value : bits.values)
                value = 1 - value;
        }
        const double diameter = between(&random, 2.3, 6);
        compare(bits, outside, pitch, diameter, "trial " + std::to_string(trial));
        if (::testing::Test::HasFatalFailure()) return;
    }
}

}  // namespace
}  // namespace openfab::inspection

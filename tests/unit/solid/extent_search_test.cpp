// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The extent of a solid, and of its pieces, against closed forms of a ball.

#include "runtime/solid/extent/extent_search.h"

#include <gtest/gtest.h>

#include <cmath>

namespace openfab::solid {
namespace {

constexpr double kRadius = 1.25;
constexpr double kNear = 1e-5;

class Ball final : public SolidValue {
  public:
    Box3f box() const override { return {{-2, -2, -2}, {2, 2, 2}}; }
    void values(std::span<const Vec3f> points, float* out) const override {
        for (const Vec3f& p : points)
            *out++ = length(p) - static_cast<float>(kRadius);
    }
    void lower_bounds(std::span<const Box3f> boxes, float* out) const override {
        for (const Box3f& box : boxes) {
            const Vec3f p = box.center();
            *out++ = length(p) - static_cast<float>(kRadius) - length(box.hi - p);
        }
    }
};

constexpr std::array<double, 9> kAsItIs{1, 0, 0, 0, 1, 0, 0, 0, 1};

void expect_box(const Extent& found, const Box3d& expected) {
    for (int a = 0; a < 3; ++a) {
        EXPECT_NEAR(found.box.lo[a], expected.lo[a], kNear) << a;
        EXPECT_NEAR(found.box.hi[a], expected.hi[a], kNear) << a;
    }
}

TEST(ExtentSearch, OfAWholeBall) {
    expect_box(find_extent(Ball(), kAsItIs, {}),
               {{-kRadius, -kRadius, -kRadius}, {kRadius, kRadius, kRadius}});
}

// A cap is as wide as the circle of its cut, and its far side is whole.
TEST(ExtentSearch, OfItsCap) {
    const double at = 0.75, wide = std::sqrt(kRadius * kRadius - at * at);
    const pieces::Side front{{1, 0, 0}, at, true}, back{{1, 0, 0}, at, false};
    expect_box(find_extent(Ball(), kAsItIs, {&front, 1}),
               {{at, -wide, -wide}, {kRadius, wide, wide}});
    expect_box(find_extent(Ball(), kAsItIs, {&back, 1}),
               {{-kRadius, -kRadius, -kRadius}, {at, kRadius, kRadius}});
}

// Cuts meet in an edge within it, which reaches farthest down.
TEST(ExtentSearch, OfAWedge) {
    const double s = std::sqrt(0.5);
    const std::array<pieces::Side, 2> sides{{{{s, 0, s}, 0.25, true}, {{-s, 0, s}, 0.25, true}}};
    // Both planes hold x = 0, z = 0.25 / s.
    const Extent found = find_extent(Ball(), kAsItIs, sides);
    const double low = 0.25 / s;
    EXPECT_NEAR(found.box.lo.z, low, kNear);
    EXPECT_NEAR(found.box.hi.z, kRadius, kNear);
    EXPECT_NEAR(found.box.hi.y, std::sqrt(kRadius * kRadius - low * low), kNear);
}

TEST(ExtentSearch, OfATurnedCap) {
    // z' is x: the cap's axis.
    const pieces::Side front{{1, 0, 0}, 1, true};
    const double wide = std::sqrt(kRadius * kRadius - 1);
    expect_box(find_extent(Ball(), {0, 1, 0, 0, 0, 1, 1, 0, 0}, {&front, 1}),
               {{-wide, -wide, 1}, {wide, wide, kRadius}});
}

TEST(ExtentSearch, OfNothing) {
    const pieces::Side front{{1, 0, 0}, 1.5, true};
    EXPECT_TRUE(find_extent(Ball(), kAsItIs, {&front, 1}).box.empty());
}

}  // namespace
}  // namespace openfab::solid

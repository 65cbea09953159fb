// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Clearances against a search around each dual cell.

#include "tools/render/clearances.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/unit/render/render_fixture.h"

namespace openfab::testing {
namespace {

using render::Clearances;
using render::Volume;

/// 0 mixed, 1 solid, 2 void.
int32_t state_of(const Volume& volume, const Vec3i& dual) {
    int32_t inside = 0;
    for (const int32_t coverage : volume.corners(dual.x, dual.y, dual.z))
        inside += coverage >= Volume::kSurface ? 1 : 0;
    return inside == 8 ? 1 : inside == 0 ? 2 : 0;
}

/// The states of all dual cells but those at the border.
class States {
  public:
    explicit States(const Volume& volume)
        : size_{volume.blocks().x * 8, volume.blocks().y * 8, volume.blocks().z * 8} {
        states_.resize(index({0, 0, size_.z}), 2);
        for (int32_t z = 1; z + 1 < size_.z; ++z) {
            for (int32_t y = 1; y + 1 < size_.y; ++y) {
                for (int32_t x = 1; x + 1 < size_.x; ++x)
                    states_[index({x, y, z})] = static_cast<uint8_t>(state_of(volume, {x, y, z}));
            }
        }
    }
    int32_t clearance(const Vec3i& dual) const {
        const int32_t state = states_[index(dual)];
        if (state == 0) return 0;
        int32_t clearance = 1;
        while (clearance < Clearances::kMost && is_around(dual, clearance, state))
            ++clearance;
        return clearance + (state == 2 ? Clearances::kVoid : 0);
    }

  private:
    bool is_around(const Vec3i& dual, int32_t reach, int32_t state) const {
        for (int32_t z = -reach; z <= reach; ++z) {
            for (int32_t y = -reach; y <= reach; ++y) {
                for (int32_t x = -reach; x <= reach; ++x) {
                    if (states_[index(dual + Vec3i{x, y, z})] != state) return false;
                }
            }
        }
        return true;
    }
    size_t index(const Vec3i& at) const {
        return (static_cast<size_t>(at.z) * static_cast<size_t>(size_.y) +
                static_cast<size_t>(at.y)) *
                   static_cast<size_t>(size_.x) +
               static_cast<size_t>(at.x);
    }

    Vec3i size_;
    std::vector<uint8_t> states_;
};

/// A ball with a hole, a thin wall and a single voxel.
Volume part() {
    return make_volume({36, 30, 34}, {0.05, 0.08, 0.03}, [](int32_t x, int32_t y, int32_t z) {
        const Vec3d at{(x - 15) * 0.05, (y - 11) * 0.08, (z - 17) * 0.03};
        const bool is_ball = length(at) < 0.5 && length(at) > 0.15;
        return static_cast<uint8_t>(is_ball || x == 33 || (x == 2 && y == 27 && z == 3) ? 1 : 0);
    });
}

TEST(Clearances, AreWhatASearchFinds) {
    const Volume volume = part();
    const Clearances clearances(volume);
    const States states(volume);
    int32_t seen[16] = {};
    const Vec3i blocks = volume.blocks();
    for (int32_t z = 8; z < blocks.z * 8 - 8; ++z) {
        for (int32_t y = 8; y < blocks.y * 8 - 8; ++y) {
            for (int32_t x = 8; x < blocks.x * 8 - 8; ++x) {
                const Clearances::Clearance got = clearances.at(x, y, z);
                ASSERT_EQ(got.value, states.clearance({x, y, z})) << x << " " << y << " " << z;
                ++seen[got.value];
            }
        }
    }
    for (const int32_t value : {0, 1, 2, 3, 5, 6, 7})
        EXPECT_GT(seen[value], 0) << value;
}

TEST(Clearances, TellWhatBlocksAre) {
    const Volume volume = make_volume({64, 64, 64}, {0.05, 0.08, 0.03},
                                      [](int32_t, int32_t, int32_t) { return uint8_t{1}; });
    const Clearances clearances(volume);
    const Vec3i middle{volume.blocks().x / 2, volume.blocks().y / 2, volume.blocks().z / 2};
    EXPECT_EQ(clearances.kind({0, 0, 0}), Clearances::Kind::kOutside);
    EXPECT_EQ(clearances.kind(middle), Clearances::Kind::kInside);
    EXPECT_EQ(clearances.kind({Volume::kGroup, middle.y, middle.z}), Clearances::Kind::kSurface);
    EXPECT_TRUE(clearances.at(middle.x * 8, middle.y * 8, middle.z * 8).is_of_block);
}

}  // namespace
}  // namespace openfab::testing

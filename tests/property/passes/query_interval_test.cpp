// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The interval of `distance(p)` over cubes of voxels in a ball contains the value of each voxel
// inside, and is not trivial.

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "base/vec.h"
#include "compiler/frontend/frontend.h"
#include "compiler/interp/evaluate.h"
#include "compiler/passes/form_volume_bounds.h"
#include "tests/support/places/places.h"

namespace openfab {
namespace {

constexpr float kRadius = 10;
const Vec3f kMiddle{1, 2, 3};  // part-local

float signed_distance(const Vec3f& p) {
    return static_cast<float>(length(vec_cast<double>(p - kMiddle)) - kRadius);
}

/// A frame turned about z, with unequal pitch and the part's centre away from the origin.
std::array<float, OPENFAB_FRAME_COUNT> make_frame() {
    std::array<float, OPENFAB_FRAME_COUNT> f{};
    const float c = 0.8f, s = 0.6f;
    const float pitch[3] = {0.15f, 0.1f, 0.06f};
    const float steps[9] = {c * pitch[0], s * pitch[0], 0, -s * pitch[1], c * pitch[1], 0, 0, 0,
                            pitch[2]};
    for (size_t k = 0; k < 9; ++k)
        f[OPENFAB_FRAME_STEP_I + k] = steps[k];
    for (size_t a = 0; a < 3; ++a) {
        f[OPENFAB_FRAME_ORIGIN + a] = 0.01f * static_cast<float>(a);
        f[OPENFAB_FRAME_CENTER + a] = 31.7f - 20 * static_cast<float>(a);
        f[OPENFAB_FRAME_VOXEL_SIZE + a] = pitch[a];
    }
    return f;
}

Vec3f centre(const std::array<float, OPENFAB_FRAME_COUNT>& f, const Vec3i& voxel) {
    const float x = static_cast<float>(voxel.x) + 0.5f, y = static_cast<float>(voxel.y) + 0.5f,
                z = static_cast<float>(voxel.z) + 0.5f;
    Vec3f p;
    for (int a = 0; a < 3; ++a) {
        const auto k = static_cast<size_t>(a);
        p[a] = ((x * f[OPENFAB_FRAME_STEP_I + k] + y * f[OPENFAB_FRAME_STEP_J + k]) +
                z * f[OPENFAB_FRAME_STEP_K + k]) +
               f[OPENFAB_FRAME_ORIGIN + k];
    }
    return p;
}

class Place : public interp::Environment {
  public:
    explicit Place(const std::array<float, OPENFAB_FRAME_COUNT>& frame) : frame_(frame) {}
    uint32_t input(int32_t kind, int32_t a, int32_t) const override {
        switch (kind) {
            case OPENFAB_ARG_FRAME:
                return std::bit_cast<uint32_t>(frame_[a]);
            case ir::kVoxelCoord:
            case ir::kVoxelCoordLo:
                return std::bit_cast<uint32_t>(static_cast<float>(low[a]) + 0.5f);
            case ir::kVoxelCoordHi:
                return std::bit_cast<uint32_t>(static_cast<float>(low[a] + size) - 0.5f);
            case OPENFAB_ARG_DISTANCE:
            case OPENFAB_ARG_DISTANCE_LO:
                return std::bit_cast<uint32_t>(distance[0]);
            case OPENFAB_ARG_DISTANCE_HI:
                return std::bit_cast<uint32_t>(distance[1]);
            default:
                ADD_FAILURE() << "input " << kind;
                return 0;
        }
    }
    interp::TextureView texture(int32_t) const override { return {}; }
    uint32_t query(const ir::Instr&, const ir::Instr& result,
                   std::span<const uint32_t> args) const override {
        EXPECT_EQ(result.kind, OPENFAB_QUERY_DISTANCE);
        const auto at = [&](size_t k) { return std::bit_cast<float>(args[k]); };
        return std::bit_cast<uint32_t>(signed_distance({at(1), at(2), at(3)}));
    }

    Vec3i low;
    int32_t size = 1;
    std::array<float, 2> distance{};

  private:
    const std::array<float, OPENFAB_FRAME_COUNT>& frame_;
};

TEST(QueryInterval, HoldsWhatVoxelsGet) {
    source::SourceManager sources;
    diag::Sink sink;
    std::string fault;
    const auto module = frontend::compile_to_ir(
        sources, testing::source_dir() / "tests/property/passes/query_interval.fl", sink, &fault);
    ASSERT_TRUE(module) << fault;
    const ir::Stage& volume = module->fablets[0].volume;
    const ir::Stage bounds = passes::form_volume_bounds(volume);
    ASSERT_EQ(ir::verify(bounds), "");
    const auto frame = make_frame();
    std::mt19937 random(3);
    double width[5] = {};
    int cubes = 0;
    for (int i = 0; i < 900; ++i) {
        Place cube(frame);
        cube.size = 8 << (i % 3);
        for (int a = 0; a < 3; ++a)
            cube.low[a] = static_cast<int32_t>(random() % 260) - 120;
        std::vector<Vec3i> inside;
        cube.distance = {std::numeric_limits<float>::infinity(),
                         -std::numeric_limits<float>::infinity()};
        for (int n = 0; n < 200; ++n) {
            Vec3i v;
            for (int a = 0; a < 3; ++a)
                v[a] =
                    cube.low[a] + static_cast<int32_t>(random() % static_cast<uint32_t>(cube.size));
            const float d = signed_distance(centre(frame, v));
            if (d >= 0) continue;
            inside.push_back(v);
            cube.distance = {std::min(cube.distance[0], d), std::max(cube.distance[1], d)};
        }
        if (inside.empty()) continue;
        ++cubes;
        const std::vector<uint32_t> ends = interp::evaluate(bounds, cube);
        for (const Vec3i& v : inside) {
            Place voxel(frame);
            voxel.low = v;
            voxel.distance[0] = signed_distance(centre(frame, v));
            const std::vector<uint32_t> values = interp::evaluate(volume, voxel);
            for (size_t k = 0; k < 5; ++k) {
                const float value = std::bit_cast<float>(values[k]);
                ASSERT_LE(std::bit_cast<float>(ends[2 * k]), value) << k;
                ASSERT_GE(std::bit_cast<float>(ends[2 * k + 1]), value) << k;
            }
        }
        for (size_t k = 0; k < 5; ++k) {
            width[k] += std::bit_cast<float>(ends[2 * k + 1]) - std::bit_cast<float>(ends[2 * k]) -
                        (cube.distance[1] - cube.distance[0]);
        }
    }
    ASSERT_GT(cubes, 200);
    // The added width is twice the length of the offset, and little more.
    EXPECT_LT(width[0] / cubes, 2 * std::sqrt(0.38) + 0.1);
    EXPECT_LT(width[1] / cubes, 2 * std::sqrt(0.53) + 0.1);
    EXPECT_LT(width[4] / cubes, 1e-6);
}

}  // namespace
}  // namespace openfab

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/beams/beam_block.h"

#include <algorithm>

#include "base/at.h"
#include "base/infinity.h"

namespace openfab::solid {

void BeamCube::set(const VoxelFrame& frame, const Vec3i& lowest) {
    for (size_t a = 0; a < 3; ++a) {
        for (int32_t i = 0; i < kCubeVoxels; ++i) {
            p[a][i] = frame.centre(a, static_cast<float>(lowest.x + i / 4 % 4) + 0.5f,
                                   static_cast<float>(lowest.y + i / 16) + 0.5f,
                                   static_cast<float>(lowest.z + i % 4) + 0.5f);
        }
    }
}

void BeamCube::find_nearest(const std::vector<BeamRecord>& beams, std::span<const int32_t> list) {
    std::fill_n(distance, kCubeVoxels, kInfinity);
    std::fill_n(beam, kCubeVoxels, -1);
    for (const int32_t number : list) {
        const BeamRecord record = beams[static_cast<size_t>(number)];
        if (record.round) {
            for (int32_t i = 0; i < kCubeVoxels; ++i) {
                const float d = round_distance(record, p[0][i], p[1][i], p[2][i]);
                const bool nearer = d < distance[i];
                distance[i] = nearer ? d : distance[i];
                beam[i] = nearer ? number : beam[i];
            }
            continue;
        }
        for (int32_t i = 0; i < kCubeVoxels; ++i) {
            const float d = cut_distance(record, p[0][i], p[1][i], p[2][i]);
            if (d < distance[i]) distance[i] = d, beam[i] = number;
        }
    }
}

void BeamCube::find_distance(const std::vector<BeamRecord>& beams, std::span<const int32_t> list) {
    std::fill_n(distance, kCubeVoxels, kInfinity);
    for (const int32_t number : list) {
        const BeamRecord record = beams[static_cast<size_t>(number)];
        if (record.round) {
            for (int32_t i = 0; i < kCubeVoxels; ++i) {
                const float d = round_distance(record, p[0][i], p[1][i], p[2][i]);
                distance[i] = d < distance[i] ? d : distance[i];
            }
            continue;
        }
        for (int32_t i = 0; i < kCubeVoxels; ++i)
            distance[i] = std::min(distance[i], cut_distance(record, p[0][i], p[1][i], p[2][i]));
    }
}

VoxelBall voxel_ball(const VoxelFrame& frame, const Vec3i& lowest, const Vec3i& size) {
    const auto at = [&](int axis) {
        return static_cast<float>(lowest[axis]) + 0.5f * static_cast<float>(size[axis]);
    };
    VoxelBall ball;
    for (size_t a = 0; a < 3; ++a)
        ball.middle[static_cast<int>(a)] = frame.centre(a, at(0), at(1), at(2));
    // Four corners: the others lie opposite to them.
    for (int corner = 0; corner < 4; ++corner) {
        const auto end = [&](int axis, bool high) {
            return static_cast<float>(high ? lowest[axis] + size[axis] - 1 : lowest[axis]) + 0.5f;
        };
        const float x = end(0, (corner & 1) != 0), y = end(1, (corner & 2) != 0), z = end(2, false);
        Vec3f from;
        for (size_t a = 0; a < 3; ++a)
            from[static_cast<int>(a)] = frame.centre(a, x, y, z) - ball.middle[static_cast<int>(a)];
        ball.radius = std::max(ball.radius, length(from));
    }
    ball.radius *= 1 + 0x1p-16f;
    return ball;
}

NearestBeam BeamList::gather(const BeamTree& tree, const VoxelBall& ball, int32_t start) {
    const NearestBeam best = tree.nearest(ball.middle, start);
    nearest_ = best.distance;
    beams_.clear();
    tree.collect(ball.middle, best.distance + 2 * ball.radius, &beams_);
    std::ranges::sort(beams_, {}, [&](int32_t i) { return at(tree.beams(), i).number; });
    return best;
}

void BeamList::gather(const BeamTree& tree, const VoxelBall& ball, std::span<const int32_t> of) {
    distances_.clear();
    nearest_ = kInfinity;
    for (const int32_t i : of) {
        distances_.push_back(beam_distance(at(tree.beams(), i), ball.middle));
        nearest_ = std::min(nearest_, distances_.back());
    }
    const float most = nearest_ + 2 * ball.radius + tree.slack(ball.middle);
    beams_.clear();
    for (size_t i = 0; i < of.size(); ++i) {
        if (distances_[i] <= most) beams_.push_back(of[i]);
    }
}

bool BeamList::gather_holding(const BeamTree& tree, const VoxelBall& ball,
                              std::span<const int32_t> of) {
    beams_.clear();
    const float reach = ball.radius + tree.slack(ball.middle);
    for (const int32_t i : of) {
        const float d = beam_distance(at(tree.beams(), i), ball.middle);
        if (d < 0.0f - reach) return true;
        if (d <= reach) beams_.push_back(i);
    }
    return false;
}

}  // namespace openfab::solid

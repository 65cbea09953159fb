// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/beams/beam_engine.h"

#include <algorithm>
#include <cmath>

#include "base/at.h"
#include "base/infinity.h"

namespace openfab::solid {

namespace {

using nearest::kBlockVoxels;

constexpr size_t kMostCases = 64;  // beams near a cube whose attributes are looked at one by one

struct BeamScratch final : nearest::Engine::Scratch {
    BeamList of_block, of_cube;
    BeamCube cube;
    int32_t last = -1;  ///< the beam that was nearest last: where the next search begins
};

/// Returns the range of the magnitude of signed distances around one.
std::array<float, 2> magnitude(float middle, float reach) {
    const float far = std::fabs(middle);
    return {std::max(0.0f, far - reach), far + reach};
}

class BeamEngine final : public nearest::Engine {
  public:
    BeamEngine(const BeamTree& tree, const VoxelFrame& frame, const BeamAttributes* attributes)
        : tree_(tree), frame_(frame), attributes_(attributes) {}

    std::unique_ptr<Scratch> make_scratch() const override {
        return std::make_unique<BeamScratch>();
    }

    void query(const nearest::BlockQuery& query, Scratch* scratch,
               nearest::BlockAnswer* answer) const override {
        auto* mine = static_cast<BeamScratch*>(scratch);
        const NearestBeam near =
            mine->of_block.gather(tree_, voxel_ball(frame_, query.block, {8, 8, 8}), mine->last);
        mine->last = near.beam;
        for (int32_t k = 0; k < 8; ++k) {
            const Vec3i from{4 * (k & 1), 4 * (k >> 1 & 1), 4 * (k >> 2)};
            const uint32_t wanted = active_columns(query.active, from);
            if (wanted != 0) {
                const Vec3i lowest = query.block + from;
                const VoxelBall ball = voxel_ball(frame_, lowest, {4, 4, 4});
                // Where beams crowd, the tree finds the few of a cube sooner than the block's list.
                if (mine->of_block.beams().size() > kMostCases) {
                    mine->last = mine->of_cube.gather(tree_, ball, mine->last).beam;
                } else {
                    mine->of_cube.gather(tree_, ball, mine->of_block.beams());
                }
                mine->cube.set(frame_, lowest);
                mine->cube.find_nearest(tree_.beams(), mine->of_cube.beams());
                mine->counts.triangle_tests +=
                    kCubeVoxels * static_cast<int64_t>(mine->of_cube.beams().size());
            }
            write_cube(query, from, mine, answer);
        }
    }

    void query_points(std::span<const nearest::PointPacket> packets, float radius_mm,
                      Scratch* scratch, nearest::PointAnswer* answers) const override {
        auto* mine = static_cast<BeamScratch*>(scratch);
        for (size_t g = 0; g < packets.size(); ++g) {
            nearest::PointAnswer& to = answers[g];
            to = {};
            for (size_t l = 0; l < 8; ++l) {
                to.distance2[l] = kInfinity;
                to.item[l] = -1;
                if (!packets[g].asks(l)) continue;
                const Vec3f p = packets[g].point(l);
                ++mine->counts.queried;
                const NearestBeam near = tree_.nearest(p, mine->last);
                mine->last = near.beam;
                if (!(std::fabs(near.distance) <= radius_mm)) continue;
                to.distance2[l] = near.distance * near.distance;
                to.item[l] = near.beam;
                const BeamRecord& beam = tree_.beams()[static_cast<size_t>(near.beam)];
                to.set_point(l, nearest_of_beam(beam, p).position);
            }
        }
    }

    void bound_blocks(std::span<const Vec3i> blocks, Scratch* scratch,
                      nearest::BlockBounds* bounds) const override {
        auto* mine = static_cast<BeamScratch*>(scratch);
        const nearest::BlockPieces& cut = pieces();
        for (size_t i = 0; i < blocks.size(); ++i) {
            for (size_t q = 0; q < cut.lowest.size(); ++q) {
                const VoxelBall ball = voxel_ball(frame_, blocks[i] + cut.lowest[q], cut.size);
                const NearestBeam near = tree_.nearest(ball.middle, mine->last);
                mine->last = near.beam;
                const auto [low, high] =
                    magnitude(near.distance, ball.radius + tree_.slack(ball.middle));
                bounds[i].low[q] = low;
                bounds[i].high[q] = high;
            }
        }
    }

    void bounds(const Vec3i& lowest, int32_t size, Scratch* scratch,
                nearest::BoxBounds* out) const override {
        auto* mine = static_cast<BeamScratch*>(scratch);
        const VoxelBall ball = voxel_ball(frame_, lowest, {size, size, size});
        const NearestBeam near = tree_.nearest(ball.middle, mine->last);
        mine->last = near.beam;
        const auto [low, high] = magnitude(near.distance, ball.radius + tree_.slack(ball.middle));
        out->clear();
        out->distance_hi = high;
        if (attributes_ == nullptr || attributes_->floats() + attributes_->ints() == 0) {
            out->add(low, {}, {}, {}, {});
            return;
        }
        mine->of_block.gather(tree_, ball, near.beam);
        if (mine->of_block.beams().size() > kMostCases) return attributes_->add_all(low, out);
        for (const int32_t i : mine->of_block.beams())
            attributes_->add_case(at(tree_.beams(), i), low, out);
    }

  private:
    /// Returns the columns of a cube, 4 y + x, in which a voxel is active.
    static uint32_t active_columns(const uint8_t* active, const Vec3i& from) {
        if (active == nullptr) return 0xffff;
        uint32_t columns = 0;
        for (int32_t c = 0; c < 16; ++c) {
            const uint8_t bits = active[(from.y + c / 4) * 8 + from.x + c % 4];
            columns |= (bits >> from.z & 0xf) != 0 ? 1u << c : 0u;
        }
        return columns;
    }

    void write_cube(const nearest::BlockQuery& query, const Vec3i& from, BeamScratch* mine,
                    nearest::BlockAnswer* answer) const {
        for (int32_t i = 0; i < kCubeVoxels; ++i) {
            const int32_t column = (from.y + i / 16) * 8 + from.x + i / 4 % 4;
            const int32_t z = from.z + i % 4;
            const auto to = static_cast<size_t>(8 * column + z);
            const bool active = query.active == nullptr || (query.active[column] >> z & 1) != 0;
            const float d = active ? mine->cube.distance[i] : kInfinity;
            mine->counts.queried += active ? 1 : 0;
            mine->counts.skipped += active ? 0 : 1;
            answer->distance2[to] = kInfinity;
            answer->item[to] = -1;
            answer->set_point(to, {});
            if (!(std::fabs(d) <= query.radius_mm) || !(d < kInfinity)) continue;
            answer->distance2[to] = d * d;
            answer->item[to] = mine->cube.beam[i];
            if (attributes_ == nullptr) continue;
            const Vec3f p{mine->cube.p[0][i], mine->cube.p[1][i], mine->cube.p[2][i]};
            const BeamRecord& beam = tree_.beams()[static_cast<size_t>(mine->cube.beam[i])];
            answer->set_point(to, nearest_of_beam(beam, p).position);
        }
    }

    const BeamTree& tree_;
    const VoxelFrame frame_;
    const BeamAttributes* attributes_;
};

}  // namespace

std::unique_ptr<nearest::Engine> make_beam_engine(const BeamTree& tree, const VoxelFrame& frame,
                                                  const BeamAttributes* attributes) {
    return std::make_unique<BeamEngine>(tree, frame, attributes);
}

}  // namespace openfab::solid

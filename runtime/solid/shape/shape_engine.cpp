// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/shape/shape_engine.h"

#include <algorithm>
#include <limits>

namespace openfab::solid {

namespace {

struct ShapeEngineScratch final : nearest::Engine::Scratch {
    std::unique_ptr<nearest::Engine::Scratch> nearest;
    ShapeNear::Tools near;
};

class ShapeEngine final : public nearest::Engine {
  public:
    ShapeEngine(const ShapeNear& near, const VoxelFrame& frame,
                std::unique_ptr<nearest::Engine> nearest)
        : near_(near), frame_(frame), nearest_(std::move(nearest)) {}

    std::unique_ptr<Scratch> make_scratch() const override {
        auto scratch = std::make_unique<ShapeEngineScratch>();
        scratch->nearest = nearest_->make_scratch();
        return scratch;
    }
    void query(const nearest::BlockQuery& query, Scratch* scratch,
               nearest::BlockAnswer* answer) const override {
        const Forward to(scratch);
        nearest_->query(query, to.scratch(), answer);
    }
    void query_points(std::span<const nearest::PointPacket> packets, float radius_mm,
                      Scratch* scratch, nearest::PointAnswer* answers) const override {
        const Forward to(scratch);
        nearest_->query_points(packets, radius_mm, to.scratch(), answers);
    }
    void bounds(const Vec3i& lowest, int32_t size, Scratch* scratch,
                nearest::BoxBounds* out) const override {
        const Forward to(scratch);
        nearest_->bounds(lowest, size, to.scratch(), out);
    }
    const nearest::BlockPieces& pieces() const override { return nearest_->pieces(); }

    void bound_points(std::span<const nearest::PointPacket> packets,
                      std::span<const nearest::PointPacket> /*hints*/, float /*tolerance_mm*/,
                      Scratch* scratch, nearest::PointBounds* bounds) const override {
        auto* mine = static_cast<ShapeEngineScratch*>(scratch);
        constexpr size_t kAtOnce = kMostNearBoxes / 8;
        std::array<Box3f, kMostNearBoxes> boxes;
        std::array<NearRange, kMostNearBoxes> ranges;
        for (size_t first = 0; first < packets.size(); first += kAtOnce) {
            const size_t count = std::min(kAtOnce, packets.size() - first);
            Box3f whole;
            for (size_t i = 0; i < 8 * count; ++i) {
                const Vec3f p = packets[first + i / 8].point(i % 8);
                boxes[i] = {p, p};
                whole.add(p);
            }
            // What is near is found once for points that are close to each other.
            const std::span<const Box3f> all(boxes.data(), 8 * count);
            if (whole.longest_side() <= near_.block_mm()) {
                near_.bound(whole, all, &mine->near, ranges.data());
            } else {
                for (size_t i = 0; i < all.size(); ++i)
                    near_.bound(all[i], {&all[i], 1}, &mine->near, &ranges[i]);
            }
            for (size_t i = 0; i < all.size(); ++i) {
                nearest::PointBounds& to = bounds[first + i / 8];
                to.low[i % 8] = ranges[i].low;
                to.high[i % 8] = ranges[i].high;
                for (auto& coordinate : to.point)
                    coordinate[i % 8] = std::numeric_limits<float>::quiet_NaN();
            }
        }
    }
    void bound_blocks(std::span<const Vec3i> blocks, Scratch* scratch,
                      nearest::BlockBounds* bounds) const override {
        auto* mine = static_cast<ShapeEngineScratch*>(scratch);
        const nearest::BlockPieces& cut = pieces();
        std::array<Box3f, std::tuple_size_v<decltype(cut.lowest)>> boxes;
        std::array<NearRange, boxes.size()> ranges;
        for (size_t i = 0; i < blocks.size(); ++i) {
            for (size_t q = 0; q < boxes.size(); ++q) {
                const Vec3i from = blocks[i] + cut.lowest[q];
                boxes[q] = frame_.box(from, from + cut.size - Vec3i{1, 1, 1});
            }
            near_.bound(frame_.box(blocks[i], blocks[i] + Vec3i{7, 7, 7}), boxes, &mine->near,
                        ranges.data());
            for (size_t q = 0; q < boxes.size(); ++q) {
                bounds[i].low[q] = ranges[q].low;
                bounds[i].high[q] = ranges[q].high;
            }
        }
    }

    /// By octants: of a block that is decided by them, pieces would tell no more.
    void bound_whole_blocks(std::span<const Vec3i> blocks, Scratch* scratch, float* low,
                            float* high) const override {
        auto* mine = static_cast<ShapeEngineScratch*>(scratch);
        std::array<Box3f, 8> boxes;
        std::array<NearRange, boxes.size()> ranges;
        for (size_t i = 0; i < blocks.size(); ++i) {
            for (int32_t k = 0; k < 8; ++k) {
                const Vec3i from = blocks[i] + Vec3i{k & 1, k >> 1 & 1, k >> 2} * 4;
                boxes[static_cast<size_t>(k)] = frame_.box(from, from + Vec3i{3, 3, 3});
            }
            near_.bound(frame_.box(blocks[i], blocks[i] + Vec3i{7, 7, 7}), boxes, &mine->near,
                        ranges.data());
            low[i] = ranges[0].low;
            high[i] = ranges[0].high;
            for (const NearRange& range : ranges) {
                low[i] = std::min(low[i], range.low);
                high[i] = std::max(high[i], range.high);
            }
        }
    }

  private:
    /// The other engine's scratch, whose counts are those of this one after a call.
    class Forward {
      public:
        explicit Forward(Scratch* scratch) : mine_(static_cast<ShapeEngineScratch*>(scratch)) {}
        Forward(const Forward&) = delete;
        Forward& operator=(const Forward&) = delete;
        ~Forward() { mine_->counts = mine_->nearest->counts; }
        Scratch* scratch() const { return mine_->nearest.get(); }

      private:
        ShapeEngineScratch* mine_;
    };

    const ShapeNear& near_;
    const VoxelFrame frame_;
    const std::unique_ptr<nearest::Engine> nearest_;
};

}  // namespace

std::unique_ptr<nearest::Engine> make_shape_engine(const ShapeNear& near, const VoxelFrame& frame,
                                                   std::unique_ptr<nearest::Engine> nearest) {
    return std::make_unique<ShapeEngine>(near, frame, std::move(nearest));
}

}  // namespace openfab::solid

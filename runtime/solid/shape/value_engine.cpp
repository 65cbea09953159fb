// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/shape/value_engine.h"

#include <algorithm>
#include <cmath>

#include "base/infinity.h"

namespace openfab::solid {

namespace {

using nearest::kBlockVoxels;

struct Range {
    float low, high;  ///< of the distance, unsigned
};

/// Returns the range of the magnitude of values in [lo, hi]; NaN: not known.
Range magnitude(float lo, float hi) {
    if (std::isnan(lo) || std::isnan(hi)) return {0, kInfinity};
    const float low = lo > 0 ? lo : hi < 0 ? -hi : 0.0f;
    return {low, std::max(std::fabs(lo), std::fabs(hi))};
}

struct ValueScratch final : nearest::Engine::Scratch {
    std::unique_ptr<nearest::Engine::Scratch> nearest;
    ShapePoints points, lo, hi;
    std::vector<float> values, value_lo, value_hi;
};

class ValueEngine final : public nearest::Engine {
  public:
    ValueEngine(const ShapeField& field, const VoxelFrame& frame,
                std::unique_ptr<nearest::Engine> nearest)
        : field_(field), frame_(frame), nearest_(std::move(nearest)) {}

    std::unique_ptr<Scratch> make_scratch() const override {
        auto scratch = std::make_unique<ValueScratch>();
        if (nearest_ != nullptr) scratch->nearest = nearest_->make_scratch();
        return scratch;
    }

    void query(const nearest::BlockQuery& query, Scratch* scratch,
               nearest::BlockAnswer* answer) const override {
        auto* mine = static_cast<ValueScratch*>(scratch);
        if (nearest_ != nullptr) {
            nearest_->query(query, mine->nearest.get(), answer);
        } else {
            std::fill_n(answer->item, kBlockVoxels, -1);
            std::fill_n(answer->in_patch.triangle, kBlockVoxels, -1);
            std::fill_n(answer->in_patch.bary1, kBlockVoxels, 0.0f);
            std::fill_n(answer->in_patch.bary2, kBlockVoxels, 0.0f);
        }
        mine->points.resize(kBlockVoxels);
        for (size_t a = 0; a < 3; ++a) {
            float* to = mine->points.at[a].data();
            for (int32_t i = 0; i < kBlockVoxels; ++i) {
                to[i] = frame_.centre(a, static_cast<float>(query.block.x + i / 8 % 8) + 0.5f,
                                      static_cast<float>(query.block.y + i / 64) + 0.5f,
                                      static_cast<float>(query.block.z + i % 8) + 0.5f);
            }
        }
        evaluate(mine);
        for (size_t i = 0; i < kBlockVoxels; ++i) {
            const bool active =
                query.active == nullptr || (query.active[i / 8] >> (i % 8) & 1) != 0;
            answer->distance2[i] =
                active ? square(mine->values[i], mine->points.point(i), query.radius_mm)
                       : kInfinity;
            scratch->counts.queried += active ? 1 : 0;
            scratch->counts.skipped += active ? 0 : 1;
        }
    }

    void query_points(std::span<const nearest::PointPacket> packets, float radius_mm,
                      Scratch* scratch, nearest::PointAnswer* answers) const override {
        auto* mine = static_cast<ValueScratch*>(scratch);
        if (nearest_ != nullptr) {
            nearest_->query_points(packets, radius_mm, mine->nearest.get(), answers);
        } else {
            for (size_t g = 0; g < packets.size(); ++g) {
                answers[g] = {};
                std::fill_n(answers[g].item, 8, -1);
            }
        }
        mine->points.resize(8 * packets.size());
        for (size_t i = 0; i < mine->points.size(); ++i) {
            for (size_t a = 0; a < 3; ++a)
                mine->points.at[a][i] = packets[i / 8].p[a][i % 8];
        }
        evaluate(mine);
        for (size_t i = 0; i < mine->points.size(); ++i) {
            const bool asked = packets[i / 8].asks(i % 8);
            answers[i / 8].distance2[i % 8] =
                asked ? square(mine->values[i], mine->points.point(i), radius_mm) : kInfinity;
            scratch->counts.queried += asked ? 1 : 0;
        }
    }

    void bound_blocks(std::span<const Vec3i> blocks, Scratch* scratch,
                      nearest::BlockBounds* bounds) const override {
        auto* mine = static_cast<ValueScratch*>(scratch);
        const nearest::BlockPieces& cut = pieces();
        const size_t count = cut.lowest.size();
        mine->lo.clear();
        mine->hi.clear();
        for (const Vec3i& block : blocks) {
            for (const Vec3i& lowest : cut.lowest) {
                const Vec3i from = block + lowest;
                add_box(frame_.box(from, from + cut.size - Vec3i{1, 1, 1}), mine);
            }
        }
        bound(mine);
        for (size_t i = 0; i < blocks.size() * count; ++i) {
            const Range range = magnitude(mine->value_lo[i], mine->value_hi[i]);
            bounds[i / count].low[i % count] = range.low;
            bounds[i / count].high[i % count] = range.high;
        }
    }

    void bounds(const Vec3i& lowest, int32_t size, Scratch* scratch,
                nearest::BoxBounds* out) const override {
        auto* mine = static_cast<ValueScratch*>(scratch);
        mine->lo.clear();
        mine->hi.clear();
        add_box(frame_.box(lowest, lowest + Vec3i{size - 1, size - 1, size - 1}), mine);
        bound(mine);
        const Range range = magnitude(mine->value_lo[0], mine->value_hi[0]);
        if (nearest_ != nullptr) {
            nearest_->bounds(lowest, size, mine->nearest.get(), out);
            for (int32_t k = 0; k < out->count; ++k)
                out->cases[static_cast<size_t>(k)].distance_lo = range.low;
        } else {
            out->clear();
            out->add(range.low, {}, {}, {}, {});
        }
        out->distance_hi = range.high;
    }

  private:
    void evaluate(ValueScratch* mine) const {
        ShapeCalls* calls = field_.take();
        if (const abi::KernelStatus status = calls->values(mine->points, &mine->values);
            !status.ok())
            field_.note(status);
        field_.give(calls);
    }
    /// The root of a square is exact.
    float square(float value, const Vec3f& at, float radius_mm) const {
        if (std::isnan(value)) {
            field_.note_nan(at);
            return kInfinity;
        }
        return std::fabs(value) <= radius_mm ? value * value : kInfinity;
    }
    static void add_box(const Box3f& box, ValueScratch* mine) {
        mine->lo.push_back(box.lo);
        mine->hi.push_back(box.hi);
    }
    void bound(ValueScratch* mine) const {
        ShapeCalls* calls = field_.take();
        if (const abi::KernelStatus status =
                calls->bounds(mine->lo, mine->hi, &mine->value_lo, &mine->value_hi);
            !status.ok())
            field_.note(status);
        field_.give(calls);
    }

    const ShapeField& field_;
    const VoxelFrame frame_;
    std::unique_ptr<nearest::Engine> nearest_;
};

}  // namespace

std::unique_ptr<nearest::Engine> make_value_engine(const ShapeField& field, const VoxelFrame& frame,
                                                   std::unique_ptr<nearest::Engine> nearest) {
    return std::make_unique<ValueEngine>(field, frame, std::move(nearest));
}

}  // namespace openfab::solid

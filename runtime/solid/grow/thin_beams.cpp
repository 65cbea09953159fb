// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/grow/thin_beams.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace openfab::solid {

namespace {

/// Columns of voxels of a beam that is compared with each of them; more are halved by tiles.
constexpr int32_t kMostColumns = 36;

/// std::ceil, which is a call for every processor.
int32_t up(double x) {
    const auto i = static_cast<int32_t>(x);
    return i + (i < x ? 1 : 0);
}

}  // namespace

ThinBeams::ThinBeams(const Grown& grown, const VoxelFrame& frame, const Columns& columns,
                     int32_t slab, uint8_t bits, const Vec3i& base, voxel::SlabMask* out)
    : grown_(grown),
      frame_(frame),
      base_(base),
      bits_(bits),
      straight_(frame.is_straight()),
      low_(kSlabSlices * slab - base.z),
      out_(out) {
    tile_.lo = {columns.x0 - base.x, columns.y0 - base.y, low_ + std::countr_zero(bits)};
    tile_.hi = {columns.x1 - base.x, columns.y1 - base.y, low_ + std::bit_width(bits)};
    if (!straight_) return;
    const float margin = grown.slack(frame.box(tile_.lo, tile_.hi).hi, 0);
    for (int a = 0; a < 3; ++a) {
        const auto axis = static_cast<size_t>(a);
        first_[a] = frame.first(axis) + grown.center()[a];
        per_voxel_[a] = 1 / frame.step(axis);
        constexpr double kRounding = 1e-3;  // of a voxel
        slack_[a] = static_cast<double>(margin) * per_voxel_[a] + kRounding;
    }
    for (int32_t z = 0; z < kSlabSlices; ++z)
        z_[static_cast<size_t>(z)] =
            frame.centre(2, 0.5f, 0.5f, static_cast<float>(low_ + z) + 0.5f);
}

Box3i ThinBeams::voxels_in(const Box3f& box) const {
    Box3i out;
    for (int a = 0; a < 3; ++a) {
        const double lo = (static_cast<double>(box.lo[a]) - first_[a]) * per_voxel_[a] - slack_[a];
        const double hi = (static_cast<double>(box.hi[a]) - first_[a]) * per_voxel_[a] + slack_[a];
        const double least = tile_.lo[a], most = tile_.hi[a] - 1;
        out.lo[a] = up(std::clamp(lo, least, most + 1));
        out.hi[a] = 1 - up(-std::clamp(hi, least - 1, most));
    }
    return out;
}

bool ThinBeams::reaches(const Box3f& box) const {
    // A body is asked in a wider box than its own.
    if (!straight_ || grown_.has_bodies()) return true;
    const Box3i voxels = voxels_in(box);
    return voxels.lo.x < voxels.hi.x && voxels.lo.y < voxels.hi.y && voxels.lo.z < voxels.hi.z;
}

bool ThinBeams::take(const GrownBeam& beam, const Box3f& box) {
    if (!straight_ || beam.flat) return false;
    const Box3i voxels = voxels_in(box);
    const Vec3i size = voxels.hi - voxels.lo;
    if (size.x <= 0 || size.y <= 0 || size.z <= 0) return true;
    if (int64_t{size.x} * size.y > kMostColumns) return false;
    const auto up_to = [&](int32_t z) { return (1u << static_cast<uint32_t>(z - low_)) - 1; };
    const uint32_t asked = bits_ & (up_to(voxels.hi.z) & ~up_to(voxels.lo.z));
    const BeamRecord record = record_of(beam, grown_.center());
    for (int32_t y = voxels.lo.y; y < voxels.hi.y; ++y) {
        uint8_t* const row = out_->mask.data() + static_cast<size_t>(y + base_.y - out_->y0) *
                                                     static_cast<size_t>(out_->width);
        const float py = frame_.centre(1, 0.5f, static_cast<float>(y) + 0.5f, 0.5f);
        for (int32_t x = voxels.lo.x; x < voxels.hi.x; ++x) {
            uint8_t& column = row[x + base_.x - out_->x0];
            if ((asked & ~uint32_t{column}) == 0) continue;
            const float px = frame_.centre(0, static_cast<float>(x) + 0.5f, 0.5f, 0.5f);
            std::array<float, 8> distance;
            for (size_t z = 0; z < distance.size(); ++z)
                distance[z] = round_distance(record, px, py, z_[z]);
            uint32_t in = 0;
            for (size_t z = 0; z < distance.size(); ++z)
                in |= (distance[z] < 0 ? 1u : 0u) << z;
            column = static_cast<uint8_t>(column | (in & asked));
        }
    }
    return true;
}

}  // namespace openfab::solid

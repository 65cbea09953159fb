// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/boundary/mesh_sink.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "backends/boundary/messages.h"
#include "backends/common/tee_sink.h"
#include "base/check.h"

namespace openfab::boundary {

Coordinates::Coordinates(const pipeline::PrintInfo& info)
    : origin_mm_(info.origin_mm), half_mm_(info.pitch_mm * 0.5) {}

Vec3f Coordinates::at(const Vec3i& point) const {
    return {static_cast<float>(origin_mm_.x + point.x * half_mm_.x),
            static_cast<float>(origin_mm_.y + point.y * half_mm_.y),
            static_cast<float>(origin_mm_.z + point.z * half_mm_.z)};
}

Vec3f Coordinates::at(const MeshCorner& corner) const {
    const Vec3f exact = at(corner.point);
    Vec3f out = exact;
    for (int a = 0; a < 3; ++a) {
        const int32_t steps = corner.off[a];
        if (steps == 0) continue;
        out[a] = static_cast<float>(origin_mm_[a] + corner.point[a] * half_mm_[a] +
                                    steps * (half_mm_[a] * (2.0 / kSteps)));
        if (out[a] == exact[a]) out[a] = std::nextafter(exact[a], steps > 0 ? 1e30F : -1e30F);
    }
    return out;
}

Result<void> Coordinates::check(const pipeline::PrintInfo& info) {
    for (int a = 0; a < 3; ++a) {
        const double lo = info.origin_mm[a], hi = lo + info.size[a] * info.pitch_mm[a];
        // Two half voxels a step of the coordinates, so that rounding joins none.
        const double least = std::max(std::abs(lo), std::abs(hi)) * 0x1p-21;
        if (info.pitch_mm[a] > least) continue;
        return user_error(fmt::format(messages::kVoxelsTooFine, info.pitch_mm[a] * 1e3,
                                      std::max(std::abs(lo), std::abs(hi)), least * 1.01e3));
    }
    return {};
}

Result<void> MeshSink::begin(const pipeline::PrintInfo& info) {
    info_ = info;
    Result<void> done = Coordinates::check(info);
    if (done) done = writer_->begin(info);
    broken_ = !done;
    mesher_ = std::make_unique<Mesher>(info.size.x, info.size.y, info.slice_begin, writer_.get());
    return done;
}

std::vector<uint8_t> MeshSink::encode(const pipeline::SliceView& slice) const {
    return {slice.data, slice.data + slice.row_bytes * static_cast<size_t>(slice.height)};
}

Result<void> MeshSink::commit(int32_t z, std::vector<uint8_t> bytes) {
    return commit_colored(z, std::move(bytes), {});
}

Result<void> MeshSink::commit_colored(int32_t z, std::vector<uint8_t> bytes,
                                      std::span<const uint32_t> colors) {
    OPENFAB_CHECK(mesher_ != nullptr);  // begun, and not finished
    const pipeline::SliceView slice{z, bytes.data(),
                                    backends::packed_row_bytes(info_.size.x, info_.bits),
                                    info_.size.x, info_.size.y};
    Result<void> done = mesher_->add(slice, info_.bits, colors.data());
    broken_ = broken_ || !done;
    return done;
}

Result<void> MeshSink::finish(const pipeline::PrintTotals& totals) {
    Result<void> done;
    if (broken_) {
        // Reported already.
    } else if (!totals.complete) {
        done = Error{ErrorCode::kInterrupted, messages::kEndedEarly};
    } else {
        done = mesher_->finish();
        if (done) done = writer_->end(totals);
    }
    mesher_.reset();
    writer_.reset();
    return done;
}

}  // namespace openfab::boundary

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/volume/volume_segments.h"

#include <array>

#include "abi/argument_group.h"
#include "base/check.h"

namespace openfab::volume {

namespace {

constexpr int32_t kBlockValues = 512;
constexpr int32_t kBlockGroups = segments::kBlockGroups;

/// Returns attr.voxelCenter of a voxel, in the order of operations of abi/fablet_table.h.
std::array<float, 3> centre(const PlacedPart& part, const int32_t* corner, int32_t voxel) {
    const auto half = [](int32_t index) { return static_cast<float>(index) + 0.5f; };
    const float x = half(corner[0] + voxel / 8 % 8);
    const float y = half(corner[1] + voxel / 64 % 8);
    const float z = half(corner[2] + voxel % 8);
    std::array<float, 3> at{};
    for (size_t a = 0; a < 3; ++a) {
        const auto f = [&](size_t base) { return part.frame[base + a]; };
        at[a] = ((x * f(OPENFAB_FRAME_STEP_I) + y * f(OPENFAB_FRAME_STEP_J)) +
                 z * f(OPENFAB_FRAME_STEP_K)) +
                f(OPENFAB_FRAME_ORIGIN) + f(OPENFAB_FRAME_CENTER);
    }
    return at;
}

}  // namespace

int32_t VolumeSegments::most_blocks(const PlacedPart& part) {
    return segments::group_limit(part.part->fablet->volume_segments) / kBlockGroups;
}

abi::KernelStatus VolumeSegments::run(const PlacedPart& part, openfab_isa isa,
                                      const int32_t* corners, const uint8_t* owned, int32_t n,
                                      const Input& input, segments::PrintfLog* log,
                                      const std::atomic<bool>* stop) {
    OPENFAB_CHECK_LE(n, most_blocks(part));
    part_ = &part;
    inputs_ = &input;
    log_ = log;
    corners_ = corners;
    count_ = n;
    buffers_used_ = 0;
    queries_.begin(part, corners, owned, isa, stop);
    const abi::KernelStatus status =
        driver_.run(part.part->fablet->volume_segments, isa,
                    {owned, static_cast<size_t>(kBlockGroups * n)}, this, this, stop);
    log_->end_batch();
    return status;
}

abi::KernelBuffer* VolumeSegments::next_buffer() {
    if (buffers_used_ == buffers_.size()) buffers_.push_back(std::make_unique<abi::KernelBuffer>());
    return buffers_[buffers_used_++].get();
}

const void* VolumeSegments::input(const openfab_arg& arg) {
    if (arg.kind == OPENFAB_ARG_BLOCKS) {
        abi::KernelBuffer* buffer = next_buffer();
        buffer->set_dense(abi::halide_type(OPENFAB_INT), corners_, {3, count_});
        return buffer->raw();
    }
    if (abi::group_of(arg.kind) == abi::ArgumentGroup::kPart) {
        const bool filled = arg.kind == OPENFAB_ARG_TEXTURE || arg.kind == OPENFAB_ARG_VALUES;
        abi::KernelBuffer* buffer = filled ? next_buffer() : nullptr;
        return part_argument(*part_, arg, buffer);
    }
    abi::KernelBuffer* buffer = next_buffer();
    buffer->set_dense(abi::halide_type(arg.scalar), (*inputs_)(arg), {kBlockValues * count_});
    return buffer->raw();
}

segments::OutputView VolumeSegments::output(const openfab_arg& arg) {
    // They write states alone.
    OPENFAB_CHECK_EQ(arg.kind, OPENFAB_ARG_STATE_OUT);
    return {};
}

abi::KernelStatus VolumeSegments::query(const openfab_query& query, std::span<const int32_t> groups,
                                        const segments::States& states) {
    return queries_.answer(query, groups, states);
}

void VolumeSegments::printf(const openfab_printf& call, std::span<const int32_t> groups,
                            const segments::States& states) {
    log_->add(part_->part->fablet->volume_segments, call, groups, states, [&](int32_t voxel) {
        return centre(*part_, corners_ + 3 * (voxel / kBlockValues), voxel);
    });
}

}  // namespace openfab::volume

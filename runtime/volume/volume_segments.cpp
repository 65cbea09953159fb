// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/volume/volume_segments.h"

#include <algorithm>

namespace openfab::volume {

namespace {

constexpr int32_t kBlockValues = 512;
constexpr int32_t kBlockGroups = segments::kBlockGroups;

}  // namespace

abi::KernelStatus VolumeSegments::run(const PlacedPart& part, openfab_isa isa,
                                      const int32_t* corners, const uint8_t* owned, int32_t n,
                                      const Input& input, float* weights, size_t slot_stride,
                                      PrintfLog* log) {
    const openfab_segments& segments = part.part->fablet->volume_segments;
    part_ = &part;
    inputs_ = &input;
    log_ = log;
    weights_ = weights;
    slot_stride_ = slot_stride;
    const int32_t most = segments::group_limit(segments) / kBlockGroups;
    for (first_ = 0; first_ < n; first_ += count_) {
        count_ = std::min(most, n - first_);
        corners_ = corners + static_cast<ptrdiff_t>(3 * first_);
        const uint8_t* wanted = owned + static_cast<ptrdiff_t>(kBlockGroups * first_);
        buffers_used_ = 0;
        queries_.begin(part, corners_, wanted);
        const abi::KernelStatus status = driver_.run(
            segments, isa, {wanted, static_cast<size_t>(kBlockGroups * count_)}, this, this);
        log_->end_batch();
        if (!status.ok()) return status;
    }
    return {};
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
    if (arg.kind <= OPENFAB_ARG_INSTANCE) {
        abi::KernelBuffer* buffer = arg.kind == OPENFAB_ARG_TEXTURE ? next_buffer() : nullptr;
        return part_argument(*part_, arg, buffer);
    }
    const auto* values = static_cast<const uint32_t*>((*inputs_)(arg));
    abi::KernelBuffer* buffer = next_buffer();
    buffer->set_dense(abi::halide_type(arg.scalar),
                      values + static_cast<ptrdiff_t>(kBlockValues) * first_,
                      {kBlockValues * count_});
    return buffer->raw();
}

segments::OutputView VolumeSegments::output(const openfab_arg& arg) {
    float* values =
        weights_ + slot_stride_ * static_cast<size_t>(arg.a) + ptrdiff_t{kBlockValues} * first_;
    return {reinterpret_cast<uint32_t*>(values)};
}

abi::KernelStatus VolumeSegments::query(const openfab_query& query, std::span<const int32_t> groups,
                                        const segments::States& states) {
    return queries_.answer(query, groups, states);
}

void VolumeSegments::printf(const openfab_printf& call, std::span<const int32_t> groups,
                            const segments::States& states) {
    log_->add(*part_, part_->part->fablet->volume_segments, corners_, call, groups, states);
}

}  // namespace openfab::volume

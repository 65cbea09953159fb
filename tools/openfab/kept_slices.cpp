// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/kept_slices.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <utility>

#include "backends/ofr/slice_codec.h"
#include "backends/stream/message.h"
#include "runtime/pipeline/print_hash.h"

namespace openfab::tools {

KeptSlices::KeptSlices(pipeline::SliceSink* sink, bool sends)
    : sink_(*sink), event_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    thread_ = std::thread([this, sends] { read(sends); });
}

KeptSlices::~KeptSlices() {
    {
        const std::lock_guard lock(mutex_);
        cancelled_ = true;
        taken_.notify_all();
    }
    thread_.join();
    if (event_ >= 0) ::close(event_);
}

void KeptSlices::wake() const {
    // Without a descriptor, the poll looks once a second.
    if (event_ >= 0) (void)::eventfd_write(event_, 1);
}

void KeptSlices::read(bool sends) {
    uint64_t hash = 0;
    Result<int32_t> kept = sink_.resume([&](const pipeline::SliceView& slice) {
        hash += pipeline::slice_hash(slice.z, slice.data, slice.row_bytes, slice.height);
        std::vector<uint8_t> frame;
        if (sends) frame = stream::frame(stream::Kind::kBack, ofr::encode_slice(slice));
        std::unique_lock lock(mutex_);
        taken_.wait(lock, [&] { return frame_.empty() || cancelled_; });
        if (cancelled_) return false;
        frame_ = std::move(frame);
        if (sends) wake();
        return true;
    });
    const std::lock_guard lock(mutex_);
    end_ = End{std::move(kept), hash};
    wake();
}

std::optional<std::vector<uint8_t>> KeptSlices::take() {
    const std::lock_guard lock(mutex_);
    eventfd_t ignored = 0;
    if (event_ >= 0) (void)::eventfd_read(event_, &ignored);
    if (frame_.empty()) return {};
    taken_.notify_all();
    return std::exchange(frame_, {});
}

std::optional<KeptSlices::End> KeptSlices::end() {
    const std::lock_guard lock(mutex_);
    if (!end_ || !frame_.empty()) return {};
    return std::move(end_);
}

}  // namespace openfab::tools

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/slice_store.h"

#include <algorithm>
#include <utility>

namespace openfab::viewer {

namespace {

constexpr int64_t kKeptBytes = 64 << 20;
/// Slices above this are unpacked one at a time.
constexpr int64_t kLargeSlice = 40 << 20;

size_t kept_bytes(const prints::PrintFile& file) {
    constexpr int64_t kOverhead = 4096;
    return static_cast<size_t>(std::max(kKeptBytes, file.slice_bytes() + kOverhead));
}

}  // namespace

/// Buffers for one slice, given back at the end.
class SliceStore::Turn {
  public:
    explicit Turn(SliceStore* store) : store_(store) {
        std::unique_lock lock(store_->mutex_);
        store_->changed_.wait(lock, [&] { return !store_->free_.empty(); });
        buffers_ = std::move(store_->free_.back());
        store_->free_.pop_back();
    }
    ~Turn() {
        const std::lock_guard lock(store_->mutex_);
        store_->free_.push_back(std::move(buffers_));
        store_->changed_.notify_all();
    }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

    prints::SliceBuffers* buffers() { return buffers_.get(); }

  private:
    SliceStore* store_;
    std::unique_ptr<prints::SliceBuffers> buffers_;
};

SliceStore::SliceStore(prints::PrintFile* file)
    : file_(file), kept_(kept_bytes(*file), kept_bytes(*file)) {
    const int turns = file->slice_bytes() > kLargeSlice ? 1 : 2;
    for (int i = 0; i < turns; ++i)
        free_.push_back(std::make_unique<prints::SliceBuffers>());
}

Result<std::shared_ptr<const Slice>> SliceStore::slice(int32_t z) {
    {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return !being_read_.contains(z); });
        if (std::shared_ptr<const Slice> found = kept_.find(z)) return found;
        being_read_.insert(z);
    }
    auto slice = std::make_shared<Slice>();
    slice->z = z;
    Result<void> read;
    {
        Turn turn(this);
        read = file_->read_slice(z, turn.buffers());
        // The buffer goes with the slice: a copy would touch as much memory again.
        if (read) std::swap(slice->rows, turn.buffers()->rows);
    }
    std::shared_ptr<const Slice> kept = slice;
    if (read) kept = kept_.insert(z, slice);
    {
        const std::lock_guard lock(mutex_);
        being_read_.erase(z);
        changed_.notify_all();
    }
    if (!read) return read.error();
    return kept;
}

Result<void> SliceStore::visit(int32_t z, const std::function<void(const uint8_t* rows)>& look) {
    if (const std::shared_ptr<const Slice> found = kept_.find(z)) {
        look(found->rows.data());
        return {};
    }
    Turn turn(this);
    if (Result<void> read = file_->read_slice(z, turn.buffers()); !read) return read;
    look(turn.buffers()->rows.data());
    return {};
}

}  // namespace openfab::viewer

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/cuts.h"

#include <algorithm>
#include <cstring>

#include "backends/common/tee_sink.h"

namespace openfab::viewer {

namespace {

constexpr int64_t kKeptBytes = 48 << 20;
constexpr size_t kMostCuts = 4;

}  // namespace

Cut::Cut(SliceStore* store, int axis, int32_t at) : store_(store), axis_(axis), at_(at) {
    const pipeline::PrintInfo& info = store->file().info();
    width_ = axis == 0 ? info.size.y : info.size.x;
    row_bytes_ = backends::packed_row_bytes(width_, info.bits);
    rows_.resize(static_cast<size_t>(info.size.z));
}

void Cut::take(const uint8_t* rows, uint8_t* to) const {
    const prints::PrintFile& file = store_->file();
    const pipeline::PrintInfo& info = file.info();
    if (axis_ == 1) {
        std::memcpy(to, rows + file.row_bytes() * static_cast<size_t>(at_), row_bytes_);
        return;
    }
    const pipeline::SliceView view{0, rows, file.row_bytes(), info.size.x, info.size.y};
    std::fill_n(to, row_bytes_, uint8_t{0});
    for (int32_t y = 0; y < info.size.y; ++y) {
        const uint8_t code = view.code(at_, y, info.bits);
        if (info.bits == 8) {
            to[y] = code;
        } else {
            to[y / 2] = static_cast<uint8_t>(to[y / 2] | code << (y % 2 * 4));
        }
    }
}

Result<void> Cut::read(int32_t z) {
    std::unique_ptr<uint8_t[]> data(new uint8_t[row_bytes_]);
    Result<void> got = store_->visit(z, [&](const uint8_t* rows) { take(rows, data.get()); });
    const std::lock_guard lock(mutex_);
    Row& row = rows_[static_cast<size_t>(z)];
    row.state = got ? State::kThere : State::kNone;
    if (got) {
        row.data = std::move(data);
        ++there_;
    }
    changed_.notify_all();
    return got;
}

Result<void> Cut::fetch(int32_t first, int32_t end, int32_t stride) {
    const prints::PrintFile& file = store_->file();
    const int32_t low = file.info().slice_begin;
    const int32_t high = low + file.whole_slices();
    std::vector<int32_t> of_others;
    for (int64_t next = first; next < end; next += stride) {
        const auto z = static_cast<int32_t>(next);
        if (z < low || z >= high) continue;
        {
            const std::lock_guard lock(mutex_);
            Row& row = rows_[static_cast<size_t>(z)];
            if (row.state == State::kThere) continue;
            if (row.state == State::kBeingRead) {
                of_others.push_back(z);
                continue;
            }
            row.state = State::kBeingRead;
        }
        if (Result<void> got = read(z); !got) return got;
    }
    std::unique_lock lock(mutex_);
    for (const int32_t z : of_others)
        changed_.wait(lock,
                      [&] { return rows_[static_cast<size_t>(z)].state != State::kBeingRead; });
    return {};
}

const uint8_t* Cut::row(int32_t z) const {
    const std::lock_guard lock(mutex_);
    return rows_[static_cast<size_t>(z)].data.get();
}

int64_t Cut::bytes() const {
    const std::lock_guard lock(mutex_);
    return there_ * static_cast<int64_t>(row_bytes_) +
           static_cast<int64_t>(rows_.size() * sizeof(Row));
}

std::shared_ptr<Cut> Cuts::cut(int axis, int32_t at) {
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(kept_.begin(), kept_.end(), [&](const auto& cut) {
        return cut->axis() == axis && cut->at() == at;
    });
    if (found != kept_.end()) {
        std::rotate(found, found + 1, kept_.end());
    } else {
        kept_.push_back(std::make_shared<Cut>(store_, axis, at));
    }
    std::shared_ptr<Cut> last = kept_.back();
    int64_t bytes = 0;
    for (const auto& cut : kept_)
        bytes += cut->bytes();
    // One cut of many fine rows alone may be too much: it begins again.
    while (kept_.size() > kMostCuts || (bytes > kKeptBytes && !kept_.empty())) {
        bytes -= kept_.front()->bytes();
        kept_.erase(kept_.begin());
    }
    return last;
}

}  // namespace openfab::viewer

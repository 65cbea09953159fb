// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/layer_clock.h"

#include <algorithm>
#include <limits>

namespace openfab::tools {

void LayerClock::begin(int32_t slices, int32_t kept) {
    slices_ = slices;
    arrived_ = printed_ = kept;
    running_ = waiting_ = false;
}

void LayerClock::start_if_full(double now) {
    if (running_ || (arrived_ - printed_ < buffer_ && arrived_ < slices_)) return;
    running_ = true;
    due_ = now;
}

void LayerClock::add(double now) {
    ++arrived_;
    if (waiting_) {
        starved_seconds_ += now - due_;
        due_ = now;
        waiting_ = false;
    }
    advance(now);
}

void LayerClock::advance(double now) {
    if (layer_seconds_ <= 0) {
        printed_ = arrived_;
        return;
    }
    start_if_full(now);
    while (running_ && !waiting_ && printed_ < slices_ && due_ <= now) {
        if (printed_ < arrived_) {
            ++printed_;
            due_ += layer_seconds_;
        } else {
            waiting_ = true;
            ++starved_;
        }
    }
}

int32_t LayerClock::room() const {
    return layer_seconds_ <= 0 ? slices_ : std::min(printed_ + buffer_, slices_);
}

double LayerClock::due() const {
    return running_ && !waiting_ && printed_ < slices_ ? due_
                                                       : std::numeric_limits<double>::infinity();
}

}  // namespace openfab::tools

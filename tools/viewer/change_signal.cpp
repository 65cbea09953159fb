// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/change_signal.h"

namespace openfab::viewer {

namespace {

/// Each that waits holds a thread of the server, and a connection of its browser.
constexpr int32_t kMostWaiting = 4;

}  // namespace

ChangeSignal::Counts ChangeSignal::counts() const {
    const std::lock_guard lock(mutex_);
    return counts_;
}

/// The caller holds the lock.
void ChangeSignal::count_change() {
    ++counts_.change;
    pages_.notify_all();
}

void ChangeSignal::tell() {
    const std::lock_guard lock(mutex_);
    count_change();
}

void ChangeSignal::tell_of_details() {
    const std::lock_guard lock(mutex_);
    ++counts_.details;
    count_change();
}

int64_t ChangeSignal::ask() {
    const std::lock_guard lock(mutex_);
    counts_.asked = true;
    ++counts_.details;
    count_change();
    loop_.notify_all();
    return counts_.change;
}

void ChangeSignal::wait_until_asked(std::chrono::milliseconds longest) {
    std::unique_lock lock(mutex_);
    loop_.wait_for(lock, longest, [&] { return counts_.asked || stopped_; });
}

void ChangeSignal::begin_what_was_asked() {
    const std::lock_guard lock(mutex_);
    counts_.asked = false;
}

void ChangeSignal::wait_for_change(int64_t known, std::chrono::milliseconds longest) const {
    std::unique_lock lock(mutex_);
    if (counts_.change != known || waiting_ >= kMostWaiting) return;
    ++waiting_;
    pages_.wait_for(lock, longest, [&] { return counts_.change != known || stopped_; });
    --waiting_;
}

void ChangeSignal::stop() {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    loop_.notify_all();
    pages_.notify_all();
}

bool ChangeSignal::stopped() const {
    const std::lock_guard lock(mutex_);
    return stopped_;
}

}  // namespace openfab::viewer

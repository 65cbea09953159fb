// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/deadline.h"

#include <chrono>

#include "base/clock.h"

namespace openfab {

namespace {

constexpr std::chrono::milliseconds kStep{10};

}  // namespace

Deadline::Deadline(const std::atomic<bool>& interrupt)
    : interrupt_(interrupt), thread_([this] { watch(); }) {}

Deadline::~Deadline() {
    {
        const std::lock_guard lock(mutex_);
        over_ = true;
    }
    change_.notify_one();
    thread_.join();
}

void Deadline::start(double seconds) {
    const std::lock_guard lock(mutex_);
    allowed_ = seconds;
    started_ = seconds_now();
    started_processor_ = processor_seconds();
}

void Deadline::watch() {
    std::unique_lock lock(mutex_);
    while (!change_.wait_for(lock, kStep, [&] { return over_; })) {
        const double passed = seconds_now() - started_;
        const bool late =
            allowed_ >= 0 && passed >= allowed_ &&
            (processor_seconds() - started_processor_ >= allowed_ || passed >= 10 * allowed_);
        if (late || interrupt_.load()) passed_.store(true);
    }
}

}  // namespace openfab

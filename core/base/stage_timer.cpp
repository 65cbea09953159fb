// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/stage_timer.h"

#include <algorithm>
#include <atomic>

#include "base/check.h"
#include "base/clock.h"

namespace openfab {

namespace {

// A thread's record belongs to the trace of one number; a later trace may have the same address.
std::atomic<Trace*> active{nullptr};
std::atomic<uint64_t> number{0};

}  // namespace

Trace::Trace() {
    ++number;
    Trace* none = nullptr;
    OPENFAB_CHECK(active.compare_exchange_strong(none, this));
}

Trace::~Trace() {
    active.store(nullptr);
}

Trace::Thread* Trace::mine() {
    Trace* trace = active.load(std::memory_order_acquire);
    if (trace == nullptr) return nullptr;
    thread_local uint64_t known = 0;
    thread_local Thread* record = nullptr;
    if (const uint64_t current = number.load(std::memory_order_relaxed); known != current) {
        const std::lock_guard lock(trace->mutex_);
        record = &trace->threads_.emplace_back();
        known = current;
    }
    return record;
}

StageTimer::StageTimer(Stage stage, double* sum)
    : stage_(stage), sum_(sum), thread_(Trace::mine()), start_(seconds_now()) {
    if (thread_ == nullptr) return;
    outer_ = thread_->current;
    thread_->current = this;
    processor_start_ = thread_processor_seconds();
}

StageTimer::~StageTimer() {
    const double end = seconds_now();
    if (sum_ != nullptr) *sum_ += end - start_;
    if (thread_ == nullptr) return;
    const double seconds = thread_processor_seconds() - processor_start_;
    thread_->seconds[static_cast<size_t>(stage_)] += seconds - inner_;
    thread_->current = outer_;
    if (outer_ != nullptr) {
        outer_->inner_ += seconds;
    } else {
        thread_->busy.emplace_back(start_, end);
    }
}

std::vector<double> seconds_by_busy_threads(const std::deque<Trace::Thread>& threads, double begin,
                                            double end) {
    std::vector<std::pair<double, int>> changes;
    for (const Trace::Thread& thread : threads) {
        for (const auto& [from, to] : thread.busy) {
            if (to <= begin || from >= end) continue;
            changes.emplace_back(std::max(from, begin), 1);
            changes.emplace_back(std::min(to, end), -1);
        }
    }
    // Where one thread ends and another begins at once, the end comes first.
    std::sort(changes.begin(), changes.end());
    std::vector<double> seconds(threads.size() + 1, 0.0);
    size_t busy = 0;
    double since = begin;
    for (const auto& [time, change] : changes) {
        seconds[busy] += time - since;
        busy = change > 0 ? busy + 1 : busy - 1;
        since = time;
    }
    seconds[busy] += std::max(0.0, end - since);
    return seconds;
}

}  // namespace openfab

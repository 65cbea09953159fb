// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// See plain.h. Pipelines of any number of stages, each in order or in parallel; the source is in order.
// As in TBB, no thread waits for an item's turn: items are set aside, and threads go on with others.

#include <array>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <tuple>
#include <utility>

#include "tests/support/plain_threads/tbb/plain.h"

namespace tbb {

enum class filter_mode { parallel, serial_in_order };

/// What a source is given, to say that it has no more.
class flow_control {
  public:
    void stop() { stopped = true; }
    bool stopped = false;
};

template <typename In, typename Out, typename Body>
struct filter {
    using Given = Out;
    filter_mode mode;
    Body body;
};

template <typename In, typename Out, typename Body>
filter<In, Out, Body> make_filter(filter_mode mode, const Body& body) {
    return {mode, body};
}

template <typename... Stages>
struct filters {
    std::tuple<Stages...> stages;
};

template <typename In, typename Mid, typename Out, typename A, typename B>
filters<filter<In, Mid, A>, filter<Mid, Out, B>> operator&(const filter<In, Mid, A>& a,
                                                           const filter<Mid, Out, B>& b) {
    return {{a, b}};
}

template <typename... Stages, typename In, typename Out, typename Body>
filters<Stages..., filter<In, Out, Body>> operator&(const filters<Stages...>& chain,
                                                    const filter<In, Out, Body>& last) {
    return {std::tuple_cat(chain.stages, std::tuple(last))};
}

namespace plain {

template <typename Source, typename... Rest>
class Pipeline {
  public:
    Pipeline(size_t tokens, const std::tuple<Source, Rest...>& stages)
        : tokens_(tokens), stages_(stages) {}

    /// The work of one of several threads.
    void work() {
        std::unique_lock<std::mutex> lock(mutex_);
        while (true) {
            changed_.wait(lock, [&] { return !ready_.empty() || may_take() || is_over(); });
            if (!ready_.empty()) {
                const Task task = std::move(ready_.front());
                ready_.pop_front();
                lock.unlock();
                task();
                lock.lock();
            } else if (may_take()) {
                take(&lock);
            } else {
                return;
            }
        }
    }

  private:
    static constexpr size_t kStages = 1 + sizeof...(Rest);
    using Task = std::function<void()>;
    template <size_t At>
    using GivenBy = typename std::tuple_element_t<At, std::tuple<Source, Rest...>>::Given;

    bool may_take() const { return !control_.stopped && !is_taking_ && on_their_way_ < tokens_; }
    bool is_over() const { return control_.stopped && !is_taking_ && on_their_way_ == 0; }

    void take(std::unique_lock<std::mutex>* lock) {
        is_taking_ = true;
        lock->unlock();
        flow_control control;
        GivenBy<0> item = std::get<0>(stages_).body(control);
        lock->lock();
        is_taking_ = false;
        control_ = control;
        changed_.notify_all();
        if (control.stopped) return;
        const size_t number = taken_++;
        ++on_their_way_;
        lock->unlock();
        go_on<1>(number, std::move(item));
        lock->lock();
    }

    /// Takes an item through the stages from `At` on, or sets it aside.
    template <size_t At>
    void go_on(size_t number, GivenBy<At - 1> item) {
        if (std::get<At>(stages_).mode == filter_mode::parallel) return run<At>(number, &item);
        const auto kept = std::make_shared<GivenBy<At - 1>>(std::move(item));
        std::unique_lock<std::mutex> lock(mutex_);
        if (number != next_[At]) {
            aside_[At][number] = [this, number, kept] { run<At>(number, kept.get()); };
            return;
        }
        lock.unlock();
        run<At>(number, kept.get());
    }

    template <size_t At>
    void run(size_t number, GivenBy<At - 1>* item) {
        const auto& stage = std::get<At>(stages_);
        if constexpr (At + 1 < kStages) {
            GivenBy<At> result = stage.body(std::move(*item));
            passed(At);
            go_on<At + 1>(number, std::move(result));
        } else {
            stage.body(std::move(*item));
            passed(At);
            const std::lock_guard<std::mutex> lock(mutex_);
            --on_their_way_;
            changed_.notify_all();
        }
    }

    /// It is the next item's turn in a stage in order.
    void passed(size_t at) {
        const std::lock_guard<std::mutex> lock(mutex_);
        const auto waits = aside_[at].find(++next_[at]);
        if (waits == aside_[at].end()) return;
        ready_.push_back(std::move(waits->second));
        aside_[at].erase(waits);
        changed_.notify_all();
    }

    const size_t tokens_;
    const std::tuple<Source, Rest...>& stages_;
    std::mutex mutex_;  ///< of all below
    std::condition_variable changed_;
    flow_control control_;
    bool is_taking_ = false;
    size_t taken_ = 0, on_their_way_ = 0;                ///< items
    std::array<size_t, kStages> next_{};                 ///< item whose turn it is, by stage
    std::array<std::map<size_t, Task>, kStages> aside_;  ///< by stage and item
    std::deque<Task> ready_;
};

}  // namespace plain

/// Keeps at most `tokens` items on their way.
template <typename... Stages>
void parallel_pipeline(size_t tokens, const filters<Stages...>& chain) {
    plain::Pipeline<Stages...> pipeline(tokens, chain.stages);
    plain::in_threads(tokens, [&] { pipeline.work(); });
}

}  // namespace tbb

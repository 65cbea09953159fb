// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// See plain.h. Pipelines as we have them: a source in order, one stage in parallel, an end in order.

#include <condition_variable>
#include <mutex>
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
    Body body;
};

template <typename In, typename Out, typename Body>
filter<In, Out, Body> make_filter(filter_mode /*mode*/, const Body& body) {
    return {body};
}

template <typename First, typename Second>
struct filters {
    First first;
    Second second;
};

template <typename In, typename Mid, typename Out, typename A, typename B>
filters<filter<In, Mid, A>, filter<Mid, Out, B>> operator&(const filter<In, Mid, A>& a,
                                                           const filter<Mid, Out, B>& b) {
    return {a, b};
}

template <typename First, typename Mid, typename B, typename C, typename Out>
filters<filters<First, filter<Mid, Out, B>>, filter<Out, void, C>> operator&(
    const filters<First, filter<Mid, Out, B>>& a, const filter<Out, void, C>& b) {
    return {a, b};
}

/// Keeps at most `tokens` items on their way.
template <typename A, typename B, typename C, typename Mid, typename Out>
void parallel_pipeline(size_t tokens,
                       const filters<filters<filter<void, Mid, A>, filter<Mid, Out, B>>,
                                     filter<Out, void, C>>& chain) {
    std::mutex source, end;
    std::condition_variable turn;
    size_t taken = 0, done = 0;  // items, each guarded by its stage's mutex
    flow_control control;
    // Each thread has one item at a time, and takes it to the end: the first of those on their way waits for none.
    plain::in_threads(tokens, [&] {
        while (true) {
            std::unique_lock<std::mutex> taking(source);
            if (control.stopped) return;
            Mid item = chain.first.first.body(control);
            if (control.stopped) return;
            const size_t number = taken++;
            taking.unlock();
            Out result = chain.first.second.body(std::move(item));
            std::unique_lock<std::mutex> ending(end);
            turn.wait(ending, [&] { return done == number; });
            chain.second.body(std::move(result));
            ++done;
            ending.unlock();
            turn.notify_all();
        }
    });
}

}  // namespace tbb

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// See plain.h.

#include <vector>

#include "tests/support/plain_threads/tbb/blocked_range.h"

namespace tbb {

/// Results of parts are joined in order, as in TBB.
template <typename T, typename Value, typename Body, typename Join>
Value parallel_reduce(const blocked_range<T>& range, const Value& identity, const Body& body,
                      const Join& join) {
    if (range.empty()) return identity;
    constexpr size_t kParts = 16;
    const size_t step = (range.size() + kParts - 1) / kParts;
    std::vector<Value> values((range.size() + step - 1) / step, identity);
    plain::each(values.size(), [&](size_t i) {
        const size_t end = (i + 1) * step < range.size() ? (i + 1) * step : range.size();
        values[i] = body(blocked_range<T>(range.begin() + static_cast<T>(i * step),
                                          range.begin() + static_cast<T>(end)),
                         identity);
    });
    Value result = values[0];
    for (size_t i = 1; i < values.size(); ++i)
        result = join(result, values[i]);
    return result;
}

/// The first half is the body's own, the second one's is made by splitting it.
template <typename T, typename Body>
void parallel_reduce(const blocked_range<T>& range, Body& body) {
    if (range.size() < 2) {
        if (!range.empty()) body(range);
        return;
    }
    const T middle = range.begin() + static_cast<T>(range.size() / 2);
    Body later(body, split{});
    plain::each(2, [&](size_t i) {
        if (i == 0) {
            body(blocked_range<T>(range.begin(), middle));
        } else {
            later(blocked_range<T>(middle, range.end()));
        }
    });
    body.join(later);
}

}  // namespace tbb

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The search for unknowns, between bounds, for which values are what is wanted: by NLopt, which is in Debian and
// Ubuntu, is kept, takes constraints and has methods with and without derivatives; SciPy would be Python in a program
// that starts none. Slopes are derivatives where there are some, or else central differences. First SLSQP, with bounds of values as constraints: of as many
// values as unknowns that is Newton's method. Where it does not get there, as in steps, simplices follow (Sbplx), which
// need no slopes. Nothing is random but the starts that come last, of a seed; no result depends on threads.

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"

namespace openfab::fit {

/// Returns the next of a sequence of numbers from 0 to 1 (splitmix64).
double next_number(uint64_t* state);

/// What a value shall be.
struct Wanted {
    std::optional<double> at_least, at_most;  ///< the same twice: equal
    int32_t aim = 0;                          ///< -1: the least, 1: the most
    double within = 1;                        ///< how far from its bounds it is good enough

    double beyond(double value) const;
};

struct Point {
    std::vector<double> x;  ///< 0 ... 1 for each unknown
    std::vector<double> values;
};

/// Returns the values at a point of the unit cube; or their slopes there, [value][unknown].
using Values = std::function<Result<std::vector<double>>(std::span<const double> x)>;

struct SearchOptions {
    uint64_t seed = 0;
    int32_t most_evaluations = 400;  ///< of one method from one start
    const std::atomic<bool>* interrupt = nullptr;
    Values slopes{};  ///< empty: they are differences
};

struct SearchResult {
    Point best;
    bool reached = false;  ///< all values are within their bounds
    bool interrupted = false;
};

/// Whether the first point is better: nearer to the bounds; of points within them, by the aim.
bool is_better(const Point& a, const Point& b, std::span<const Wanted> wanted);
bool is_reached(const Point& point, std::span<const Wanted> wanted);

/// Searches from `start`. Fails where a value cannot be had; after an interrupt the best that was found is the result.
Result<SearchResult> search_unknowns(std::vector<double> start, std::span<const Wanted> wanted,
                                     const Values& values, const SearchOptions& options);

}  // namespace openfab::fit

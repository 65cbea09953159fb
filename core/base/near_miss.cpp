// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/near_miss.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "base/messages.h"
#include "base/text.h"

namespace openfab {
namespace {

/// Optimal string alignment distance; letters compare without case, so that `Uv` is near `uv`.
size_t edits(std::string_view a, std::string_view b) {
    const size_t width = b.size() + 1;
    std::vector<size_t> cost((a.size() + 1) * width);
    for (size_t i = 0; i <= a.size(); ++i) {
        for (size_t j = 0; j <= b.size(); ++j) {
            size_t& here = cost[i * width + j];
            if (i == 0 || j == 0) {
                here = i + j;
                continue;
            }
            const bool same = lower_ascii(a[i - 1]) == lower_ascii(b[j - 1]);
            here = std::min({cost[(i - 1) * width + j] + 1, cost[i * width + j - 1] + 1,
                             cost[(i - 1) * width + j - 1] + (same ? 0 : 1)});
            if (i > 1 && j > 1 && lower_ascii(a[i - 1]) == lower_ascii(b[j - 2]) &&
                lower_ascii(a[i - 2]) == lower_ascii(b[j - 1])) {
                here = std::min(here, cost[(i - 2) * width + j - 2] + 1);
            }
        }
    }
    return cost.back();
}

// Bounds the quadratic cost: names longer than this are not compared.
constexpr size_t kLongestName = 200;
/// The most candidates compared, which bounds the time where all are that long.
constexpr size_t kMost = 10'000;

}  // namespace

std::string near_miss(std::string_view name, std::span<const std::string> candidates) {
    if (name.empty() || name.size() > kLongestName) return {};
    size_t best = (name.size() == 2 ? 1 : name.size() / 3) + 1;
    const std::string* found = nullptr;
    for (const std::string& candidate : candidates.first(std::min(candidates.size(), kMost))) {
        if (candidate.size() > kLongestName) continue;
        if (found != nullptr && candidate == *found) continue;  // listed twice
        const size_t distance = edits(name, candidate);
        if (distance < best) {
            best = distance;
            found = &candidate;
        } else if (distance == best) {
            found = nullptr;
        }
    }
    return found != nullptr ? *found : std::string();
}

std::string suggest(std::string_view name, std::span<const std::string> candidates) {
    if (candidates.empty()) return messages::kThereAreNone;
    const std::string near = near_miss(name, candidates);
    if (!near.empty()) return fmt::format(messages::kDidYouMean, near);
    constexpr size_t kShown = 12;
    std::string names;
    for (size_t i = 0; i < std::min(kShown, candidates.size()); ++i) {
        names += fmt::format("{}`{}`", i == 0 ? "" : ", ", candidates[i]);
    }
    if (candidates.size() > kShown)
        names += fmt::format(messages::kAndMore, candidates.size() - kShown);
    return fmt::format(messages::kKnownNames, names);
}

}  // namespace openfab

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The colours of a file, numbered in the order in which they come.

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "backends/boundary/mixture_colors.h"

namespace openfab::boundary {

class ColorTable {
  public:
    /// So many are exact; what comes later is rounded to 5 bits a channel, and 2 of alpha, which bounds the table.
    static constexpr size_t kMostExact = 65536;

    size_t number(Rgba color) {
        const auto found = numbers_.find(color);
        if (found != numbers_.end()) return found->second;
        if (colors_.size() < kMostExact) return add(color);
        const auto round = [&](int shift, uint32_t most) {
            const uint32_t value = color >> shift & 255;
            return (value * most + 127) / 255 * 255 / most << shift;
        };
        const Rgba coarse = round(24, 31) | round(16, 31) | round(8, 31) | round(0, 3);
        const auto near = numbers_.find(coarse);
        return near != numbers_.end() ? near->second : add(coarse);
    }
    const std::vector<Rgba>& colors() const { return colors_; }

  private:
    size_t add(Rgba color) {
        numbers_.emplace(color, static_cast<uint32_t>(colors_.size()));
        colors_.push_back(color);
        return colors_.size() - 1;
    }

    std::unordered_map<Rgba, uint32_t> numbers_;
    std::vector<Rgba> colors_;
};

}  // namespace openfab::boundary

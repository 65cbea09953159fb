// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The baseline of our nearest queries: Embree's rtcPointQuery on one thread, built for quality.
// Frozen: the build refuses a changed embree_baseline.cpp, so that ratios stay comparable.

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace openfab::bench {

struct EmbreeHit {
    float distance2;
    uint32_t triangle;
    float point[3];
};

class EmbreeBaseline {
  public:
    EmbreeBaseline(const std::vector<float>& positions, const std::vector<uint32_t>& triangles);
    ~EmbreeBaseline();

    /// Nearest point within `radius` (infinity: anywhere); false if there is none.
    bool query(const float point[3], float radius, EmbreeHit* hit) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace openfab::bench

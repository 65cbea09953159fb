// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Counters of finished slices.

#include <array>
#include <cstdint>

#include "base/vec.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::pipeline {

struct SliceTotals {
    std::array<int64_t, 256> by_code{};
    uint64_t hash = 0;
    Box3i tight{};  ///< voxels with a material, hi exclusive; empty (lo > hi) without any

    void add(const SliceTotals& other);
};

/// Counts a slice of codes of 4 or 8 bits, rows without gaps.
SliceTotals count_slice(const pipeline::SliceView& slice, int32_t bits);

}  // namespace openfab::pipeline

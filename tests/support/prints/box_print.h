// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Prints axis-aligned boxes with the fablets of test_fablets.h, and computes the same by a plain
// reference: a box's coverage and nearest face in closed form, and the textbook twins of normalise
// and dither over the whole grid at once.

#include <cstdint>
#include <string>
#include <vector>

#include "runtime/dither/dither_rule.h"
#include "runtime/pipeline/print_job.h"

namespace openfab::testing {

/// Extra memory budget for sanitizers: a budget is for the whole process.
#ifdef OPENFAB_SANITIZED
inline constexpr int64_t kSanitizerBytes = 4'000'000'000;
#else
inline constexpr int64_t kSanitizerBytes = 0;
#endif

/// A sink that stores all slices in memory.
class MemorySink : public pipeline::SliceSink {
  public:
    Result<void> begin(const pipeline::PrintInfo& info) override;
    std::vector<uint8_t> encode(const pipeline::SliceView& slice) const override;
    Result<void> commit(int32_t z, std::vector<uint8_t> bytes) override;
    Result<void> finish(const pipeline::PrintTotals& totals) override;

    /// Returns the codes of the committed slices: x fastest, then y, then z.
    std::vector<uint8_t> codes() const;

    pipeline::PrintInfo info;
    std::vector<int32_t> z;
    std::vector<std::vector<uint8_t>> slices;  ///< packed rows
    pipeline::PrintTotals totals;
    int finished = 0;
    int32_t fail_at = -1;  ///< slice whose commit fails
};

/// A box with its lowest corner at `corner_mm`.
struct BoxPart {
    Vec3d corner_mm;
    Vec3d size_mm;
    const openfab_fablet* fablet = nullptr;
    int32_t priority = 0;
    std::vector<uint8_t> slot_material{1, 2, 0};
};

constexpr Vec3d kPitch{0.1, 0.08, 0.05};

pipeline::PrintInput make_input(const std::vector<BoxPart>& boxes, const Vec3d& pitch_mm = kPitch,
                                size_t materials = 2);

/// Computes the codes of the whole grid that `info` describes.
std::vector<uint8_t> reference_codes(const std::vector<BoxPart>& boxes,
                                     const pipeline::PrintInfo& info, uint64_t seed,
                                     dither::DitherRule rule = dither::kDefaultDither);

struct Printed {
    MemorySink sink;
    pipeline::PrintStatistics statistics;
    bool ok = false;
    Error error;
};
/// Creates and runs a print job; a failed creation is stored in `error`, too.
Printed print_boxes(const std::vector<BoxPart>& boxes, const pipeline::PrintOptions& options = {},
                    const Vec3d& pitch_mm = kPitch, size_t materials = 2);

}  // namespace openfab::testing

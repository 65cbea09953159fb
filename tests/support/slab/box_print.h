// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Prints of axis-aligned boxes with the fablets of test_fablets.h, and the same by a plain
// reference: a box's coverage and nearest face in closed form, and the textbook twins of normalise
// and dither over the whole grid at once.

#include <cstdint>
#include <string>
#include <vector>

#include "runtime/dither/dither_rule.h"
#include "runtime/pipeline/print.h"

namespace openfab::tests {

/// A memory budget is for the whole process, of which a sanitizer takes its share.
#ifdef OPENFAB_SANITIZED
inline constexpr int64_t kSanitizerBytes = 4'000'000'000;
#else
inline constexpr int64_t kSanitizerBytes = 0;
#endif

/// Keeps what it is given.
class MemorySink : public backends::SliceSink {
  public:
    Result<void> begin(const backends::PrintInfo& info) override;
    std::vector<uint8_t> encode(const backends::SliceView& slice) const override;
    Result<void> commit(int32_t z, const std::vector<uint8_t>& bytes) override;
    Result<void> finish(const backends::PrintTotals& totals) override;

    /// Codes of the slices committed: x fastest, then y, then z.
    std::vector<uint8_t> codes() const;

    backends::PrintInfo info;
    std::vector<int32_t> z;
    std::vector<std::vector<uint8_t>> slices;  ///< packed rows
    backends::PrintTotals totals;
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

slab::PrintInput make_input(const std::vector<BoxPart>& boxes, const Vec3d& pitch_mm = kPitch,
                            size_t materials = 2);

/// Codes of the whole grid that `info` describes.
std::vector<uint8_t> reference_codes(const std::vector<BoxPart>& boxes,
                                     const backends::PrintInfo& info, uint64_t seed,
                                     slab::DitherRule rule = slab::kDefaultDither);

struct Printed {
    MemorySink sink;
    slab::PrintStatistics statistics;
    bool ok = false;
    Error error;
};
/// Creates and runs; a failed creation shows in `error` too.
Printed print_boxes(const std::vector<BoxPart>& boxes, const slab::PrintOptions& options = {},
                    const Vec3d& pitch_mm = kPitch, size_t materials = 2);

}  // namespace openfab::tests

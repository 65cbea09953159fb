// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Results of the operations of simd/ for each instruction set, as plain data.

#include <cstdint>

namespace openfab::testing {

constexpr int kMaxLanes = 16;

struct Operands {
    alignas(64) float a[kMaxLanes], b[kMaxLanes], c[kMaxLanes];
    alignas(64) int32_t i[kMaxLanes], j[kMaxLanes];
    alignas(32) int16_t s[16], t[16];
    uint16_t words[8];
    uint8_t bytes[8];
};

/// Results of vectors of any number of lanes from eight.
struct Results {
    int lanes = 0;  ///< of the vectors of floats
    alignas(64) float sum[16], difference[16], product[16], quotient[16], least[16], most[16],
        root[16], magnitude[16], selected[16], about_sum[16], about_difference[16];
    alignas(64) int32_t selected_ints[16];
    uint32_t less, less_equal, equal, both, either, only_second, from_bits;
    bool some, none;
};

/// Results of 16-bit fixed-point numbers.
struct FixedResults {
    alignas(32) int16_t sum[16], product[16], capped[16], magnitude[16], selected[16];
    uint32_t greater;
};

/// Results of the vectors of one register.
struct RegisterResults {
    int lanes = 0;
    alignas(32) float down[8], up[8], of_ints[8], kept[8], dropped[8];
    alignas(32) int32_t truncated[8], rounded[8], sum[8], difference[8], product[8], least[8],
        most[8], shifted[8], hash[8], words[8], bytes[8], mask[8];
    uint8_t low_bytes[8];
    uint32_t greater, equal;
};

#define OPENFAB_DECLARE(isa)                                \
    namespace isa {                                         \
    void compute(const Operands& in, Results* out);         \
    void compute(const Operands& in, FixedResults* out);    \
    void compute(const Operands& in, RegisterResults* out); \
    }
OPENFAB_DECLARE(sse41)
OPENFAB_DECLARE(avx2)
OPENFAB_DECLARE(avx2_fma)
OPENFAB_DECLARE(avx512)
#undef OPENFAB_DECLARE

}  // namespace openfab::testing

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/render/flights.h"

#include "simd/isa.h"

namespace openfab::render {

namespace sse41 {
extern const Fly kFly;
}
namespace avx2 {
extern const Fly kFly;
}
namespace avx512 {
extern const Fly kFly;
}

Fly best_flight([[maybe_unused]] int limit) {
    if constexpr (simd::kWiderSets) {
        const simd::Isa best = simd::best_isa();
        if (limit >= 2 && best == simd::Isa::kAvx512) return avx512::kFly;
        if (limit >= 1 && best >= simd::Isa::kAvx2) return avx2::kFly;
    }
    return sse41::kFly;
}

}  // namespace openfab::render

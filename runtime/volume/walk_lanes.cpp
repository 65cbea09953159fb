// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/volume/walk_lanes.h"

#include <algorithm>

#include "simd/isa.h"

namespace openfab::volume {

namespace sse41 {
extern const WalkKernels kWalk;
}
namespace avx2 {
extern const WalkKernels kWalk;
}
namespace avx512 {
extern const WalkKernels kWalk;
}

WalkKernels walk_kernels([[maybe_unused]] openfab_isa limit) {
    if constexpr (simd::kWiderSets) {
        const simd::Isa best = simd::best_isa();
        if (limit >= OPENFAB_ISA_AVX512 && best >= simd::Isa::kAvx512) return avx512::kWalk;
        if (limit >= OPENFAB_ISA_AVX2 && best >= simd::Isa::kAvx2) return avx2::kWalk;
    }
    return sse41::kWalk;
}

void WalkLanes::begin(size_t lane, const Vec3f& p, float stop_mm, int32_t seed) {
    phase[lane] = kBegins;
    steps[lane] = on_object[lane] = 0;
    random[lane] = walk_seed(p, seed);
    stop[lane] = std::max(stop_mm, kLeastStop);
    for (size_t a = 0; a < 3; ++a) {
        at[a][lane] = asks[a][lane] = p[static_cast<int>(a)];
        up[a][lane] = 0;
    }
    height[lane] = over[lane] = reach[lane] = 0;
    side[lane] = 1;
}

void WalkLanes::know(size_t lane, const WalkField& field) {
    known[lane] = 1;
    own[lane] = field.own;
    object[lane] = field.object;
    may_exceed[lane] = field.over;
    for (size_t a = 0; a < 3; ++a) {
        own_slope[a][lane] = field.own_slope[static_cast<int>(a)];
        object_slope[a][lane] = field.object_slope[static_cast<int>(a)];
    }
}

Vec3f WalkLanes::end(size_t lane) const {
    return Vec3f{at[0][lane], at[1][lane], at[2][lane]} -
           Vec3f{up[0][lane], up[1][lane], up[2][lane]} * height[lane];
}

}  // namespace openfab::volume

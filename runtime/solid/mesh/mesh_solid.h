// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The geometry of a mesh, displaced by the surface stage of its fablet.

#include <memory>

#include "runtime/solid/kind.h"
#include "simd/isa.h"

namespace openfab::solid {

extern const Kind kMeshKind;

/// Queries may use more than kernels do, except where a print is limited to SSE4.1.
inline simd::Isa widest_queries(openfab_isa isa) {
    return isa >= OPENFAB_ISA_AVX2 ? simd::Isa::kAvx512 : simd::Isa::kSse41;
}

/// Makes the solid inside a surface of a part, which must outlive it. The surface is closed.
std::shared_ptr<Solid> make_solid_of(const part::Part& part,
                                     std::shared_ptr<const surface::Surface> surface);

}  // namespace openfab::solid

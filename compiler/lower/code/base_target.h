// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Halide's name for what every machine of this one's kind has: OPENFAB_ISA_SSE41.

#include <Halide.h>

#include <vector>

namespace openfab::lower {

inline Halide::Target base_target(std::vector<Halide::Target::Feature> features) {
    using Halide::Target;
#if defined(__x86_64__)
    features.push_back(Target::SSE41);
    return {Target::Linux, Target::X86, 64, features};
#else
    return {Target::Linux, Target::ARM, 64, features};
#endif
}

}  // namespace openfab::lower

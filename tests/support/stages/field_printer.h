// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Runs a field of fractions through the dither and the pack kernel, as the slab loop does.

#include <cstdint>
#include <vector>

#include "abi/kernel_call.h"
#include "tests/support/reference/dither.h"

namespace openfab::testing {

/// Returns codes in the twin's order: x fastest, then y, then z. `field.origin` must be a multiple
/// of 8 in z and 0 in x and y; its number of materials must be that of a compiled set.
std::vector<uint8_t> print_field(const reference::FractionField& field, uint64_t seed,
                                 openfab_isa isa, dither::DitherRule rule = dither::kDefaultDither);

/// Returns the instruction sets that this machine can run.
std::vector<openfab_isa> runnable_isas();

}  // namespace openfab::testing

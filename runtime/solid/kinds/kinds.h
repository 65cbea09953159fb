// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The kinds of solids that a print may hold.

#include <cstddef>
#include <variant>

#include "runtime/solid/kind.h"

namespace openfab::solid {

/// How many there are: tests/crossings has rows for each.
inline constexpr size_t kKindCount = std::variant_size_v<part::Geometry>;

/// Returns the kind of a part's geometry, or that of stretched parts.
const Kind& kind_of(const part::Part& part);

/// As Kind::make, refine and bytes, of a part and the bodies that its shape asks.
Result<std::shared_ptr<Solid>> make_solid(const part::Part& part,
                                          const surface::SurfaceOptions& options);
/// Whether it is known how far a part reaches before it is printed: not of what rules and programs make, in their box.
bool reach_is_known(const part::Part& part);
/// Returns the box of a part in build space before any displacement, by a solid that no pitch makes.
Result<Box3d> extent_in_build(const part::Part& part, openfab_isa isa);
Result<void> refine_source(const surface::SurfaceOptions& options, part::Part* part);
int64_t source_bytes(const part::Part& part);

}  // namespace openfab::solid

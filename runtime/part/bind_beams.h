// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Beams as the geometry of a part.

#include <array>
#include <memory>

#include "base/result.h"
#include "runtime/part/part.h"

namespace openfab::part {

/// Checks that a fablet and a stretch can have beams as geometry. The message names neither.
Result<void> check_beams(const openfab_fablet& fablet, const std::array<double, 9>& stretch);

/// Returns the beams as a part's geometry; `mesh` is the part's box, made of box_mesh for the same
/// stretch, which has checked names and types of attributes.
std::shared_ptr<const PartBeams> make_part_beams(std::shared_ptr<const mesh::Beams> beams,
                                                 const openfab_fablet& fablet,
                                                 const std::array<double, 9>& stretch,
                                                 const PartMesh& mesh);

}  // namespace openfab::part

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A solid that a placement, or a machine's scale, stretches as a whole, where its kind knows no stretch:
// what grows, beams that would be round no more, shapes along axes that are not their own. It is looked
// at where its source has it, in a frame that is stretched the other way, so that its voxels are exactly
// those of the stretched solid. Points and normals are those of the stretched solid, too. A distance is
// that of the source times the least factor: the right one where all directions are scaled alike, else
// at most as much too small as the factors differ. It never changes faster than the place, which bounds
// of distances rely on.

#include <memory>

#include "runtime/solid/solid.h"

namespace openfab::solid {

/// `part`: one with part::Stretched, whose source `solid` is made of; it must outlive the result.
std::shared_ptr<Solid> make_stretched_solid(const part::Part& part, std::shared_ptr<Solid> solid);

}  // namespace openfab::solid

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where cuts are better: where colours of a print change, and where a load strains the part little.

#include <cstdint>
#include <functional>
#include <string>

#include "base/affine.h"
#include "base/result.h"
#include "base/vec.h"

namespace openfab::tools {

/// A number at each point of a part.
using AtPoint = std::function<double(const Vec3d&)>;

/// Returns how well a seam shows at a point of the surface, from 0.2 where colours change to 1, by a print of the
/// part, an .ofr file. `to_build` leads from the points to those of the print.
Result<AtPoint> seam_by_colours(const std::string& print, const Affine3d& to_build, int64_t memory);

/// Returns the values of a volume, `FILE` or `FILE:ARRAY`, at points of the build.
Result<AtPoint> stress_of(const std::string& volume, const Affine3d& to_build, int64_t memory);

}  // namespace openfab::tools

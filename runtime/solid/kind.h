// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A kind of solids: how parts of it are told from others, compared, and made into a solid.

#include <cstdint>
#include <memory>
#include <vector>

#include "base/result.h"
#include "runtime/part/part.h"
#include "runtime/solid/solid.h"
#include "runtime/surface/surface.h"

namespace openfab::solid {

/// Solids of part::ShapeStage::bodies, by the same index; null where none is asked.
using Bodies = std::vector<std::shared_ptr<Solid>>;

/// `bodies` are those of the part's stage, if it has one.
struct Kind {
    /// Returns whether two parts that share a geometry (part::shared_geometry) have one solid.
    bool (*alike)(const part::Part& a, const part::Part& b) =
        [](const part::Part& /*a*/, const part::Part& /*b*/) { return true; };
    /// Changes a part's mesh and geometry to what `make` takes; parts alike get those of the first.
    Result<void> (*refine)(const surface::SurfaceOptions& options, const Bodies& bodies,
                           part::Part* part) =
        [](const surface::SurfaceOptions& /*options*/, const Bodies& /*bodies*/,
           part::Part* /*part*/) -> Result<void> { return {}; };
    /// Returns a lower bound, from counts, of the memory for `make`; 0 where it is not worth a check.
    int64_t (*bytes)(const part::Part& part) = [](const part::Part& /*part*/) -> int64_t {
        return 0;
    };
    /// Makes the solid. The part must outlive it.
    Result<std::shared_ptr<Solid>> (*make)(const part::Part& part,
                                           const surface::SurfaceOptions& options,
                                           const Bodies& bodies);
};

/// Returns whether a kernel gets the same uniforms, textures and instance from both parts.
bool same_arguments(const openfab_kernel& kernel, const part::Part& a, const part::Part& b);

}  // namespace openfab::solid

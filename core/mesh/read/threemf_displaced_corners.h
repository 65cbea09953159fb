// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The displacement of a 3MF file as attributes of its mesh, from which `openfab import` makes a surface
// stage.

#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>

#include "base/affine.h"
#include "base/result.h"
#include "mesh/model/mesh_assembly.h"
#include "mesh/read/threemf_displaced.h"
#include "mesh/read/threemf_model.h"

namespace openfab::mesh {

/// Gives corners the attributes `displace`, which are the coordinates in a map, a factor and the map's
/// number from 1, and `displace_n`, the direction in the build; of others the number is 0.
class ThreemfDisplacedCorners {
  public:
    explicit ThreemfDisplacedCorners(MeshAssembly* mesh) : mesh_(*mesh) {}

    void begin_body() { values_.clear(); }

    /// Sets those of the triangle that was added last: number `t` of the object, `mirrored` if its corners
    /// were swapped.
    Complaint set(const ThreemfDisplacements& all, const ThreemfObject& object,
                  const Affine3d& transform, size_t t, bool mirrored);

  private:
    MeshAssembly& mesh_;
    /// Of the body that is added: values at a group's points.
    std::map<std::pair<int64_t, int64_t>, std::pair<int32_t, int32_t>> values_;
};

}  // namespace openfab::mesh

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Skins: vertices that follow the nodes of a skeleton, as the file poses it.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "mesh/read/gltf_file.h"
#include "mesh/read/gltf_scene.h"

namespace openfab::mesh {

/// Sets of four joints that a vertex may follow.
constexpr int kMaxJointSets = 4;

/// Returns the transform of each joint of a placement's skin, from the axes of its mesh to z up;
/// empty where it has none, or where the skeleton is not in the scene. The file keeps errors.
std::vector<Affine3d> gltf_joints(GltfFile* gltf, const GltfScene& scene,
                                  const GltfPlacement& placement);

/// Moves the vertices of one primitive.
class GltfSkinning {
  public:
    /// Moves by `transform` where there are no joints, or the primitive follows none.
    static Result<GltfSkinning> read(GltfFile* gltf, const JsonValue& primitive, size_t vertices,
                                     const std::vector<Affine3d>& joints,
                                     const Affine3d& transform);

    /// Returns where vertex `v` goes.
    Affine3d at(size_t v) const { return joints_ == nullptr ? transform_ : blended(v); }

    /// Returns whether triangles are turned over.
    bool mirrors() const { return mirrors_; }

  private:
    GltfSkinning() = default;
    Affine3d blended(size_t v) const;

    const std::vector<Affine3d>* joints_ = nullptr;
    Affine3d transform_;
    bool mirrors_ = false;
    std::vector<GltfArray> followed_, shares_;  ///< by set
};

}  // namespace openfab::mesh

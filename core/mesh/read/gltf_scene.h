// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the meshes of a glTF file stand: the nodes of its default scene, and their instances.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"
#include "mesh/model/mesh_assembly.h"
#include "mesh/read/gltf_file.h"

namespace openfab::mesh {

/// A node with a mesh.
struct GltfPlacement {
    const JsonValue* node = nullptr;
    Affine3d transform;     ///< of the node, from the axes of its mesh to z up
    int32_t assembly = 0;   ///< index of its topmost node in the scene
    int64_t instances = 1;  ///< as the file states them
};

struct GltfScene {
    std::vector<GltfPlacement> placements;            ///< parents before children
    std::vector<std::optional<Affine3d>> transforms;  ///< by node; none if it is not in the scene
};

/// Reads the default scene; without scenes, all nodes. Tells `mesh` what of it is left out; the
/// file keeps errors.
GltfScene gltf_scene(GltfFile* gltf, MeshAssembly* mesh);

/// Returns the transforms of a placement's instances; the one of its node, if it has none.
std::vector<Affine3d> gltf_instances(GltfFile* gltf, const GltfPlacement& placement);

/// Returns a 4 x 4 matrix of a file, which has its columns one after another.
Affine3d gltf_matrix(const double* columns);

/// Tells what the file holds beside the meshes of its scene: other scenes, cameras, animations and
/// the like.
void tell_what_is_beside_the_scene(const GltfFile& gltf, MeshAssembly* mesh);

/// Returns the number of elements that an accessor should have, 0 where there is none; the accessor
/// is validated when it is read.
int64_t gltf_stated_count(const GltfFile& gltf, const JsonValue* object, std::string_view accessor);

}  // namespace openfab::mesh

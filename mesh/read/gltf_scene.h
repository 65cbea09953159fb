// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the meshes of a glTF file stand: the nodes of its default scene, and their instances.

#include <cstdint>
#include <string>
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

/// Returns the placed meshes of the default scene (without scenes: of all nodes), parents before
/// children. Tells `mesh` what of the scene is left out; the file keeps errors.
std::vector<GltfPlacement> gltf_placements(GltfFile* gltf, MeshAssembly* mesh);

/// Returns the transforms of a placement's instances; the one of its node, if it has none.
std::vector<Affine3d> gltf_instances(GltfFile* gltf, const GltfPlacement& placement);

/// Tells what the file holds beside the meshes of its scene: other scenes, cameras, animations and
/// the like.
void tell_what_is_beside_the_scene(const GltfFile& gltf, MeshAssembly* mesh);

/// Returns the number of elements that an accessor should have, 0 where there is none; the accessor
/// is validated when it is read.
int64_t gltf_stated_count(const GltfFile& gltf, const JsonValue* object, std::string_view accessor);

}  // namespace openfab::mesh

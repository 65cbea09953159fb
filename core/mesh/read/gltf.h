// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "base/result.h"
#include "mesh/model/look.h"
#include "mesh/model/mesh_source.h"

namespace openfab::mesh {

/// Reads glTF 2.0, as text or .glb: the triangles of the default scene with the transforms of their
/// nodes, y up turned to z up, in metres. A body is a node with a mesh, or an instance of one
/// (EXT_mesh_gpu_instancing); its assembly is its topmost node. Materials are looks, by their
/// index. NORMAL is "n", COLOR_0 "color" (3), and _NAME the attribute "name" in lower case; "uv" are
/// the coordinates of the material's picture, with its transform (KHR_texture_transform), else
/// TEXCOORD_0; TEXCOORD_N, as the file has it, is "uvN" beside it. v is turned so that 0 is at the
/// bottom; all are floats. Morph targets count at the weights of the file, and skins follow their
/// skeletons as they stand in it. Points, lines and what else a print has no use for are left out
/// and told; compressed meshes are refused. Errors name the location in the JSON.
Result<MeshSource> parse_gltf(std::string_view bytes, const std::string& file,
                              int64_t memory_bytes = kDefaultReadingBytes);

/// Calls take(index, bytes or error) for each source in order; sources as looks of parse_gltf have
/// them.
Result<void> read_gltf_pictures(const std::filesystem::path& file,
                                std::span<const std::string> sources, int64_t memory_bytes,
                                const TakePicture& take);

}  // namespace openfab::mesh

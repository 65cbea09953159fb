// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Joins a world with the fablets of a print binary: every uniform checked and laid out, textures
// opened, material slots resolved, meshes brought to part space.

#include <filesystem>
#include <string>
#include <vector>

#include "abi/fablet_table.h"
#include "base/result.h"
#include "runtime/part/part.h"
#include "runtime/part/uniforms.h"
#include "world/world.h"

namespace openfab::part {

struct BindOptions {
    /// Settings (settings.h), in order.
    std::vector<std::string> sets;
    /// Memory that the world's meshes and those of the parts may take together, all textures
    /// together, filtered, and the making of each; more is an error.
    int64_t memory_bytes = mesh::kDefaultReadingBytes;
    /// Receives what converters told of the textures.
    std::vector<std::string>* warnings = nullptr;
};

/// Makes the parts in build order; slot_material holds 1 + the index in world.materials, or 0 for
/// VOID. `fablets` must outlive them. Placements with the same mesh, fablet and bits of S share a
/// PartMesh, and so do those of different fablets that are plain (part_mesh.h). Errors name the world's file:line:column (or the --set), the fablet's declared type,
/// and what would be right.
Result<std::vector<Part>> bind(const world::World& world, const openfab_fablet_list& fablets,
                               const BindOptions& options = {});

/// Returns what `bind` would bind the uniforms of each placement to, in build order, without any mesh or texture.
Result<std::vector<BoundUniforms>> bind_values(const world::World& world,
                                               const openfab_fablet_list& fablets,
                                               const BindOptions& options = {});

/// Makes the part of a placement of a world that has no build yet, for its geometry: objects that its
/// volume asks for are unknown.
Result<Part> bind_geometry(const world::World& world, const world::Placement& placement,
                           const openfab_fablet_list& fablets, const BindOptions& options = {});

/// Makes a world of one mesh file (mm) with the one fablet, printer `generic`. Each Material
/// uniform (array elements apart) is bound to a material of its own name with a generated colour.
/// The object is called after the mesh file's stem. `fablet` selects one if the print binary has
/// several. A texture uniform takes a file name from `sets`, see BindOptions.
Result<world::World> make_quick_world(const std::filesystem::path& mesh,
                                      const openfab_fablet_list& fablets,
                                      const std::string& fablet = {},
                                      const std::vector<std::string>& sets = {},
                                      int64_t memory_bytes = mesh::kDefaultReadingBytes);

}  // namespace openfab::part

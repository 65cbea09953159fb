// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Binds the uniforms of one part: the world's values to the fablet's declarations.

#include <cstdint>
#include <string>
#include <vector>

#include "abi/fablet_table.h"
#include "base/result.h"
#include "world/world.h"

namespace openfab::part {

struct BoundUniforms {
    std::vector<uint32_t>
        values;  ///< uniform_value_count bit patterns, then derived_count, then those of tables
    std::vector<int32_t> textures;        ///< texture index -> index in world.textures
    std::vector<bool> texture_is_volume;  ///< bound to an ImageTexture3D
    std::vector<int32_t> objects;         ///< Object uniform -> index in world.objects
    std::vector<uint8_t> slot_material;   ///< slot -> 1 + index in world.materials; 0 void
};

/// Checks and lays out the values. `bindings` are the object's, with overrides applied. `object`
/// and `object_location` are for messages. `unplaced`: whether objects are placed is not known yet.
Result<BoundUniforms> bind_uniforms(const world::World& world, const openfab_fablet& fablet,
                                    const world::UniformBindings& bindings,
                                    const std::string& object,
                                    const SourceLocation& object_location, bool unplaced = false);

/// Appends the derived values of openfab_fablet::derived to the uniform values.
void derive_uniforms(const openfab_fablet& fablet, std::vector<uint32_t>* values);

/// Returns the declaration of a uniform: `float2 border`, `Material palette[4]`.
std::string declaration(const openfab_uniform& uniform);

/// The name by which a world binds the built-in void material.
constexpr const char* kVoidName = "VOID";

}  // namespace openfab::part

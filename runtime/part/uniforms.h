// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The uniforms of one part: the world's values against the fablet's declarations.

#include <cstdint>
#include <string>
#include <vector>

#include "abi/fablet_table.h"
#include "base/result.h"
#include "world/world.h"

namespace openfab::scene {

struct BoundUniforms {
    std::vector<uint32_t> values;         ///< uniform_value_count bit patterns, then derived_count
    std::vector<int32_t> textures;        ///< texture index -> place in world.textures
    std::vector<bool> texture_is_volume;  ///< bound to an ImageTexture3D
    std::vector<int32_t> objects;         ///< Object uniform -> place in world.objects
    std::vector<uint8_t> slot_material;   ///< slot -> 1 + place in world.materials; 0 void
};

/// `bindings` are the object's, with overrides applied. `object` and `object_place` are for
/// messages.
Result<BoundUniforms> bind_uniforms(const World& world, const openfab_fablet& fablet,
                                    const UniformBindings& bindings, const std::string& object,
                                    const SourceLocation& object_place);

/// Appends to the uniform values what kernels read that follows from them
/// (openfab_fablet::derived).
void derive_uniforms(const openfab_fablet& fablet, std::vector<uint32_t>* values);

/// As it is declared: `float2 border`, `Material palette[4]`.
std::string declaration(const openfab_uniform& uniform);

/// The name by which a world binds the built-in material that is nothing.
constexpr const char* kVoidName = "VOID";

}  // namespace openfab::scene

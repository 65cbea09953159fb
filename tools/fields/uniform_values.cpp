// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/fields/uniform_values.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <string_view>
#include <vector>

#include "abi/fablet_table.h"
#include "runtime/part/settings.h"

namespace openfab::tools {

namespace {

template <typename Value, size_t N>
Value named(const std::array<std::string_view, N>& names, const std::string& name) {
    const auto found = std::find(names.begin(), names.end(), name);
    return static_cast<Value>(found == names.end() ? 0 : std::distance(names.begin(), found));
}

// In the order of abi/fablet_table.h.
constexpr std::array<std::string_view, 6> kUniformKinds{"value",     "texture2d", "material",
                                                        "texture3d", "object",    "curve"};
static_assert(OPENFAB_UNIFORM_VALUE == 0 && OPENFAB_UNIFORM_TEXTURE2D == 1 &&
              OPENFAB_UNIFORM_MATERIAL == 2 && OPENFAB_UNIFORM_TEXTURE3D == 3 &&
              OPENFAB_UNIFORM_OBJECT == 4 && OPENFAB_UNIFORM_CURVE == 5);

openfab_scalar_type scalar_of(ir::Type type) {
    switch (type) {
        case ir::Type::kBool:
            return OPENFAB_BOOL;
        case ir::Type::kInt:
            return OPENFAB_INT;
        case ir::Type::kUint:
            return OPENFAB_UINT;
        case ir::Type::kFloat:
            break;
    }
    return OPENFAB_FLOAT;
}

}  // namespace

Result<part::BoundUniforms> bind_uniforms(const world::World& world, const FabletIr& fablet,
                                          const world::UniformBindings& bindings,
                                          const std::string& object,
                                          const SourceLocation& location) {
    std::vector<openfab_uniform> uniforms;
    for (const IrUniform& one : fablet.uniforms) {
        openfab_uniform made{};
        made.name = one.name.c_str();
        made.type_name = one.type_name.c_str();
        made.kind = named<openfab_uniform_kind>(kUniformKinds, one.kind);
        made.scalar = scalar_of(one.type);
        made.components = one.components;
        made.array_length = one.array_length;
        made.first_index = one.first_index;
        made.default_bits = one.default_bits.empty() ? nullptr : one.default_bits.data();
        uniforms.push_back(made);
    }
    openfab_fablet table{};
    table.abi_version = OPENFAB_ABI_VERSION;
    table.name = fablet.name.c_str();
    table.uniform_count = static_cast<int32_t>(uniforms.size());
    table.uniforms = uniforms.data();
    table.uniform_value_count = fablet.value_count;
    table.texture_count = fablet.texture_count;
    table.object_count = fablet.object_count;
    table.slot_count = fablet.slot_count;
    table.void_slot = fablet.void_slot;
    return part::bind_uniforms(world, table, bindings, object, location);
}

Result<void> set_uniforms(const std::vector<std::string>& settings, world::World* world) {
    return part::apply_settings(settings, world);
}

}  // namespace openfab::tools

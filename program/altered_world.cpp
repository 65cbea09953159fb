// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/altered_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "base/near_miss.h"
#include "mesh/model/primitives.h"
#include "program/messages.h"

namespace openfab::program {

namespace {

/// Of a solid no material counts: those that nobody has bound are any.
void bind_any_material(const openfab_fablet_list& fablets, const world::World& world,
                       const world::Object& object, world::Placement* placement) {
    const auto ref = world.fablets.find(object.fablet);
    if (ref == world.fablets.end() || world.materials.empty()) return;
    for (int32_t k = 0; k < fablets.count; ++k) {
        const openfab_fablet& fablet = *fablets.fablets[k];
        if (ref->second.fablet != fablet.name) continue;
        for (int32_t i = 0; i < fablet.uniform_count; ++i) {
            const openfab_uniform& u = fablet.uniforms[i];
            if (u.kind != OPENFAB_UNIFORM_MATERIAL || object.uniforms.contains(u.name)) continue;
            const std::vector<std::string> names(static_cast<size_t>(u.array_length),
                                                 world.materials.front().name);
            placement->overrides[u.name] = {names, false, object.location};
        }
    }
}

/// The object's fablet fills a box, which stands alone: the object's mesh is another one.
void fill_cell(const AlteredWorld& altered, int32_t index, world::World* world) {
    world->meshes.push_back(mesh::make_box(*altered.cell_mm));
    world::Object& object = world->objects[static_cast<size_t>(index)];
    object.mesh = static_cast<int32_t>(world->meshes.size() - 1);
    object.pieces = nullptr;
    world::Placement placed;
    placed.object = index;
    placed.transform.t = altered.cell_at_mm.value_or(Vec3d{});
    placed.location = object.location;
    world->build.assign(1, std::move(placed));
    world->tray = world::Tray::kAnywhere;
}

Result<void> replace_texture(const AlteredWorld& altered, world::World* world) {
    const size_t equals = altered.field.find('=');
    const std::string name = altered.field.substr(0, equals);
    const auto texture = std::ranges::find(world->textures, name, &world::Texture::name);
    if (equals == std::string::npos || texture == world->textures.end())
        return usage_error(fmt::format(messages::kFieldOfNoTexture, altered.field));
    world::Texture made;
    made.name = name;
    made.file = altered.field.substr(equals + 1);
    made.location = texture->location;
    made.wrap = made.wrap_v = world::Wrap::kClamp;
    made.filter = world::Filter::kTrilinear;
    const auto array = [](const Vec3d& v) { return std::array<double, 3>{v.x, v.y, v.z}; };
    if (altered.field_origin_mm) made.origin_mm = array(*altered.field_origin_mm);
    if (altered.field_spacing_mm) made.spacing_mm = array(*altered.field_spacing_mm);
    *texture = std::move(made);
    return {};
}

}  // namespace

Result<void> alter_world(const Options& options, const openfab_fablet_list& fablets,
                         world::World* world, pipeline::PrintInput* input) {
    const AlteredWorld& altered = options.altered;
    input->solid_code = altered.solid ? 1 : 0;
    input->around_vox = altered.around;
    input->lattice_mm = altered.lattice_mm;
    if (!altered.field.empty()) {
        if (Result<void> done = replace_texture(altered, world); !done) return done;
    }
    if (options.only_object.empty()) return {};
    const auto object =
        std::ranges::find(world->objects, options.only_object, &world::Object::name);
    if (object == world->objects.end()) {
        std::vector<std::string> names;
        for (const world::Object& one : world->objects)
            names.push_back(one.name);
        return user_error(fmt::format(messages::kNoSuchOnlyObject, options.only_object,
                                      suggest(options.only_object, names)));
    }
    input->process.emplace_back("only object", options.only_object);
    const auto index = static_cast<int32_t>(object - world->objects.begin());
    if (altered.cell_mm) {
        fill_cell(altered, index, world);
        return {};
    }
    const bool placed = std::ranges::any_of(
        world->build, [&](const world::Placement& one) { return one.object == index; });
    if (placed) return {};
    world::Placement added;
    added.object = index;
    added.location = object->mesh_location;
    if (altered.solid) bind_any_material(fablets, *world, *object, &added);
    world->build.push_back(std::move(added));
    input->beside_grid = 1;
    return {};
}

void print_only(const Options& options, const world::World& world, pipeline::PrintInput* input) {
    if (options.only_object.empty()) return;
    for (const world::Placement& one : world.build) {
        const auto object = static_cast<size_t>(one.object);
        input->only.push_back(world.objects[object].name == options.only_object ? 1 : 0);
    }
}

}  // namespace openfab::program

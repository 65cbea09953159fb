// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/part/bind.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "base/near_miss.h"
#include "mesh/load/load_mesh.h"
#include "mesh/model/mesh_memory.h"
#include "runtime/part/bind_beams.h"
#include "runtime/part/bind_piece.h"
#include "runtime/part/bind_shape.h"
#include "runtime/part/bind_textures.h"
#include "runtime/part/messages.h"
#include "runtime/part/part_mesh.h"
#include "runtime/part/settings.h"
#include "runtime/part/stretch.h"
#include "runtime/part/uniforms.h"

namespace openfab::part {
namespace {

/// Of fablets of one name that of the source counts; a program may have been built from another file.
const openfab_fablet* find_fablet(const openfab_fablet_list& list, const std::string& name,
                                  const std::string& source = {}) {
    const openfab_fablet* out = nullptr;
    for (int32_t i = 0; i < list.count; ++i) {
        const openfab_fablet* fablet = list.fablets[i];
        if (name != fablet->name) continue;
        if (source == fablet->source_name) return fablet;
        if (out == nullptr) out = fablet;
    }
    return out;
}

std::vector<std::string> fablet_names(const openfab_fablet_list& list) {
    std::vector<std::string> names;
    for (int32_t i = 0; i < list.count; ++i)
        names.emplace_back(list.fablets[i]->name);
    return names;
}

class WorldBinder {
  public:
    WorldBinder(const world::World& world, const openfab_fablet_list& fablets, int64_t memory_bytes)
        : world_(world),
          fablets_(fablets),
          textures_(world, memory_bytes),
          shapes_(world,
                  {.fablet_of = [this](const auto& object) { return fablet_of(object); },
                   .uniforms = [this](const auto& object, const auto& fablet,
                                      bool sets) { return uniforms_of(object, {}, fablet, sets); },
                   .textures = [this](const auto& bound) { return textures_.open(bound); },
                   .mesh = [this](const auto& object, const auto& fablet,
                                  const auto& s) { return part_mesh(object, fablet, s); },
                   .geometry =
                       [this](const auto& object, const auto& s, const auto& uniforms,
                              const auto& part) { return geometry(object, s, uniforms, part); }}) {}

    Result<Part> run_one(const world::Placement& placement, const BindOptions& options) {
        if (Result<void> sets = read_sets(options); !sets) return sets.error();
        memory_left_ = options.memory_bytes;
        unplaced_ = true;
        Result<Part> part = bind_placement(placement, 0);
        if (part && memory_left_ < 0) {
            return error_at(placement.location,
                            fmt::format(messages::kPartsTakeMemory, part->name,
                                        options.memory_bytes / 1'000'000),
                            messages::kPartsTakeMemoryHelp);
        }
        return part;
    }

    Result<std::vector<Part>> run(const BindOptions& options) {
        if (Result<void> sets = read_sets(options); !sets) return sets.error();
        memory_left_ = options.memory_bytes;
        for (const mesh::Mesh& mesh : world_.meshes)
            memory_left_ -= mesh::mesh_bytes(mesh::counts_of(mesh));
        if (Result<void> fine = check_sets_of_unplaced(); !fine) return fine.error();
        std::vector<Part> parts;
        parts.reserve(world_.build.size());
        for (size_t i = 0; i < world_.build.size(); ++i) {
            Result<Part> part = bind_placement(world_.build[i], static_cast<int32_t>(i));
            if (!part) return part.error();
            if (memory_left_ < 0) {
                return error_at(world_.build[i].location,
                                fmt::format(messages::kPartsTakeMemory, part->name,
                                            options.memory_bytes / 1'000'000),
                                messages::kPartsTakeMemoryHelp);
            }
            parts.push_back(std::move(*part));
        }
        if (options.warnings != nullptr) {
            options.warnings->insert(options.warnings->end(), textures_.notes().begin(),
                                     textures_.notes().end());
        }
        return parts;
    }

    Result<std::vector<BoundUniforms>> run_values(const BindOptions& options) {
        if (Result<void> sets = read_sets(options); !sets) return sets.error();
        std::vector<BoundUniforms> out;
        for (const world::Placement& placement : world_.build) {
            const world::Object& object = world_.objects[placement.object];
            const Result<const openfab_fablet*> fablet = fablet_of(object);
            if (!fablet) return fablet.error();
            Result<BoundUniforms> bound = uniforms_of(object, placement.overrides, **fablet, true);
            if (!bound) return bound.error();
            out.push_back(std::move(*bound));
        }
        return out;
    }

  private:
    Result<void> read_sets(const BindOptions& options) {
        Result<Settings> sets = read_settings(world_, options.sets);
        if (!sets) return sets.error();
        sets_ = std::move(*sets);
        return {};
    }

    /// Settings of objects that the build does not place are checked like others, where their fablets are there.
    Result<void> check_sets_of_unplaced() {
        for (size_t i = 0; i < world_.objects.size(); ++i) {
            const world::Object& object = world_.objects[i];
            const auto is_it = [&](const world::Placement& placement) {
                return static_cast<size_t>(placement.object) == i;
            };
            if (!sets_.contains(object.name) || std::ranges::any_of(world_.build, is_it)) continue;
            const Result<const openfab_fablet*> fablet = fablet_of(object);
            if (!fablet) continue;
            const Result<BoundUniforms> bound = uniforms_of(object, {}, **fablet, true);
            if (!bound && !setting_of(bound.error()).empty()) return bound.error();
        }
        return {};
    }

    Result<const openfab_fablet*> fablet_of(const world::Object& object) const {
        const world::FabletRef& ref = world_.fablets.at(object.fablet);
        const openfab_fablet* fablet = find_fablet(fablets_, ref.fablet, ref.source.filename());
        if (fablet == nullptr) {
            return error_at(ref.location,
                            fmt::format(messages::kFabletNotInPrint, ref.fablet,
                                        ref.source.filename().string()),
                            suggest(ref.fablet, fablet_names(fablets_)));
        }
        if (fablet->abi_version != OPENFAB_ABI_VERSION) {
            return user_error(fmt::format(messages::kOtherRuntime, ref.fablet, fablet->abi_version,
                                          OPENFAB_ABI_VERSION));
        }
        if (world_.dither && fablet->has_dither == 0) {
            return error_at(
                world_.dither->location,
                fmt::format(messages::kWithoutDitherRule, ref.fablet, world_.dither->rule),
                messages::kWithoutDitherRuleHelp);
        }
        return fablet;
    }

    Result<Part> bind_placement(const world::Placement& placement, int32_t instance) {
        const world::Object& object = world_.objects[placement.object];
        const Result<const openfab_fablet*> fablet = fablet_of(object);
        if (!fablet) return fablet.error();
        Result<BoundUniforms> uniforms = uniforms_of(object, placement.overrides, **fablet, true);
        if (!uniforms) return uniforms.error();

        Part part;
        part.name = object.name;
        part.fablet = *fablet;
        part.uniform_values = uniforms->values;
        part.slot_material = std::move(uniforms->slot_material);
        part.max_displacement_mm = static_cast<float>(object.max_displacement_mm);
        part.priority = object.priority;
        part.support = object.support;
        part.instance = instance;
        Result<std::vector<std::shared_ptr<const texture::Pyramid>>> textures =
            textures_.open(*uniforms);
        if (!textures) return textures.error();
        part.textures = std::move(*textures);
        for (const int32_t target : uniforms->objects) {
            const std::vector<int32_t>& placed = placements_of(target);
            memory_left_ -= static_cast<int64_t>(placed.size() * sizeof(int32_t));
            if (memory_left_ < 0) return part;  // reported by run
            part.objects.push_back(placed);
        }
        memory_left_ -= static_cast<int64_t>(sizeof part + part.name.size() +
                                             part.uniform_values.size() * sizeof(uint32_t));
        const Result<PolarFactors> polar = polar_factors(placement.transform.m);
        if (!polar) return error_at(placement.location, polar.error().message, polar.error().help);
        if (memory_left_ < 0) return part;
        Result<std::shared_ptr<const PartMesh>> mesh = part_mesh(object, **fablet, polar->s);
        if (mesh && *mesh == nullptr) return part;
        if (!mesh) return mesh.error();
        part.mesh = std::move(*mesh);
        Result<Geometry> made = geometry(object, polar->s, *uniforms, part);
        if (!made) return made.error();
        part.geometry = std::move(*made);
        part.stretched = stretched_from(part, polar->s);
        part.local_to_build =
            part_local_to_build(*polar, placement.transform.t, part.mesh->center_part_mm);
        if (placement.piece >= 0) {
            Result<std::shared_ptr<const Piece>> piece =
                bind_piece(world_, placement, *polar, part);
            if (!piece) return piece.error();
            part.piece = std::move(*piece);
            part.name += fmt::format(" {}", part.piece->region.name);
        }
        return part;
    }

    /// Overrides of a placement go before what the object has, and `--set` before both.
    Result<BoundUniforms> uniforms_of(const world::Object& object,
                                      const world::UniformBindings& overrides,
                                      const openfab_fablet& fablet, bool with_sets) {
        world::UniformBindings bindings = object.uniforms;
        for (const auto& [name, binding] : overrides)
            bindings.insert_or_assign(name, binding);
        if (const auto sets = sets_.find(object.name); with_sets && sets != sets_.end()) {
            for (const auto& [name, binding] : sets->second)
                bindings.insert_or_assign(name, binding);
        }
        return bind_uniforms(world_, fablet, bindings, object.name, object.location, unplaced_);
    }

    /// Makes the geometry of an object's part, which has all but that.
    Result<Geometry> geometry(const world::Object& object, const std::array<double, 9>& s,
                              const BoundUniforms& uniforms, const Part& part) {
        return std::visit([&](const auto& of) { return make(of, object, s, uniforms, part); },
                          world_.geometry_of(object.mesh));
    }
    static Result<Geometry> make(std::monostate /*mesh*/, const world::Object& /*object*/,
                                 const std::array<double, 9>& /*s*/,
                                 const BoundUniforms& /*uniforms*/, const Part& /*part*/) {
        return Geometry{MeshGeometry{}};
    }
    Result<Geometry> make(const std::shared_ptr<const mesh::Beams>& beams,
                          const world::Object& /*object*/, const std::array<double, 9>& s,
                          const BoundUniforms& /*uniforms*/, const Part& part) {
        auto& known = beams_[part.mesh.get()];
        if (known == nullptr) known = make_part_beams(beams, *part.fablet, s, *part.mesh);
        return Geometry{BeamGeometry{known}};
    }
    template <typename Stage>
    Result<Geometry> make(const Stage& of, const world::Object& object,
                          const std::array<double, 9>& s, const BoundUniforms& uniforms,
                          const Part& part) {
        return shapes_.bind(of, object, s, uniforms, part);
    }

    /// Null of a part whose geometry is stretched where it is made.
    std::shared_ptr<const Stretched> stretched_from(const Part& part,
                                                    const std::array<double, 9>& s) {
        if (!std::visit([&](const auto& of) { return of.stretches_whole(s); }, part.geometry))
            return nullptr;
        auto& known = stretched_[{shared_geometry(part), part.fablet, s}];
        if (known == nullptr)
            known = std::make_shared<const Stretched>(make_stretched(part, s, *part.fablet));
        return known;
    }

    const std::vector<int32_t>& placements_of(int32_t object) {
        if (placements_.empty()) {
            placements_.resize(world_.objects.size());
            for (size_t i = 0; i < world_.build.size(); ++i)
                placements_[world_.build[i].object].push_back(static_cast<int32_t>(i));
        }
        return placements_[object];
    }

    Result<std::shared_ptr<const PartMesh>> part_mesh(const world::Object& object,
                                                      const openfab_fablet& fablet,
                                                      const std::array<double, 9>& s) {
        auto& known = meshes_[{object.mesh, is_plain(fablet) ? nullptr : &fablet, s}];
        if (known != nullptr) return known;
        memory_left_ -= part_mesh_bytes(world_.meshes[object.mesh], fablet);
        if (memory_left_ < 0) return known;  // reported by run
        MadeMesh made = std::visit([&](const auto& of) { return make_mesh(of, object, fablet, s); },
                                   world_.geometry_of(object.mesh));
        if (!made) return error_at(object.mesh_location, made.error().message, made.error().help);
        known = *made;
        return known;
    }

    using MadeMesh = Result<std::shared_ptr<const PartMesh>>;

    MadeMesh make_mesh(std::monostate /*itself*/, const world::Object& object,
                       const openfab_fablet& fablet, const std::array<double, 9>& s) {
        return make_part_mesh(world_.meshes[object.mesh], fablet, s);
    }
    MadeMesh make_mesh(const std::shared_ptr<const mesh::Beams>& /*beams*/,
                       const world::Object& object, const openfab_fablet& fablet,
                       const std::array<double, 9>& s) {
        if (const Result<void> fine = check_beams(fablet, s); !fine)
            return with_context(fine.error(), fmt::format("`{}`: ", object.name));
        return make_part_mesh(world_.meshes[object.mesh], fablet, s);
    }
    template <typename Stage>
    MadeMesh make_mesh(const Stage& of, const world::Object& object, const openfab_fablet& fablet,
                       const std::array<double, 9>& s) {
        const openfab_fablet* stage = table_of(of);
        if (const Result<void> fine = check_stretch(stage, s, fablet.has_surface != 0); !fine)
            return with_context(fine.error(), fmt::format("`{}`: ", object.name));
        return make_part_mesh(box_of_shape(world_.meshes[object.mesh], stage), fablet, s);
    }

    const openfab_fablet* table_of(const world::StageRef& of) {
        const world::FabletRef& ref = world_.fablets.at(of.fablet);
        return find_fablet(fablets_, ref.fablet, ref.source.filename());
    }
    const openfab_fablet* table_of(const std::shared_ptr<const world::ProgramRef>& of) {
        return &shapes_.table_of(of)->fablet;
    }

    const world::World& world_;
    const openfab_fablet_list& fablets_;
    TextureBinder textures_;
    int64_t memory_left_ = 0;
    bool unplaced_ = false;                         ///< the world has no build yet
    std::vector<std::vector<int32_t>> placements_;  ///< by object; filled on first use
    Settings sets_;
    // Only for lookup, never iterated: the order of pointers must not affect results.
    std::map<std::tuple<int32_t, const openfab_fablet*, std::array<double, 9>>,
             std::shared_ptr<const PartMesh>>
        meshes_;
    ShapeBinder shapes_;
    std::map<const PartMesh*, std::shared_ptr<const PartBeams>> beams_;
    std::map<std::tuple<const void*, const openfab_fablet*, std::array<double, 9>>,
             std::shared_ptr<const Stretched>>
        stretched_;
};

/// Distinct, bright colours: hue steps by the golden ratio, so that any number of them are
/// distinct.
world::Rgba8 generated_color(size_t index) {
    const double hue = static_cast<double>(index) * 0.6180339887498949;
    const double h = (hue - std::floor(hue)) * 6;
    const auto channel = [&](double offset) {
        double k = h + offset;
        k -= std::floor(k / 6) * 6;
        const double value = std::min(std::max(std::min(k, 4 - k), 0.0), 1.0);
        return static_cast<uint8_t>(40 + 200 * (1 - value));
    };
    return {channel(5), channel(3), channel(1), 255};
}

/// Files that are set for textures become textures of those names.
Result<void> add_textures(const openfab_fablet& fablet, const std::vector<std::string>& sets,
                          const SourceLocation& location, world::World* world) {
    for (const std::string& text : sets) {
        const Result<Setting> set = parse_setting(text);
        if (!set) return set.error();
        const auto* names = std::get_if<std::vector<std::string>>(&set->binding.value);
        const bool texture = std::any_of(
            fablet.uniforms, fablet.uniforms + fablet.uniform_count, [&](const openfab_uniform& u) {
                return set->uniform == u.name &&
                       (u.kind == OPENFAB_UNIFORM_TEXTURE2D || u.kind == OPENFAB_UNIFORM_TEXTURE3D);
            });
        for (size_t i = 0; names != nullptr && texture && i < names->size(); ++i) {
            const std::string& name = (*names)[i];
            const bool known = std::any_of(world->textures.begin(), world->textures.end(),
                                           [&](const world::Texture& t) { return t.name == name; });
            std::error_code ignored;
            if (!known && !std::filesystem::exists(name, ignored)) {
                return error_at(place_of_setting(text), fmt::format(messages::kNoSuchFile, name));
            }
            if (known) continue;
            world::Texture added;
            added.name = name;
            added.file = name;
            added.location = location;
            world->textures.push_back(std::move(added));
            world->files.push_back(name);
        }
    }
    return Ok{};
}

}  // namespace

Result<std::vector<Part>> bind(const world::World& world, const openfab_fablet_list& fablets,
                               const BindOptions& options) {
    return WorldBinder(world, fablets, options.memory_bytes).run(options);
}

Result<std::vector<BoundUniforms>> bind_values(const world::World& world,
                                               const openfab_fablet_list& fablets,
                                               const BindOptions& options) {
    return WorldBinder(world, fablets, options.memory_bytes).run_values(options);
}

Result<Part> bind_geometry(const world::World& world, const world::Placement& placement,
                           const openfab_fablet_list& fablets, const BindOptions& options) {
    return WorldBinder(world, fablets, options.memory_bytes).run_one(placement, options);
}

Result<world::World> make_quick_world(const std::filesystem::path& mesh,
                                      const openfab_fablet_list& fablets, const std::string& fablet,
                                      const std::vector<std::string>& sets, int64_t memory_bytes) {
    const openfab_fablet* found =
        fablet.empty() && fablets.count == 1 ? fablets.fablets[0] : find_fablet(fablets, fablet);
    if (found == nullptr) {
        const std::vector<std::string> names = fablet_names(fablets);
        return user_error(
            fablet.empty() ? fmt::format(messages::kMeshNamesNoFablet, fablets.count)
                           : fmt::format(messages::kNoSuchFablet, fablet, suggest(fablet, names)));
    }
    world::World world;
    world.file = mesh;
    world.files = {mesh};
    world.printer = "generic";
    mesh::MeshOptions options;
    options.name = mesh.stem().string();
    options.memory_bytes = memory_bytes;
    Result<mesh::LoadedMesh> loaded = mesh::load_mesh(mesh, options);
    if (!loaded) return loaded.error();
    world.files.insert(world.files.end(), loaded->files.begin(), loaded->files.end());
    for (std::string& warning : loaded->warnings)
        world.warnings.push_back(std::move(warning));
    for (const mesh::LeftOut& left : loaded->left_out)
        world.warnings.push_back(mesh.string() + ": " + mesh::describe(left));
    Box3d box;
    for (const Vec3d& p : loaded->mesh.positions)
        box.add(p);
    const Vec3d size = box.size();
    world.notes.push_back(fmt::format(messages::kMeshSize, mesh.filename().string(), size.x, size.y,
                                      size.z, loaded->unit_mm, loaded->unit_note));
    world.meshes.push_back(std::move(loaded->mesh));

    const SourceLocation location{mesh.string(), 0, 0};
    world.fablets[found->name] = {found->source_name, found->name, {}, location, location};
    world::Object object;
    object.name = options.name;
    object.fablet = found->name;
    object.location = object.mesh_location = location;
    for (int32_t i = 0; i < found->uniform_count; ++i) {
        const openfab_uniform& u = found->uniforms[i];
        if (u.kind != OPENFAB_UNIFORM_MATERIAL) continue;
        std::vector<std::string> names;
        for (int32_t k = 0; k < u.array_length; ++k) {
            world::Material material;
            material.name = u.array_length == 1 ? u.name : fmt::format("{}[{}]", u.name, k);
            material.key = material.preview = generated_color(world.materials.size());
            material.location = location;
            names.push_back(material.name);
            world.materials.push_back(std::move(material));
        }
        object.uniforms[u.name] = {names, false, location};
    }
    if (Result<void> added = add_textures(*found, sets, location, &world); !added)
        return added.error();
    world.objects.push_back(std::move(object));
    world.build.push_back({0, {}, {}, location});
    return world;
}

}  // namespace openfab::part

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/process_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <variant>

#include "base/affine.h"
#include "base/hash.h"
#include "base/json.h"
#include "base/text.h"
#include "deformation/field.h"
#include "deformation/refine.h"
#include "program/messages.h"
#include "program/process_beams.h"
#include "texture/volume.h"
#include "world/json_reader.h"

namespace openfab::program {

namespace {

using deformation::Field;

/// Of neighbouring nodes: how differently they may be moved, of their distance. Steeper fields come from a
/// wrong unit, and may fold.
constexpr double kSteepest = 0.5;
constexpr size_t kMostTriangles = 20'000'000;

/// What says how a field is read, and which way it is applied.
struct FieldFile {
    std::filesystem::path volume;
    texture::VolumeOptions options;
    bool inverse = true;
};

Result<FieldFile> read_description(const std::filesystem::path& file) {
    FieldFile out;
    out.options.image.space = "data";
    if (file.extension() != ".json") {
        out.volume = file;
        return out;
    }
    constexpr int64_t kLargest = 1'000'000;
    const Result<std::string> text = read_text_file(file.string(), kLargest);
    if (!text) return text.error();
    const Result<JsonValue> root = parse_json(*text, file.string());
    if (!root) return root.error();
    world::JsonReader json(file.string());
    static const world::KeySet keys = {
        "field", {"file", "origin_mm", "spacing_mm", "field", "unit", "apply"}, {"file"}};
    if (!json.object(*root, keys, messages::kADisplacementField)) return json.error();
    out.volume = file.parent_path() / json.string(root->find("file")->value, "`file`");
    constexpr double kMost_mm = 1e5;
    const auto vector = [&](const char* key) -> std::optional<std::array<double, 3>> {
        const JsonMember* p = root->find(key);
        if (p == nullptr) return std::nullopt;
        const std::vector<double> n = json.numbers(p->value, fmt::format("`{}`", key), 3, kMost_mm);
        return std::array<double, 3>{n[0], n[1], n[2]};
    };
    out.options.origin_mm = vector("origin_mm");
    out.options.spacing_mm = vector("spacing_mm");
    if (const JsonMember* p = root->find("field"))
        out.options.field = json.string(p->value, "`field`");
    if (const JsonMember* p = root->find("unit"))
        out.options.unit = json.string(p->value, "`unit`");
    if (const JsonMember* p = root->find("apply"))
        out.inverse = json.choice(p->value, "`apply`", {"inverse", "as_is"}) == 0;
    if (!json.ok()) return json.error();
    return out;
}

Result<Field> read_field(const FieldFile& file, const Options& options,
                         std::vector<std::string>* warnings) {
    constexpr int32_t kClamp = 0;
    const auto pyramid = texture::get_volume(file.volume, file.options, kClamp,
                                             texture::kFilterTrilinear, {options.memory_bytes, {}});
    if (!pyramid) return with_context(pyramid.error(), messages::kOfDisplacementField);
    const texture::Pyramid& volume = **pyramid;
    for (const std::string& told : volume.notes())
        warnings->push_back(messages::kOfDisplacementField + told);
    const std::string name = printable(file.volume.string());
    if (volume.channels() != 3) {
        return user_error(fmt::format(messages::kFieldNumbers, name, volume.channels()),
                          messages::kFieldNumbersHelp);
    }
    const std::span<const int32_t> info = volume.info();
    const int32_t* level = info.data() + texture::kVolumeInfoHeader;
    std::array<float, 6> box;  // the lowest corner, and the size
    std::memcpy(box.data(), info.data() + texture::kInfoHeader, sizeof box);
    Field field;
    field.nodes = {level[1], level[2], level[3]};
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<size_t>(axis);
        const float* corner = box.data();
        field.spacing_mm[axis] = static_cast<double>(corner[a + 3]) / field.nodes[axis];
        field.origin_mm[axis] = static_cast<double>(corner[a]) + 0.5 * field.spacing_mm[axis];
    }
    const float* texels = volume.texels().data() + level[0];
    field.u_mm.resize(field.at(0, 0, field.nodes.z));
    for (size_t i = 0; i < field.u_mm.size(); ++i) {
        for (size_t c = 0; c < 3; ++c) {
            const auto value = static_cast<double>(texels[3 * i + c]);
            if (!std::isfinite(value)) {
                return user_error(fmt::format(messages::kFieldNotFinite, name));
            }
            field.u_mm[i][static_cast<int>(c)] = value;
        }
    }
    if (const double steepest = field.steepest(); !(steepest < kSteepest)) {
        return user_error(fmt::format(messages::kFieldTooSteep, name, steepest, kSteepest),
                          messages::kFieldTooSteepHelp);
    }
    return field;
}

/// The way back from what a placement has made of a place.
class Back {
  public:
    explicit Back(const Affine3d& to_build)
        : cofactors_(cofactors(to_build)), t_(to_build.t), determinant_(determinant(to_build)) {}
    bool exists() const { return std::fabs(determinant_) > 0; }
    Vec3d apply(const Vec3d& p) const {
        const auto& c = cofactors_.m;
        const Vec3d d = p - t_;
        return Vec3d{c[0] * d.x + c[3] * d.y + c[6] * d.z, c[1] * d.x + c[4] * d.y + c[7] * d.z,
                     c[2] * d.x + c[5] * d.y + c[8] * d.z} *
               (1 / determinant_);
    }

  private:
    Affine3d cofactors_;
    Vec3d t_;
    double determinant_;
};

/// The names that fablets of a world refer to objects, and materials, by.
std::set<std::string> names_used(const world::World& world) {
    std::set<std::string> out;
    const auto add = [&](const world::UniformBindings& all) {
        for (const auto& [name, binding] : all) {
            if (const auto* names = std::get_if<std::vector<std::string>>(&binding.value))
                out.insert(names->begin(), names->end());
        }
    };
    for (const world::Object& object : world.objects)
        add(object.uniforms);
    for (const world::Placement& placement : world.build)
        add(placement.overrides);
    return out;
}

class Displacer {
  public:
    Displacer(const Field& field, bool inverse, world::World* world)
        : field_(field), inverse_(inverse), world_(*world), names_(names_used(*world)) {}

    Result<void> run() {
        for (const world::Placement& placement : world_.build)
            ++uses_[static_cast<size_t>(placement.object)], ++mesh_uses_[mesh_of(placement)];
        for (world::Placement& placement : world_.build) {
            if (const Result<void> done = displace(&placement); !done) return done;
        }
        return {};
    }

  private:
    size_t mesh_of(const world::Placement& placement) const {
        return static_cast<size_t>(world_.objects[static_cast<size_t>(placement.object)].mesh);
    }

    Result<void> displace(world::Placement* placement) {
        const world::Object object = world_.objects[static_cast<size_t>(placement->object)];
        if (world_.is_made(object.mesh)) {
            return user_error(fmt::format(messages::kFieldCannotMove, object.name),
                              messages::kFieldCannotMoveHelp);
        }
        const Affine3d& to_build = placement->transform;
        const Back back(to_build);
        if (!back.exists()) return {};  // flat, which the print refuses
        if (const mesh::Beams* beams = world_.beams_of(object.mesh); beams != nullptr)
            return displace_beams(object, *beams, back, placement);
        mesh::Mesh mesh = world_.meshes[static_cast<size_t>(object.mesh)];
        if (const Result<void> fine = refine(object.name, to_build, &mesh); !fine) return fine;
        for (Vec3d& p : mesh.positions) {
            const std::optional<Vec3d> moved = moved_to(to_build.apply(p));
            if (!moved) return without_inverse(to_build.apply(p));
            p = back.apply(*moved);
        }
        const Result<int32_t> of = own_mesh(object, placement);
        if (!of) return of.error();
        world_.meshes[static_cast<size_t>(*of)] = std::move(mesh);
        return {};
    }

    Result<void> displace_beams(const world::Object& object, const mesh::Beams& beams,
                                const Back& back, world::Placement* placement) {
        const Affine3d& to_build = placement->transform;
        const double longest =
            std::min({field_.spacing_mm.x, field_.spacing_mm.y, field_.spacing_mm.z});
        MovedBeams moved = move_beams(
            beams, longest, kMostTriangles,
            [&](const Vec3d& a, const Vec3d& b) { return length(to_build.apply_vector(b - a)); },
            [&](const Vec3d& p) -> std::optional<Vec3d> {
                const std::optional<Vec3d> to = moved_to(to_build.apply(p));
                return to ? std::optional(back.apply(*to)) : to;
            });
        if (moved.too_many) {
            return user_error(
                fmt::format(messages::kFieldTooManyBeams, object.name, kMostTriangles, longest),
                messages::kFieldTooManyTrianglesHelp);
        }
        if (moved.lost) return without_inverse(to_build.apply(*moved.lost));
        const Result<int32_t> of = own_mesh(object, placement);
        if (!of) return of.error();
        mesh::Mesh& box = world_.meshes[static_cast<size_t>(*of)];
        box = mesh::box_mesh(box.name, moved.beams);
        world_.boxed[*of] = std::make_shared<const mesh::Beams>(std::move(moved.beams));
        return {};
    }

    std::optional<Vec3d> moved_to(const Vec3d& at) const {
        return inverse_ ? field_.moved_back(at) : std::optional(field_.moved(at));
    }
    static Error without_inverse(const Vec3d& at) {
        return user_error(fmt::format(messages::kFieldWithoutInverse, at.x, at.y, at.z));
    }

    /// Returns the number of a mesh that this placement alone has.
    Result<int32_t> own_mesh(const world::Object& object, world::Placement* placement) {
        if (mesh_uses_[static_cast<size_t>(object.mesh)] <= 1) return object.mesh;
        const auto made = static_cast<int32_t>(world_.meshes.size());
        if (uses_[static_cast<size_t>(placement->object)] == 1) {
            world_.objects[static_cast<size_t>(placement->object)].mesh = made;
        } else if (names_.contains(object.name)) {
            return user_error(fmt::format(messages::kFieldMovesReferred, object.name),
                              messages::kFieldMovesReferredHelp);
        } else {
            world_.objects.push_back(object);
            world_.objects.back().mesh = made;
            placement->object = static_cast<int32_t>(world_.objects.size() - 1);
        }
        mesh::Mesh empty;
        empty.name = world_.meshes[static_cast<size_t>(object.mesh)].name;
        world_.meshes.push_back(std::move(empty));
        return made;
    }

    /// Between nodes the field is almost linear, so that triangles as large as its cells are moved right.
    Result<void> refine(const std::string& name, const Affine3d& to_build, mesh::Mesh* mesh) const {
        deformation::Surface surface;
        for (const Vec3d& p : mesh->positions)
            surface.positions.push_back(to_build.apply(p));
        surface.triangles = mesh->triangles;
        for (mesh::MeshAttribute& attribute : mesh->attributes) {
            if (!attribute.is_int)
                surface.attributes.push_back(
                    {attribute.components, attribute.values, attribute.corners});
        }
        const double longest =
            std::min({field_.spacing_mm.x, field_.spacing_mm.y, field_.spacing_mm.z});
        const auto from = deformation::refine(longest, kMostTriangles, &surface);
        if (!from) {
            return user_error(
                fmt::format(messages::kFieldTooManyTriangles, name, kMostTriangles, longest),
                messages::kFieldTooManyTrianglesHelp);
        }
        if (surface.triangles.size() == mesh->triangles.size()) return {};
        const Back back(to_build);
        for (size_t i = mesh->positions.size(); i < surface.positions.size(); ++i)
            mesh->positions.push_back(back.apply(surface.positions[i]));
        mesh->triangles = std::move(surface.triangles);
        auto divided = surface.attributes.begin();
        for (mesh::MeshAttribute& attribute : mesh->attributes) {
            if (!attribute.is_int) {
                attribute.values = std::move(divided->values);
                attribute.corners = std::move(divided->corners);
                ++divided;
                continue;
            }
            const auto components = static_cast<size_t>(attribute.components);
            std::vector<int32_t> faces;
            for (const int32_t face : *from) {
                const int32_t* of = &attribute.faces[static_cast<size_t>(face) * components];
                faces.insert(faces.end(), of, of + components);
            }
            attribute.faces = std::move(faces);
        }
        return {};
    }

    const Field& field_;
    const bool inverse_;
    world::World& world_;
    const std::set<std::string> names_;
    std::map<size_t, int32_t> uses_, mesh_uses_;
};

}  // namespace

Result<void> displace_build(const world::Process& process, const Options& options,
                            world::World* world, pipeline::PrintInput* input) {
    if (process.field.empty()) return {};
    const Result<FieldFile> file = read_description(process.field);
    if (!file) return file.error();
    const Result<Field> field = read_field(*file, options, &world->warnings);
    if (!field) return field.error();
    if (const Result<void> done = Displacer(*field, file->inverse, world).run(); !done) return done;
    Hasher hash;
    hash.add(int32_t{file->inverse});
    for (const Vec3d& v : {field->origin_mm, field->spacing_mm}) {
        for (int axis = 0; axis < 3; ++axis)
            hash.add(v[axis]);
    }
    for (const Vec3d& u : field->u_mm) {
        for (int axis = 0; axis < 3; ++axis)
            hash.add(u[axis]);
    }
    input->process.emplace_back(
        "displacement field",
        fmt::format("{} {:016x}", file->inverse ? "inverse of" : "as it is", hash.value()));
    world->files.push_back(process.field);
    if (file->volume != process.field) world->files.push_back(file->volume);
    return {};
}

}  // namespace openfab::program

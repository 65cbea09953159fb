// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/amf.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "base/affine.h"
#include "base/color.h"
#include "base/rotation.h"
#include "base/scan_number.h"
#include "base/text.h"
#include "mesh/model/mesh_assembly.h"
#include "mesh/model/mesh_memory.h"
#include "mesh/read/amf_model.h"
#include "mesh/read/messages.h"
#include "mesh/read/zip_file.h"

namespace openfab::mesh {
namespace {

/// Constellations may repeat objects, so that the file's size does not bound these.
constexpr int64_t kMaxTriangles = 50'000'000;
constexpr int64_t kMaxPlacements = 100'000;
constexpr int kDeepest = 32;
constexpr int64_t kBodyBytes = 500;  ///< with its groups and names

/// What decides how a face looks, but for colours at its corners.
struct LookKey {
    int64_t material = -1;
    int32_t extruder = 0;
    AmfColorIndex color = -1;
    bool at_corners = false;
    auto operator<=>(const LookKey&) const = default;
};

class AmfReader {
  public:
    AmfReader(AmfModel model, std::string file, int64_t memory_bytes)
        : model_(std::move(model)), file_(std::move(file)), memory_bytes_(memory_bytes) {}

    Result<MeshSource> read() {
        for (size_t i = 0; i < model_.objects.size(); ++i) {
            if (!objects_.emplace(model_.objects[i].id, i).second)
                fail(fmt::format(messages::kAmfIdTwice, model_.objects[i].id));
        }
        place_all(&AmfReader::count);
        if (error_) return *error_;
        constexpr int64_t kKinds = 1;  // colours
        counts_.attributes = kKinds;
        const int64_t needed = preparing_bytes(counts_) + bodies_ * kBodyBytes;
        if (needed > memory_bytes_)
            return too_large_to_read(file_, counts_.triangles, needed, memory_bytes_);
        mesh_.reserve(counts_);
        place_all(&AmfReader::add_object);
        if (error_) return *error_;
        if (mesh_.triangles() == 0) return user_error(fmt::format(messages::kAmfEmpty, file_));
        MeshSource source = mesh_.finish(file_, model_.unit_mm);
        source.left_out = std::move(model_.told.list());
        return source;
    }

  private:
    using Use = void (AmfReader::*)(const AmfObject&, const Affine3d&, int32_t assembly);

    void fail(const std::string& what) {
        if (!error_) error_ = user_error(fmt::format("{}: {}", file_, what));
    }

    void place_all(Use use) {
        placements_ = 0;
        std::set<int64_t> placed;
        for (const auto& [id, instances] : model_.constellations) {
            for (const AmfInstance& instance : instances)
                placed.insert(instance.id);
        }
        int32_t assembly = 0;
        for (const auto& [id, instances] : model_.constellations) {
            if (placed.contains(id)) continue;
            for (const AmfInstance& instance : instances)
                place(instance, {}, assembly++, 0, use);
        }
        if (!model_.constellations.empty() && assembly == 0) fail(messages::kAmfCircle);
        for (const AmfObject& object : model_.objects) {
            if (!placed.contains(object.id)) (this->*use)(object, {}, assembly++);
        }
    }

    void place(const AmfInstance& instance, const Affine3d& holder, int32_t assembly, int depth,
               Use use) {
        if (error_) return;
        if (depth > kDeepest) return fail(fmt::format(messages::kNestedTooDeep, kDeepest));
        if (++placements_ > kMaxPlacements)
            return fail(fmt::format(messages::kTooManyObjects, kMaxPlacements));
        if (!instance.printable) {
            if (use == &AmfReader::count)
                model_.told.add(messages::kItemsSwitchedOff, fmt::format("object {}", instance.id),
                                messages::kSwitchThemOn);
            return;
        }
        const Vec3d &s = instance.scale, &m = instance.mirror;
        Affine3d own = placement_transform({s.x * m.x, s.y * m.y, s.z * m.z}, instance.rotation_deg,
                                           instance.delta);
        own = product(holder, own);
        const auto object = objects_.find(instance.id);
        if (object != objects_.end()) {
            (this->*use)(model_.objects[object->second], own, assembly);
            return;
        }
        const auto group = model_.constellations.find(instance.id);
        if (group == model_.constellations.end())
            return fail(fmt::format(messages::kNoSuchObject, instance.id));
        for (const AmfInstance& inner : group->second)
            place(inner, own, assembly, depth + 1, use);
    }

    void count(const AmfObject& object, const Affine3d&, int32_t) {
        for (const AmfVolume& volume : object.volumes) {
            if (volume.role == BodyRole::kNotPrinted) {
                if (!volume.triangles.empty())
                    model_.told.add(volume.use, fmt::format("object {}", object.id),
                                    messages::kOnlyForTheSlicer);
                continue;
            }
            const auto triangles = static_cast<int64_t>(volume.triangles.size());
            counts_.triangles += triangles;
            bodies_ += triangles > 0 ? 1 : 0;
            counts_.vertices +=
                std::min(static_cast<int64_t>(object.vertices.size()), 3 * triangles);
            counts_.values += has_corner_colors(object, volume) ? 9 * triangles : 0;
        }
        if (counts_.triangles > kMaxTriangles) fail(messages::kBuildTooManyTriangles);
    }

    static bool has_corner_colors(const AmfObject& object, const AmfVolume& volume) {
        return !object.vertex_colors.empty() ||
               std::ranges::any_of(volume.triangles,
                                   [](const AmfTriangle& t) { return t.color >= 0; });
    }

    void add_object(const AmfObject& object, const Affine3d& transform, int32_t assembly) {
        for (const AmfVolume& volume : object.volumes) {
            if (volume.role != BodyRole::kNotPrinted && !volume.triangles.empty())
                add_volume(object, volume, transform, assembly);
        }
    }

    void add_volume(const AmfObject& object, const AmfVolume& volume, const Affine3d& transform,
                    int32_t assembly) {
        Body body;
        body.name = !volume.name.empty() ? volume.name : object.name;
        body.role = volume.role;
        body.assembly = assembly;
        mesh_.bodies().push_back(body);
        const auto number = static_cast<int32_t>(mesh_.bodies().size() - 1);
        mesh_.begin_part();
        const bool mirrored = determinant(transform) < 0;
        if (numbers_.size() < object.vertices.size()) numbers_.resize(object.vertices.size(), -1);
        std::map<int32_t, int32_t> groups;  // by look
        for (const AmfTriangle& triangle : volume.triangles) {
            if (error_) return;
            std::array<int32_t, 3> corners{};
            for (size_t c = 0; c < 3; ++c)
                corners[c] = vertex(object, transform, triangle.vertices[c]);
            std::array<AmfColorIndex, 3> colors = corner_colors(object, triangle);
            if (mirrored) std::swap(corners[1], corners[2]), std::swap(colors[1], colors[2]);
            const bool at_corners = std::ranges::none_of(colors, [](auto c) { return c < 0; });
            const int32_t look = look_of(object, volume, at_corners);
            const auto [group, fresh] = groups.try_emplace(look, 0);
            if (fresh) group->second = group_of(look, number, body.name);
            mesh_.add_triangle(corners, group->second);
            if (at_corners) set_colors(colors);
        }
        // Bodies share no vertices.
        for (const AmfTriangle& triangle : volume.triangles) {
            for (const int32_t v : triangle.vertices)
                numbers_[static_cast<size_t>(v)] = -1;
        }
    }

    int32_t vertex(const AmfObject& object, const Affine3d& transform, int32_t v) {
        int32_t& number = numbers_[static_cast<size_t>(v)];
        if (number >= 0) return number;
        const Vec3d p = transform.apply(object.vertices[static_cast<size_t>(v)]);
        if (!is_position(p.x, p.y, p.z)) fail(fmt::format(messages::kAmfVertex, v, object.id));
        return number = mesh_.add_vertex(p);
    }

    /// Of a triangle or of its vertices; -1 where one has none.
    static std::array<AmfColorIndex, 3> corner_colors(const AmfObject& object,
                                                      const AmfTriangle& triangle) {
        std::array<AmfColorIndex, 3> out{triangle.color, triangle.color, triangle.color};
        for (size_t c = 0; c < 3 && triangle.color < 0; ++c) {
            const auto v = static_cast<size_t>(triangle.vertices[c]);
            if (v < object.vertex_colors.size()) out[c] = object.vertex_colors[v];
        }
        return out;
    }

    std::array<double, 3> linear(AmfColorIndex color) const {
        const AmfColor& c = model_.colors[static_cast<size_t>(color)];
        return {srgb_to_linear(c[0]), srgb_to_linear(c[1]), srgb_to_linear(c[2])};
    }

    void set_colors(const std::array<AmfColorIndex, 3>& colors) {
        if (!color_) color_ = mesh_.attribute("color", 3);
        if (!color_) return;
        std::array<int32_t, 3> values{};
        for (size_t c = 0; c < 3; ++c) {
            const auto [known, fresh] = values_.try_emplace(colors[c], -1);
            if (fresh) known->second = mesh_.add_value(*color_, linear(colors[c]).data());
            values[c] = known->second;
            if (model_.colors[static_cast<size_t>(colors[c])][3] < 1)
                model_.told.add(messages::kTransparentColours, file_,
                                messages::kTransparentColoursHelp);
        }
        mesh_.set_corners(*color_, values);
    }

    int32_t look_of(const AmfObject& object, const AmfVolume& volume, bool at_corners) {
        LookKey key{volume.material, volume.extruder > 0 ? volume.extruder : object.extruder,
                    volume.color >= 0 ? volume.color : object.color, at_corners};
        if (at_corners) key.color = -1;
        const auto [known, fresh] = looks_.try_emplace(key, -1);
        if (fresh) known->second = make_look(key);
        return known->second;
    }

    /// Makes the look of a key; -1 where the file says nothing.
    int32_t make_look(const LookKey& key) {
        Look look;
        look.is_material = key.material >= 0 || key.extruder > 0;
        AmfColorIndex color = key.color;
        if (key.material >= 0) {
            const auto it = model_.materials.find(key.material);
            if (it == model_.materials.end())
                return fail(fmt::format(messages::kAmfNoMaterial, key.material)), -1;
            const AmfMaterial& material = it->second;
            look.name =
                material.name.empty() ? fmt::format("material {}", key.material) : material.name;
            if (color < 0) color = material.color;
            if (!add_mixture(key, material, &look)) return -1;
        } else if (key.extruder > 0) {
            look.name = fmt::format("extruder {}", key.extruder);
        } else if (color < 0 && !key.at_corners) {
            return -1;
        } else {
            look.name = "colours";
        }
        if (color >= 0) {
            look.color = linear(color);
            look.alpha = model_.colors[static_cast<size_t>(color)][3];
        }
        if (key.at_corners) {
            look.vertex_colors = true;
            look.color = {1, 1, 1};
        }
        mesh_.looks().push_back(std::move(look));
        return static_cast<int32_t>(mesh_.looks().size() - 1);
    }

    /// Reads what a material is composed of; returns whether that is possible.
    bool add_mixture(const LookKey& key, const AmfMaterial& material, Look* look) {
        if (material.has_formula)
            model_.told.add(messages::kAmfShareFormulas, look->name,
                            messages::kAmfShareFormulasHelp);
        if (material.has_formula || material.parts.empty()) return true;
        double sum = 0;
        for (const auto& [id, share] : material.parts)
            sum += std::max(share, 0.0);
        if (!(sum > 0)) return fail(fmt::format(messages::kAmfNoShares, look->name)), false;
        for (const auto& [id, share] : material.parts) {
            if (!(share > 0)) continue;
            const auto part = model_.materials.find(id);
            if (part == model_.materials.end() || !part->second.parts.empty())
                return fail(fmt::format(messages::kAmfMixtureOf, look->name, id)), false;
            LookKey plain{id};
            const auto [known, fresh] = looks_.try_emplace(plain, -1);
            if (fresh) known->second = make_look(plain);
            if (error_) return false;
            look->mixture.emplace_back(known->second, share / sum);
        }
        look->is_material = key.material >= 0;
        return true;
    }

    int32_t group_of(int32_t look, int32_t body, const std::string& name) {
        FaceGroup group;
        if (!name.empty()) group.names = {name};
        group.look = look;
        group.body = body;
        if (look >= 0 && mesh_.looks()[static_cast<size_t>(look)].is_material)
            group.material = mesh_.looks()[static_cast<size_t>(look)].name;
        return mesh_.group_index(group);
    }

    AmfModel model_;
    std::string file_;
    int64_t memory_bytes_;
    std::map<int64_t, size_t> objects_;
    MeshAssembly mesh_;
    MeshCounts counts_;
    int64_t bodies_ = 0;
    std::vector<int32_t> numbers_;  ///< in the mesh, of the vertices of a body; -1: not yet
    std::map<LookKey, int32_t> looks_;
    std::optional<size_t> color_;
    std::map<AmfColorIndex, int32_t> values_;  ///< of `color`
    int64_t placements_ = 0;
    std::optional<Error> error_;
};

}  // namespace

Result<MeshSource> parse_amf(std::string_view bytes, const std::string& file,
                             int64_t memory_bytes) {
    std::string unpacked;
    if (bytes.starts_with("PK")) {
        const Result<ZipFile> zip = ZipFile::open(bytes, file);
        if (!zip) return zip.error();
        const std::vector<std::string> names = zip->names();
        const auto entry = std::ranges::find_if(
            names, [](const std::string& name) { return lower_ascii(name).ends_with(".amf"); });
        if (entry == names.end()) return user_error(fmt::format(messages::kAmfNotInArchive, file));
        Result<std::string> text = zip->read(*entry, std::max<int64_t>(memory_bytes, 0));
        if (!text) return text.error();
        unpacked = std::move(*text);
        memory_bytes -= static_cast<int64_t>(unpacked.capacity());
        bytes = unpacked;
    }
    Result<AmfModel> model = parse_amf_model(bytes, file, &memory_bytes);
    if (!model) return model.error();
    return AmfReader(std::move(*model), file, memory_bytes).read();
}

}  // namespace openfab::mesh

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/gltf.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/affine.h"
#include "base/scan_number.h"
#include "mesh/model/mesh_assembly.h"
#include "mesh/model/mesh_memory.h"
#include "mesh/read/gltf_attributes.h"
#include "mesh/read/gltf_file.h"
#include "mesh/read/gltf_looks.h"
#include "mesh/read/gltf_scene.h"
#include "mesh/read/gltf_skin.h"
#include "mesh/read/messages.h"

namespace openfab::mesh {
namespace {

/// Nodes may repeat a mesh, so that the file's size does not bound these.
constexpr int64_t kMaxTriangles = 50'000'000;
constexpr int64_t kMaxVertices = 100'000'000;
/// Limit of the primitives of all nodes, with their attributes: one without vertices takes time,
/// too.
constexpr int64_t kMaxPrimitives = 1'000'000;

class GltfReader {
  public:
    GltfReader(GltfFile file, std::string name) : gltf_(std::move(file)), name_(std::move(name)) {}

    Result<MeshSource> read() {
        scene_ = gltf_scene(&gltf_, &mesh_);
        const JsonValue* meshes = gltf_member(&gltf_.root(), "meshes");
        if (scene_.placements.empty() && meshes != nullptr && gltf_.ok())
            gltf_.fail(*meshes, messages::kNoNodeShowsAMesh, messages::kNoNodeShowsAMeshHelp);
        // Counts first: nodes may repeat a mesh, so the file's size is no bound.
        for (const GltfPlacement& placement : scene_.placements)
            count(placement);
        if (!gltf_.ok()) return gltf_.error();
        counts_.attributes = static_cast<int64_t>(names_.size());
        const int64_t needed = preparing_bytes(counts_) + largest_;
        if (needed > gltf_.memory_left())
            return too_large_to_read(name_, counts_.triangles, needed, gltf_.memory_left());
        mesh_.reserve(counts_);
        for (const GltfPlacement& placement : scene_.placements)
            add(placement);
        if (!gltf_.ok()) return gltf_.error();
        tell_what_is_beside_the_scene(gltf_, &mesh_);
        MeshSource out = mesh_.finish(name_, 1000);
        out.files = gltf_.files();
        return out;
    }

  private:
    void count(const GltfPlacement& placement) {
        const JsonValue* meshes = gltf_member(&gltf_.root(), "meshes");
        const JsonValue* index = gltf_member(placement.node, "mesh");
        if (meshes == nullptr || index == nullptr || !(index->number >= 0) ||
            !(index->number < static_cast<double>(meshes->items.size())) || !gltf_.ok())
            return;
        const JsonValue* primitives =
            gltf_member(&meshes->items[static_cast<size_t>(index->number)], "primitives");
        if (primitives == nullptr) return;
        constexpr int64_t kInstance = sizeof(Affine3d) + 10 * sizeof(double);
        constexpr int64_t kJoint = sizeof(Affine3d) + 16 * sizeof(double);
        const int64_t instances = std::min(placement.instances, kMaxPrimitives + 1);
        const int64_t joints = joints_of(*placement.node);
        primitives_ += joints;
        const int64_t beside = instances * kInstance + joints * kJoint;
        largest_ = std::max(largest_, beside);
        for (const JsonValue& primitive : primitives->items)
            count_primitive(primitive, instances, beside);
    }

    /// Returns the number of joints of a node's skin, as the file states them.
    int64_t joints_of(const JsonValue& node) const {
        const JsonValue* skins = gltf_member(&gltf_.root(), "skins");
        const JsonValue* index = gltf_member(&node, "skin");
        if (skins == nullptr || index == nullptr || !(index->number >= 0) ||
            !(index->number < static_cast<double>(skins->items.size())))
            return 0;
        const JsonValue* joints =
            gltf_member(&skins->items[static_cast<size_t>(index->number)], "joints");
        return joints != nullptr ? static_cast<int64_t>(joints->items.size()) : 0;
    }

    void count_primitive(const JsonValue& primitive, int64_t instances, int64_t beside) {
        if (!gltf_.ok()) return;
        const JsonValue* attributes = gltf_member(&primitive, "attributes");
        primitives_ += instances;
        if (attributes == nullptr) return;
        const int64_t vertices = gltf_stated_count(gltf_, attributes, "POSITION");
        const int64_t corners = primitive.find("indices") != nullptr
                                    ? gltf_stated_count(gltf_, &primitive, "indices")
                                    : vertices;
        const JsonValue* mode = gltf_member(&primitive, "mode");
        const JsonValue* targets = gltf_member(&primitive, "targets");
        if (targets != nullptr)
            primitives_ += instances * static_cast<int64_t>(targets->items.size());
        const GltfSkin skin = looks_.of(primitive);
        int64_t kept = 0, sets = 0;
        for (const JsonMember& m : attributes->members) {
            primitives_ += instances;
            sets += m.key.starts_with("JOINTS_") ? 1 : 0;
            for (const GltfTarget& target : gltf_targets(*attributes, m.key, skin.coordinates)) {
                if (names_.size() < MeshAssembly::kMaxAttributes) names_.insert(target.name);
                ++kept;
            }
        }
        if (primitives_ > kMaxPrimitives)
            return gltf_.fail(primitive, fmt::format(messages::kTooManyPrimitives, kMaxPrimitives));
        const bool strip = mode != nullptr && mode->number != 4;
        counts_.vertices += instances * vertices;
        counts_.triangles += instances * (strip ? corners : corners / 3);
        if (counts_.vertices > kMaxVertices || counts_.triangles > kMaxTriangles)
            return gltf_.fail(primitive, messages::kTooManyTrianglesOfNodes);
        counts_.values += instances * kept * vertices * 4;
        // State while reading: numbers as doubles (those of a morph target and of joints, too), and
        // the value of each vertex.
        const int64_t by_vertex =
            12 * 8 + 4 * kept + 8 * 8 * std::min<int64_t>(sets, kMaxJointSets);
        largest_ = std::max(largest_, beside + vertices * by_vertex + corners * 16);
    }

    void add(const GltfPlacement& placement) {
        if (!gltf_.ok()) return;
        const JsonValue& node = *placement.node;
        const JsonValue* mesh = gltf_.item("meshes", gltf_.integer(node, "mesh", 0), "a node");
        if (mesh == nullptr) return;
        const JsonMember* primitives = mesh->find("primitives");
        if (primitives == nullptr) return gltf_.fail(*mesh, messages::kMeshNoPrimitives);
        std::string name = name_of(node);
        if (name.empty()) name = name_of(*mesh);
        tell_of_mesh(placement, *mesh);
        const std::vector<Affine3d> joints = gltf_joints(&gltf_, scene_, placement);
        if (joints.empty() && node.find("skin") != nullptr)
            mesh_.leave_out(messages::kSkeletonNotInScene, gltf_.place_of("node", node),
                            messages::kSkeletonNotInSceneHelp);
        for (const Affine3d& transform : gltf_instances(&gltf_, placement)) {
            if (joints.empty() && determinant(transform) == 0) {
                mesh_.leave_out(messages::kInstanceScaledToNothing, gltf_.place_of("node", node),
                                messages::kScaledToNothingHelp);
                continue;
            }
            add_body(primitives->value, name, placement, joints, transform);
            if (!gltf_.ok()) return;
        }
    }

    std::string place_of(const JsonValue& node, const JsonValue& mesh) const {
        const bool has_name = node.find("name") != nullptr;
        return has_name ? gltf_.place_of("node", node) : gltf_.place_of("mesh", mesh);
    }

    /// What the mesh of a node has beside its primitives.
    void tell_of_mesh(const GltfPlacement& placement, const JsonValue& mesh) {
        const JsonValue& node = *placement.node;
        const JsonValue* primitives = gltf_member(&mesh, "primitives");
        if (!primitives->items.empty() && primitives->items[0].find("targets") != nullptr)
            mesh_.leave_out(messages::kMorphTargets, place_of(node, mesh),
                            messages::kMorphTargetsHelp);
        const JsonValue* weights = gltf_member(&node, "weights");
        if (weights == nullptr) weights = gltf_member(&mesh, "weights");
        weights_.clear();
        for (size_t i = 0; weights != nullptr && i < weights->items.size(); ++i)
            weights_.push_back(weights->items[i].number);
    }

    /// A node's mesh, or an instance of it: its primitives may close one surface together.
    void add_body(const JsonValue& primitives, const std::string& name,
                  const GltfPlacement& placement, const std::vector<Affine3d>& joints,
                  const Affine3d& transform) {
        mesh_.begin_part();
        if (mesh_.group_bytes() > gltf_.memory_left())
            return gltf_.fail(*placement.node, messages::kGltfNamesTakeTooMuch,
                              messages::kAllowMoreMemory);
        FaceGroup group;
        if (!name.empty()) group.names.push_back(name);
        group.body = static_cast<int32_t>(mesh_.bodies().size());
        const size_t before = mesh_.triangles();
        for (const JsonValue& primitive : primitives.items) {
            if (!gltf_.ok() || !has_triangles(primitive, *placement.node)) continue;
            const GltfSkin skin = looks_.of(primitive);
            group.material = skin.material;
            group.look = skin.look;
            if (gltf_.ok()) add_primitive(primitive, joints, transform, group, skin);
        }
        if (mesh_.triangles() == before) return;
        if (gltf_.take_memory(3 * (sizeof(Body) + name.size()), *placement.node))
            mesh_.bodies().push_back({name, BodyRole::kPart, placement.assembly});
    }

    bool has_triangles(const JsonValue& primitive, const JsonValue& node) {
        const int64_t mode = gltf_.integer(primitive, "mode", 4, 6);
        if (mode >= 4) return gltf_.ok();
        const std::string place = gltf_.place_of("node", node);
        if (mode == 0) mesh_.leave_out(messages::kPointsOfMesh, place, messages::kHaveNoVolume);
        if (mode > 0) mesh_.leave_out(messages::kLinesOfMesh, place, messages::kHaveNoVolume);
        return false;
    }

    /// Each node that repeats a mesh adds it again.
    std::string name_of(const JsonValue& thing) {
        constexpr size_t kLongest = 1000;
        std::string name = GltfFile::text(thing, "name");
        if (name.size() <= kLongest) return name;
        gltf_.fail(thing, fmt::format(messages::kNameTooLong, name.size(), kLongest));
        return {};
    }

    /// An attribute of the current primitive, with its values added to the mesh.
    struct Source {
        size_t attribute;
        std::vector<int32_t> value_of_vertex;
    };

    void add_primitive(const JsonValue& primitive, const std::vector<Affine3d>& joints,
                       const Affine3d& transform, const FaceGroup& group, const GltfSkin& skin) {
        const int64_t mode = gltf_.integer(primitive, "mode", 4, 6);
        const JsonValue* attributes = gltf_member(&primitive, "attributes");
        if (gltf_member(attributes, "POSITION") == nullptr)
            return gltf_.fail(primitive, messages::kPrimitiveNoPosition);
        if (is_only_compressed(primitive, *attributes))
            return gltf_.fail(primitive, messages::kCompressedWithDraco,
                              messages::kExportWithoutCompression);
        const std::optional<GltfArray> positions = array_of(primitive, "POSITION", 3);
        if (!positions) return;
        const std::vector<int64_t> corners = corners_of(primitive, *positions);
        if (!gltf_.ok()) return;
        const Result<GltfSkinning> moves =
            GltfSkinning::read(&gltf_, primitive, positions->count(), joints, transform);
        if (!moves) return;
        const auto first = static_cast<int32_t>(mesh_.vertices());
        for (size_t v = 0; v < positions->count(); ++v) {
            const double* p = &positions->values[v * 3];
            const Vec3d placed = moves->at(v).apply({p[0], p[1], p[2]});
            if (!is_position(placed.x, placed.y, placed.z))
                return gltf_.fail(primitive, fmt::format(messages::kVertexTooFar, v));
            mesh_.add_vertex(placed);
        }
        std::vector<Source> sources;
        colours_ = colours_of(primitive);
        for (const JsonMember& m : attributes->members)
            add_attribute(primitive, m, *moves, positions->count(), skin, &sources);
        if (gltf_.ok() && corners.size() >= 3)
            add_triangles(corners, mode, moves->mirrors(), first, mesh_.group_index(group),
                          sources);
    }

    /// Returns whether the accessors of a compressed primitive have no data of their own.
    bool is_only_compressed(const JsonValue& primitive, const JsonValue& attributes) {
        if (gltf_extension(&primitive, "KHR_draco_mesh_compression") == nullptr) return false;
        const JsonValue* positions =
            gltf_.item("accessors", gltf_.integer(attributes, "POSITION", 0), "a mesh");
        return positions != nullptr && positions->find("bufferView") == nullptr &&
               positions->find("sparse") == nullptr;
    }

    /// Reads an attribute of a primitive, at the weights of its morph targets.
    std::optional<GltfArray> array_of(const JsonValue& primitive, const std::string& key,
                                      size_t components) {
        std::optional<GltfArray> base =
            plain_array(*gltf_member(&primitive, "attributes"), key, components);
        const JsonValue* targets = gltf_member(&primitive, "targets");
        for (size_t t = 0; base && targets != nullptr && t < targets->items.size(); ++t) {
            const double weight = t < weights_.size() ? weights_[t] : 0;
            if (weight == 0 || gltf_member(&targets->items[t], key) == nullptr) continue;
            const std::optional<GltfArray> moved = plain_array(targets->items[t], key, components);
            if (!moved) return {};
            if (moved->count() != base->count()) {
                gltf_.fail(targets->items[t], fmt::format(messages::kMorphTargetValues, key,
                                                          moved->count(), base->count()));
                return {};
            }
            const size_t shared = std::min(base->components, moved->components);
            for (size_t v = 0; v < base->count(); ++v) {
                for (size_t c = 0; c < shared; ++c)
                    base->values[v * base->components + c] +=
                        weight * moved->values[v * moved->components + c];
            }
        }
        return base;
    }

    std::optional<GltfArray> plain_array(const JsonValue& attributes, const std::string& key,
                                         size_t components) {
        Result<GltfArray> array = gltf_.array(
            gltf_.integer(attributes, key.c_str(), 0),
            key.starts_with(kGltfColours) ? GltfFile::Use::kShares : GltfFile::Use::kNumbers);
        if (!array || !gltf_.ok()) return {};
        if (components != 0 && array->components != components) {
            gltf_.fail(attributes, fmt::format(messages::kWrongComponents, key, array->components),
                       fmt::format(messages::kWrongComponentsHelp, components));
            return {};
        }
        return std::move(*array);
    }

    /// Vertices of the primitive, one after another.
    std::vector<int64_t> corners_of(const JsonValue& primitive, const GltfArray& positions) {
        std::vector<int64_t> corners;
        if (primitive.find("indices") == nullptr) {
            for (size_t i = 0; i < positions.count(); ++i)
                corners.push_back(static_cast<int64_t>(i));
            return corners;
        }
        const Result<GltfArray> indices =
            gltf_.array(gltf_.integer(primitive, "indices", 0), GltfFile::Use::kIndices);
        if (!indices || !gltf_.ok()) return {};
        for (double index : indices->values) {
            if (index >= static_cast<double>(positions.count())) {
                gltf_.fail(primitive,
                           fmt::format(messages::kIndexOfNoVertex, index, positions.count()));
                return {};
            }
            corners.push_back(static_cast<int64_t>(index));
        }
        return corners;
    }

    /// What tells apart how the values of an attribute are read.
    struct Kinds {
        bool normal, coordinates, colour;
        Kinds(const std::string& key, const std::string& colours)
            : normal(key == "NORMAL"),
              coordinates(key.starts_with(kGltfTexture)),
              colour(key == colours) {}
        size_t components() const { return normal ? 3 : coordinates ? 2 : 0; }
    };

    /// Returns which of its colours are printed: the first. Where they are white throughout and others are not, the others:
    /// Blender writes white first where a material does not use the paint.
    std::string colours_of(const JsonValue& primitive) {
        const JsonValue& attributes = *gltf_member(&primitive, "attributes");
        const std::string first = fmt::format("{}0", kGltfColours),
                          second = fmt::format("{}1", kGltfColours);
        if (attributes.find(first) == nullptr || attributes.find(second) == nullptr) return first;
        const auto is_white = [&](const std::string& key) {
            const std::optional<GltfArray> array = array_of(primitive, key, 0);
            if (!array || array->components < 3) return key == second;
            for (size_t v = 0; v < array->count(); ++v) {
                for (size_t c = 0; c < 3; ++c) {
                    if (array->values[v * array->components + c] < 1) return false;
                }
            }
            return true;
        };
        if (!is_white(first) || is_white(second)) return first;
        mesh_.leave_out(messages::kWhiteColours, place_of(attributes), messages::kWhiteColoursHelp);
        return second;
    }

    std::string place_of(const JsonValue& value) const {
        return fmt::format("{}:{}:{}", name_, value.line, value.column);
    }

    void add_attribute(const JsonValue& primitive, const JsonMember& member,
                       const GltfSkinning& moves, size_t vertices, const GltfSkin& skin,
                       std::vector<Source>* sources) {
        if (!gltf_.ok()) return;
        const JsonValue& attributes = *gltf_member(&primitive, "attributes");
        std::vector<GltfTarget> targets;
        if (member.key == colours_) {
            targets = {{"color"}};
        } else if (!member.key.starts_with(kGltfColours)) {
            targets = gltf_targets(attributes, member.key, skin.coordinates);
        }
        if (targets.empty()) return tell_of_attribute(member);
        const Kinds kinds(member.key, colours_);
        const std::optional<GltfArray> array = array_of(primitive, member.key, kinds.components());
        if (!array) return;
        if (array->count() != vertices)
            return gltf_.fail(member.value, fmt::format(messages::kWrongValues, member.key,
                                                        array->count(), vertices));
        if (kinds.colour && array->components < 3)
            return gltf_.fail(member.value, messages::kColorComponents);
        if (kinds.colour && skin.is_transparent) tell_of_transparency(*array, skin);
        for (const GltfTarget& target : targets)
            add_values(*array, member, target, moves, skin, sources);
    }

    void add_values(const GltfArray& array, const JsonMember& member, const GltfTarget& target,
                    const GltfSkinning& moves, const GltfSkin& skin, std::vector<Source>* sources) {
        const Kinds kinds(member.key, colours_);
        const size_t kept = kinds.colour ? 3 : array.components;
        const std::optional<size_t> attribute =
            mesh_.attribute(target.name, static_cast<int32_t>(kept));
        if (!attribute)
            return mesh_.leave_out(
                fmt::format(messages::kAttributeComponents, member.key.substr(0, 40), kept),
                fmt::format("{}:{}:{}", name_, member.line, member.column),
                fmt::format(messages::kAttributeComponentsHelp, MeshAssembly::kMaxAttributes));
        const auto has_it = [&](const Source& s) { return s.attribute == *attribute; };
        if (std::any_of(sources->begin(), sources->end(), has_it)) return tell_of_attribute(member);
        const double side = moves.mirrors() ? -1 : 1;
        const GltfTextureTransform& m = skin.transform;
        Source source{*attribute, {}};
        source.value_of_vertex.reserve(array.count());
        for (size_t v = 0; v < array.count(); ++v) {
            std::array<double, 4> value{};
            for (size_t c = 0; c < kept; ++c)
                value[c] = array.values[v * array.components + c];
            if (kinds.coordinates) {
                if (target.at_picture)
                    value = {m[0] * value[0] + m[1] * value[1] + m[2],
                             m[3] * value[0] + m[4] * value[1] + m[5]};
                value[1] = 1 - value[1];
            }
            if (kinds.colour) {
                for (double& channel : value)
                    channel = channel > 1 ? 1 : channel < 0 ? 0 : channel;
            }
            if (kinds.normal) {
                const Vec3d n =
                    cofactors(moves.at(v)).apply_vector({value[0], value[1], value[2]}) * side;
                const double scale = length(n) > 0 ? 1 / length(n) : 0;
                value = {n.x * scale, n.y * scale, n.z * scale, 0};
            }
            source.value_of_vertex.push_back(mesh_.add_value(*attribute, value.data()));
        }
        sources->push_back(std::move(source));
    }

    /// Tangents serve normal maps, joints and weights skins, which are told.
    void tell_of_attribute(const JsonMember& member) {
        if (member.key == fmt::format("JOINTS_{}", kMaxJointSets))
            mesh_.leave_out(fmt::format(messages::kJointsBeyond, 4 * kMaxJointSets),
                            fmt::format("{}:{}:{}", name_, member.line, member.column),
                            messages::kJointsBeyondHelp);
        for (const char* known : {"POSITION", "TANGENT", "JOINTS_", "WEIGHTS_"}) {
            if (member.key.starts_with(known)) return;
        }
        if (member.key.starts_with(kGltfColours)) {
            if (member.key == fmt::format("{}0", kGltfColours)) return;  // which colours_of tells
            return mesh_.leave_out(fmt::format(messages::kMoreColours, member.key.substr(0, 40)),
                                   fmt::format("{}:{}:{}", name_, member.line, member.column),
                                   messages::kMoreColoursHelp);
        }
        mesh_.leave_out(fmt::format(messages::kOwnAttribute, member.key.substr(0, 40)),
                        fmt::format("{}:{}:{}", name_, member.line, member.column),
                        messages::kOwnAttributeHelp);
    }

    void tell_of_transparency(const GltfArray& colours, const GltfSkin& skin) {
        if (colours.components < 4) return;
        for (size_t v = 0; v < colours.count(); ++v) {
            if (colours.values[v * 4 + 3] >= 1) continue;
            return mesh_.leave_out(messages::kVertexTransparency, skin.place,
                                   messages::kVertexTransparencyHelp);
        }
    }

    void add_triangles(const std::vector<int64_t>& corners, int64_t mode, bool mirrored,
                       int32_t first, int32_t group, const std::vector<Source>& sources) {
        const size_t step = mode == 4 ? 3 : 1;
        for (size_t i = 0; i + 2 < corners.size(); i += step) {
            std::array<int64_t, 3> t{corners[i], corners[i + 1], corners[i + 2]};
            if (mode == 6) t[0] = corners[0];
            // Every other triangle of a strip is reversed.
            const bool turned = mode == 5 && i % 2 == 1;
            if (turned != mirrored) std::swap(t[1], t[2]);
            mesh_.add_triangle(
                {first + static_cast<int32_t>(t[0]), first + static_cast<int32_t>(t[1]),
                 first + static_cast<int32_t>(t[2])},
                group);
            for (const Source& source : sources) {
                const auto value = [&](size_t k) { return source.value_of_vertex[t[k]]; };
                mesh_.set_corners(source.attribute, {value(0), value(1), value(2)});
            }
        }
    }

    GltfFile gltf_;
    std::string name_;
    MeshAssembly mesh_;
    GltfScene scene_;
    GltfLooks looks_{&gltf_, &mesh_};
    std::string colours_;  ///< the attribute of the current primitive that its colours are of
    std::vector<double> weights_;  ///< of morph targets, of the current mesh
    MeshCounts counts_;            ///< of all nodes
    std::set<std::string> names_;  ///< of attributes
    int64_t primitives_ = 0;
    int64_t largest_ = 0;  ///< bytes beside the mesh while a primitive is read
};

}  // namespace

Result<MeshSource> parse_gltf(std::string_view bytes, const std::string& file,
                              int64_t memory_bytes) {
    Result<GltfFile> gltf = GltfFile::open(bytes, file, memory_bytes);
    if (!gltf) return gltf.error();
    return GltfReader(std::move(*gltf), file).read();
}

}  // namespace openfab::mesh

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/gltf.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/affine.h"
#include "base/scan_number.h"
#include "base/text.h"
#include "mesh/model/mesh_assembly.h"
#include "mesh/model/mesh_memory.h"
#include "mesh/read/gltf_file.h"

namespace openfab::mesh {
namespace {

using Kind = JsonValue::Kind;

/// Nodes may repeat a mesh, so that the file's size does not bound these.
constexpr int64_t kMaxTriangles = 50'000'000;
constexpr int64_t kMaxVertices = 100'000'000;
/// Limit of the primitives of all nodes, with their attributes: one without vertices takes time,
/// too.
constexpr int64_t kMaxPrimitives = 1'000'000;
constexpr size_t kMaxWarnings = 100;
/// y up, z to the viewer -> z up, y away.
constexpr Affine3d kZUp{{1, 0, 0, 0, 0, -1, 0, 1, 0}, {}};

/// Returns the attribute that a glTF attribute becomes; empty for ignored ones.
std::string attribute_name(const std::string& gltf) {
    if (gltf == "NORMAL") return "n";
    if (gltf == "COLOR_0") return "color";
    if (gltf == "TEXCOORD_0") return "uv";
    constexpr std::string_view kTexture = "TEXCOORD_";
    if (gltf.starts_with(kTexture)) return "uv" + gltf.substr(kTexture.size());
    if (!gltf.starts_with('_') || gltf.size() == 1) return {};
    return lower_ascii(gltf.substr(1));
}

class GltfReader {
  public:
    GltfReader(GltfFile file, std::string name) : gltf_(std::move(file)), name_(std::move(name)) {}

    Result<MeshSource> read() {
        // Counts first: nodes may repeat a mesh, so the file's size is no bound.
        for_each_node(&GltfReader::count_node);
        if (!gltf_.ok()) return gltf_.error();
        counts_.attributes = static_cast<int64_t>(names_.size());
        const int64_t needed = preparing_bytes(counts_) + largest_;
        if (needed > gltf_.memory_left())
            return too_large_to_read(name_, counts_.triangles, needed, gltf_.memory_left());
        mesh_.reserve(counts_);
        for_each_node(&GltfReader::add_node);
        if (!gltf_.ok()) return gltf_.error();
        warn_of_what_is_left_out();
        MeshSource out = mesh_.finish(name_, 1000);
        out.files = gltf_.files();
        return out;
    }

  private:
    using Use = void (GltfReader::*)(const JsonValue& node, const Affine3d& transform);

    /// Calls `use` for the nodes of the scene, parents before children.
    void for_each_node(Use use) {
        struct Visit {
            int64_t node;
            Affine3d transform;
        };
        std::vector<Visit> stack;
        visited_.clear();
        for (int64_t node : root_nodes())
            stack.push_back({node, kZUp});
        std::reverse(stack.begin(), stack.end());
        while (!stack.empty() && gltf_.ok()) {
            const Visit visit = stack.back();
            stack.pop_back();
            const JsonValue* node = gltf_.item("nodes", visit.node, "a scene or node");
            if (node == nullptr || !mark_visited(visit.node, *node)) break;
            const Affine3d transform = product(visit.transform, transform_of(*node));
            (this->*use)(*node, transform);
            const std::vector<int64_t> children = indices_of(*node, "children");
            for (size_t i = children.size(); i-- > 0;)
                stack.push_back({children[i], transform});
        }
    }

    /// Returns the number of elements that an accessor or a list should have; it is validated when
    /// read.
    static int64_t stated(const JsonValue& object, const char* key) {
        const JsonMember* m = object.find(key);
        constexpr double kMost = 1LL << 32;
        return m != nullptr && m->value.number >= 0 && m->value.number <= kMost
                   ? static_cast<int64_t>(m->value.number)
                   : 0;
    }
    int64_t stated_count(const JsonValue& object, const char* accessor) const {
        const JsonMember* list = gltf_.root().find("accessors");
        const auto index = static_cast<size_t>(stated(object, accessor));
        if (object.find(accessor) == nullptr || list == nullptr ||
            index >= list->value.items.size())
            return 0;
        return stated(list->value.items[index], "count");
    }

    void count_node(const JsonValue& node, const Affine3d&) {
        const JsonMember* meshes = gltf_.root().find("meshes");
        const auto index = static_cast<size_t>(stated(node, "mesh"));
        if (node.find("mesh") == nullptr || meshes == nullptr ||
            index >= meshes->value.items.size())
            return;
        const JsonMember* primitives = meshes->value.items[index].find("primitives");
        if (primitives == nullptr) return;
        for (const JsonValue& primitive : primitives->value.items)
            count_primitive(primitive);
    }

    void count_primitive(const JsonValue& primitive) {
        const JsonMember* attributes = primitive.find("attributes");
        ++primitives_;
        if (attributes == nullptr) return;
        const int64_t vertices = stated_count(attributes->value, "POSITION");
        const int64_t corners =
            primitive.find("indices") != nullptr ? stated_count(primitive, "indices") : vertices;
        int64_t kept = 0;
        for (const JsonMember& m : attributes->value.members) {
            ++primitives_;
            const std::string name = attribute_name(m.key);
            if (name.empty()) continue;
            if (names_.size() < MeshAssembly::kMaxAttributes) names_.insert(name);
            ++kept;
        }
        const bool strip = primitive.find("mode") != nullptr && stated(primitive, "mode") != 4;
        counts_.vertices += vertices;
        counts_.triangles += strip ? corners : corners / 3;
        counts_.values += kept * vertices * 4;
        // State while reading: numbers as doubles, and the value of each vertex.
        largest_ = std::max(largest_, vertices * (8 * 8 + 4 * kept) + corners * 16);
        if (primitives_ > kMaxPrimitives)
            gltf_.fail(primitive, fmt::format("the nodes have more than {} primitives with their "
                                              "attributes",
                                              kMaxPrimitives));
        if (counts_.vertices > kMaxVertices || counts_.triangles > kMaxTriangles)
            gltf_.fail(primitive, "the meshes of all nodes have too many triangles");
    }

    std::vector<int64_t> indices_of(const JsonValue& object, const char* key) {
        std::vector<int64_t> out;
        const JsonMember* list = object.find(key);
        if (list == nullptr) return out;
        for (const JsonValue& item : list->value.items) {
            if (!item.is(Kind::kNumber) || !(item.number >= 0 && item.number < 1e9) ||
                item.number != std::floor(item.number)) {
                gltf_.fail(item, fmt::format("`{}` holds something other than indices", key));
                return {};
            }
            out.push_back(static_cast<int64_t>(item.number));
        }
        return out;
    }

    /// Returns the nodes of the default scene; without scenes, those without a parent.
    std::vector<int64_t> root_nodes() {
        const JsonMember* nodes = gltf_.root().find("nodes");
        visited_.resize(nodes != nullptr ? nodes->value.items.size() : 0);
        if (const JsonMember* scenes = gltf_.root().find("scenes");
            scenes != nullptr && !scenes->value.items.empty()) {
            const JsonValue* scene =
                gltf_.item("scenes", gltf_.integer(gltf_.root(), "scene", 0), "`scene`");
            return scene != nullptr ? indices_of(*scene, "nodes") : std::vector<int64_t>();
        }
        std::vector<bool> child(visited_.size());
        for (size_t n = 0; n < visited_.size(); ++n) {
            for (int64_t c : indices_of(nodes->value.items[n], "children")) {
                if (static_cast<size_t>(c) < child.size()) child[c] = true;
            }
        }
        std::vector<int64_t> roots;
        for (size_t n = 0; n < child.size(); ++n) {
            if (!child[n]) roots.push_back(static_cast<int64_t>(n));
        }
        return roots;
    }

    bool mark_visited(int64_t index, const JsonValue& node) {
        if (visited_[index]) {
            gltf_.fail(node, fmt::format("node {} has two parents", index), "nodes must be a tree");
            return false;
        }
        visited_[index] = true;
        return true;
    }

    Affine3d transform_of(const JsonValue& node) {
        Affine3d out;
        if (const auto m = gltf_.numbers(node, "matrix", 16)) {
            const auto& v = *m;  // by columns
            return {{v[0], v[4], v[8], v[1], v[5], v[9], v[2], v[6], v[10]}, {v[12], v[13], v[14]}};
        }
        if (const auto q = gltf_.numbers(node, "rotation", 4)) {
            const double x = (*q)[0], y = (*q)[1], z = (*q)[2], w = (*q)[3];
            const double s = x * x + y * y + z * z + w * w;
            const double k = s > 0 ? 2 / s : 0;
            out.m = {1 - k * (y * y + z * z), k * (x * y - z * w),     k * (x * z + y * w),
                     k * (x * y + z * w),     1 - k * (x * x + z * z), k * (y * z - x * w),
                     k * (x * z - y * w),     k * (y * z + x * w),     1 - k * (x * x + y * y)};
        }
        if (const auto s = gltf_.numbers(node, "scale", 3)) {
            for (size_t i = 0; i < 9; ++i)
                out.m[i] = out.m[i] * (*s)[i % 3];
        }
        if (const auto t = gltf_.numbers(node, "translation", 3))
            out.t = {(*t)[0], (*t)[1], (*t)[2]};
        return out;
    }

    void add_node(const JsonValue& node, const Affine3d& transform) {
        if (node.find("mesh") == nullptr || !gltf_.ok()) return;
        skins_ = skins_ || node.find("skin") != nullptr;
        const JsonValue* mesh = gltf_.item("meshes", gltf_.integer(node, "mesh", 0), "a node");
        if (mesh == nullptr) return;
        const JsonMember* primitives = mesh->find("primitives");
        if (primitives == nullptr) return gltf_.fail(*mesh, "the mesh has no `primitives`");
        FaceGroup group;
        std::string name = name_of(node);
        if (name.empty()) name = name_of(*mesh);
        if (!name.empty()) group.names.push_back(name);
        mesh_.begin_part();
        if (mesh_.group_bytes() > gltf_.memory_left())
            return gltf_.fail(node,
                              "the names of nodes and materials take more memory than is allowed",
                              "allow more with `--memory`");
        for (const JsonValue& primitive : primitives->value.items) {
            group.material = material_of(primitive);
            if (gltf_.ok()) add_primitive(primitive, transform, mesh_.group_index(group));
        }
    }

    /// Each node that repeats a mesh adds it again.
    std::string name_of(const JsonValue& thing) {
        constexpr size_t kLongest = 1000;
        std::string name = GltfFile::text(thing, "name");
        if (name.size() <= kLongest) return name;
        gltf_.fail(thing, fmt::format("a name of {} bytes; at most {} are possible", name.size(),
                                      kLongest));
        return {};
    }

    std::string material_of(const JsonValue& primitive) {
        if (primitive.find("material") == nullptr) return {};
        const int64_t index = gltf_.integer(primitive, "material", 0);
        const JsonValue* material = gltf_.item("materials", index, "a mesh");
        if (material == nullptr) return {};
        const std::string name = name_of(*material);
        return name.empty() ? fmt::format("material {}", index) : name;
    }

    /// An attribute of the current primitive, with its values added to the mesh.
    struct Source {
        size_t attribute;
        std::vector<int32_t> value_of_vertex;
    };

    void add_primitive(const JsonValue& primitive, const Affine3d& transform, int32_t group) {
        const int64_t mode = gltf_.integer(primitive, "mode", 4, 6);
        morphs_ = morphs_ || primitive.find("targets") != nullptr;
        if (mode < 4) {
            points_or_lines_ = true;
            return;
        }
        const JsonMember* attributes = primitive.find("attributes");
        if (attributes == nullptr || attributes->value.find("POSITION") == nullptr)
            return gltf_.fail(primitive, "the primitive has no POSITION");
        const std::optional<GltfArray> positions = array_of(attributes->value, "POSITION", 3);
        if (!positions) return;
        const std::vector<int64_t> corners = corners_of(primitive, *positions);
        if (!gltf_.ok()) return;
        const auto first = static_cast<int32_t>(mesh_.vertices());
        for (size_t v = 0; v < positions->count(); ++v) {
            const double* p = &positions->values[v * 3];
            const Vec3d placed = transform.apply({p[0], p[1], p[2]});
            if (!is_position(placed.x, placed.y, placed.z))
                return gltf_.fail(primitive,
                                  fmt::format("vertex {} is not finite or too far away", v));
            mesh_.add_vertex(placed);
        }
        std::vector<Source> sources;
        for (const JsonMember& m : attributes->value.members)
            add_attribute(m, attributes->value, transform, positions->count(), &sources);
        if (gltf_.ok())
            add_triangles(corners, mode, determinant(transform) < 0, first, group, sources);
    }

    std::optional<GltfArray> array_of(const JsonValue& attributes, const char* key,
                                      size_t components) {
        Result<GltfArray> array = gltf_.array(gltf_.integer(attributes, key, 0), false);
        if (!array || !gltf_.ok()) return {};
        if (components != 0 && array->components != components) {
            gltf_.fail(attributes, fmt::format("{} has {} components", key, array->components),
                       fmt::format("it must have {}", components));
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
        const Result<GltfArray> indices = gltf_.array(gltf_.integer(primitive, "indices", 0), true);
        if (!indices || !gltf_.ok()) return {};
        for (double index : indices->values) {
            if (index >= static_cast<double>(positions.count())) {
                gltf_.fail(primitive, fmt::format("an index refers to vertex {}, but there are {}",
                                                  index, positions.count()));
                return {};
            }
            corners.push_back(static_cast<int64_t>(index));
        }
        return corners;
    }

    void add_attribute(const JsonMember& member, const JsonValue& attributes,
                       const Affine3d& transform, size_t vertices, std::vector<Source>* sources) {
        const std::string name = attribute_name(member.key);
        if (name.empty() || !gltf_.ok()) return;
        const bool is_normal = name == "n";
        const bool is_uv = name.starts_with("uv") && member.key[0] == 'T';
        const std::optional<GltfArray> array = array_of(attributes, member.key.c_str(),
                                                        is_normal ? 3
                                                        : is_uv   ? 2
                                                                  : 0);
        if (!array) return;
        if (array->count() != vertices)
            return gltf_.fail(member.value, fmt::format("{} has {} values for {} vertices",
                                                        member.key, array->count(), vertices));
        const bool is_color = name == "color" && member.key[0] == 'C';
        const size_t kept = is_color ? 3 : array->components;
        if (kept > array->components)
            return gltf_.fail(member.value, "COLOR_0 must have 3 or 4 components");
        const std::optional<size_t> attribute = mesh_.attribute(name, static_cast<int32_t>(kept));
        if (!attribute) {
            if (mesh_.warnings().size() < kMaxWarnings)
                mesh_.warnings().push_back(fmt::format(
                    "{}:{}:{}: `{}` has another number of components elsewhere, or is one "
                    "too many; left "
                    "out here",
                    name_, member.line, member.column, member.key.substr(0, 40)));
            return;
        }
        const Affine3d turn = cofactors(transform);
        const double side = determinant(transform) < 0 ? -1 : 1;
        Source source{*attribute, {}};
        for (size_t v = 0; v < vertices; ++v) {
            std::array<double, 4> value{};
            for (size_t c = 0; c < kept; ++c)
                value[c] = array->values[v * array->components + c];
            if (is_uv) value[1] = 1 - value[1];
            if (is_normal) {
                const Vec3d n = turn.apply_vector({value[0], value[1], value[2]}) * side;
                const double scale = length(n) > 0 ? 1 / length(n) : 0;
                value = {n.x * scale, n.y * scale, n.z * scale, 0};
            }
            source.value_of_vertex.push_back(mesh_.add_value(*attribute, value.data()));
        }
        sources->push_back(std::move(source));
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

    void warn_of_what_is_left_out() {
        const auto warn = [&](bool left_out, const char* what) {
            if (left_out) mesh_.warnings().push_back(fmt::format("{}: {}", name_, what));
        };
        warn(points_or_lines_, "points and lines are left out; they have no volume");
        warn(skins_, "the skin is not applied; the mesh is as it was modelled");
        warn(morphs_, "morph targets are not applied");
    }

    GltfFile gltf_;
    std::string name_;
    MeshAssembly mesh_;
    std::vector<bool> visited_;
    MeshCounts counts_;            ///< of all nodes
    std::set<std::string> names_;  ///< of attributes
    int64_t primitives_ = 0;
    int64_t largest_ = 0;  ///< bytes beside the mesh while a primitive is read
    bool points_or_lines_ = false;
    bool skins_ = false;
    bool morphs_ = false;
};

}  // namespace

Result<MeshSource> parse_gltf(std::string_view bytes, const std::string& file,
                              int64_t memory_bytes) {
    Result<GltfFile> gltf = GltfFile::open(bytes, file, memory_bytes);
    if (!gltf) return gltf.error();
    return GltfReader(std::move(*gltf), file).read();
}

}  // namespace openfab::mesh

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/gltf_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/affine.h"
#include "mesh/read/messages.h"

namespace openfab::mesh {
namespace {

using Kind = JsonValue::Kind;

/// y up, z to the viewer -> z up, y away.
constexpr Affine3d kZUp{{1, 0, 0, 0, 0, -1, 0, 1, 0}, {}};
constexpr char kInstancing[] = "EXT_mesh_gpu_instancing";
constexpr const char* kInstanceKeys[] = {"TRANSLATION", "ROTATION", "SCALE"};

Affine3d rotation_of(double x, double y, double z, double w) {
    const double s = x * x + y * y + z * z + w * w;
    const double k = s > 0 ? 2 / s : 0;
    return {{1 - k * (y * y + z * z), k * (x * y - z * w), k * (x * z + y * w), k * (x * y + z * w),
             1 - k * (x * x + z * z), k * (y * z - x * w), k * (x * z - y * w), k * (y * z + x * w),
             1 - k * (x * x + y * y)},
            {}};
}

void scale_axes(double x, double y, double z, Affine3d* out) {
    const double scales[] = {x, y, z};
    for (size_t i = 0; i < 9; ++i)
        out->m[i] *= scales[i % 3];
}

/// Walks the nodes of a scene.
class Scene {
  public:
    Scene(GltfFile* gltf, MeshAssembly* mesh) : gltf_(*gltf), mesh_(*mesh) {}

    GltfScene read() {
        const std::vector<int64_t> roots = root_nodes();
        for (size_t r = 0; r < roots.size() && gltf_.ok(); ++r)
            stack_.push_back({roots[r], kZUp, static_cast<int32_t>(r)});
        std::reverse(stack_.begin(), stack_.end());
        while (!stack_.empty() && gltf_.ok()) {
            const Visit visit = stack_.back();
            stack_.pop_back();
            use(visit);
        }
        return std::move(out_);
    }

  private:
    struct Visit {
        int64_t node;
        Affine3d transform;
        int32_t assembly;
    };

    void use(const Visit& visit) {
        const JsonValue* node = gltf_.item("nodes", visit.node, messages::kASceneOrNode);
        if (node == nullptr || !mark_visited(visit.node, *node)) return;
        const JsonValue* visible =
            gltf_member(gltf_extension(node, "KHR_node_visibility"), "visible");
        if (visible != nullptr && visible->is(Kind::kBool) && !visible->boolean)
            return mesh_.leave_out(messages::kHiddenNode, gltf_.place_of("node", *node),
                                   messages::kHiddenNodeHelp);
        const Affine3d transform = product(visit.transform, transform_of(*node));
        out_.transforms[static_cast<size_t>(visit.node)] = transform;
        if (node->find("mesh") != nullptr) place(*node, transform, visit.assembly);
        const std::vector<int64_t> children = indices_of(*node, "children");
        for (size_t i = children.size(); i-- > 0;)
            stack_.push_back({children[i], transform, visit.assembly});
    }

    void place(const JsonValue& node, const Affine3d& transform, int32_t assembly) {
        // A skin places its mesh by its skeleton.
        if (determinant(transform) == 0 && node.find("skin") == nullptr)
            return mesh_.leave_out(messages::kMeshScaledToNothing, gltf_.place_of("node", node),
                                   messages::kScaledToNothingHelp);
        GltfPlacement placement{&node, transform, assembly, 1};
        if (const JsonValue* instancing = gltf_extension(&node, kInstancing)) {
            const JsonValue* attributes = gltf_member(instancing, "attributes");
            std::optional<int64_t> most;
            for (const char* key : kInstanceKeys) {
                if (gltf_member(attributes, key) == nullptr) continue;
                most = std::max(most.value_or(0), gltf_stated_count(gltf_, attributes, key));
            }
            placement.instances = most.value_or(1);
            tell_of_instances(node, attributes);
        }
        if (gltf_.take_memory(3 * sizeof placement, node)) out_.placements.push_back(placement);
    }

    void tell_of_instances(const JsonValue& node, const JsonValue* attributes) {
        if (attributes == nullptr) return;
        for (const JsonMember& m : attributes->members) {
            if (std::find(std::begin(kInstanceKeys), std::end(kInstanceKeys), m.key) !=
                std::end(kInstanceKeys))
                continue;
            mesh_.leave_out(fmt::format(messages::kAttributeOfInstances, m.key.substr(0, 40)),
                            gltf_.place_of("node", node), messages::kAttributeOfInstancesHelp);
        }
    }

    std::vector<int64_t> indices_of(const JsonValue& object, const char* key) {
        std::vector<int64_t> out;
        const JsonMember* list = object.find(key);
        if (list == nullptr) return out;
        for (const JsonValue& item : list->value.items) {
            if (!item.is(Kind::kNumber) || !(item.number >= 0 && item.number < 1e9) ||
                item.number != std::floor(item.number)) {
                gltf_.fail(item, fmt::format(messages::kNotIndices, key));
                return {};
            }
            out.push_back(static_cast<int64_t>(item.number));
        }
        return out;
    }

    std::vector<int64_t> root_nodes() {
        const JsonValue* nodes = gltf_member(&gltf_.root(), "nodes");
        visited_.resize(nodes != nullptr ? nodes->items.size() : 0);
        constexpr size_t kNode = sizeof(std::optional<Affine3d>) + 1;
        if (!gltf_.take_memory(visited_.size() * kNode, gltf_.root())) return {};
        out_.transforms.resize(visited_.size());
        const JsonValue* scenes = gltf_member(&gltf_.root(), "scenes");
        if (scenes != nullptr && !scenes->items.empty()) {
            const JsonValue* scene =
                gltf_.item("scenes", gltf_.integer(gltf_.root(), "scene", 0), "`scene`");
            return scene != nullptr ? indices_of(*scene, "nodes") : std::vector<int64_t>();
        }
        std::vector<bool> child(visited_.size());
        for (size_t n = 0; n < visited_.size(); ++n) {
            for (int64_t c : indices_of(nodes->items[n], "children")) {
                if (static_cast<size_t>(c) < child.size()) child[static_cast<size_t>(c)] = true;
            }
        }
        std::vector<int64_t> roots;
        for (size_t n = 0; n < child.size(); ++n) {
            if (!child[n]) roots.push_back(static_cast<int64_t>(n));
        }
        return roots;
    }

    bool mark_visited(int64_t index, const JsonValue& node) {
        const auto at = static_cast<size_t>(index);
        if (visited_[at]) {
            gltf_.fail(node, fmt::format(messages::kNodeTwoParents, index),
                       messages::kNodeTwoParentsHelp);
            return false;
        }
        visited_[at] = true;
        return true;
    }

    Affine3d transform_of(const JsonValue& node) {
        Affine3d out;
        if (const auto m = gltf_.numbers(node, "matrix", 16)) return gltf_matrix(m->data());
        if (const auto q = gltf_.numbers(node, "rotation", 4))
            out = rotation_of((*q)[0], (*q)[1], (*q)[2], (*q)[3]);
        if (const auto s = gltf_.numbers(node, "scale", 3))
            scale_axes((*s)[0], (*s)[1], (*s)[2], &out);
        if (const auto t = gltf_.numbers(node, "translation", 3))
            out.t = {(*t)[0], (*t)[1], (*t)[2]};
        return out;
    }

    GltfFile& gltf_;
    MeshAssembly& mesh_;
    std::vector<bool> visited_;
    std::vector<Visit> stack_;
    GltfScene out_;
};

/// Reads an attribute of instances; empty where they do not have it.
std::vector<double> instance_values(GltfFile* gltf, const JsonValue& attributes, const char* key,
                                    size_t components, int64_t instances) {
    if (attributes.find(key) == nullptr) return {};
    Result<GltfArray> array =
        gltf->array(gltf->integer(attributes, key, 0), GltfFile::Use::kNumbers);
    if (!array || !gltf->ok()) return {};
    if (array->components != components || array->count() != static_cast<size_t>(instances)) {
        gltf->fail(
            attributes,
            fmt::format(messages::kValuesOfInstances, key, array->count(), array->components),
            fmt::format(messages::kValuesOfInstancesHelp, instances, components));
        return {};
    }
    return std::move(array->values);
}

}  // namespace

int64_t gltf_stated_count(const GltfFile& gltf, const JsonValue* object,
                          std::string_view accessor) {
    constexpr double kMost = 1LL << 32;
    const auto whole = [](const JsonValue* value) {
        return value != nullptr && value->number >= 0 && value->number <= kMost
                   ? static_cast<int64_t>(value->number)
                   : 0;
    };
    const JsonValue* index = gltf_member(object, accessor);
    const JsonValue* list = gltf_member(&gltf.root(), "accessors");
    const auto at = static_cast<size_t>(whole(index));
    if (index == nullptr || list == nullptr || at >= list->items.size()) return 0;
    return whole(gltf_member(&list->items[at], "count"));
}

GltfScene gltf_scene(GltfFile* gltf, MeshAssembly* mesh) {
    return Scene(gltf, mesh).read();
}

Affine3d gltf_matrix(const double* columns) {
    const double* v = columns;
    return {{v[0], v[4], v[8], v[1], v[5], v[9], v[2], v[6], v[10]}, {v[12], v[13], v[14]}};
}

std::vector<Affine3d> gltf_instances(GltfFile* gltf, const GltfPlacement& placement) {
    const JsonValue* instancing = gltf_extension(placement.node, kInstancing);
    const JsonValue* attributes = gltf_member(instancing, "attributes");
    if (attributes == nullptr) return {placement.transform};
    const auto values = [&](const char* key, size_t components) {
        return instance_values(gltf, *attributes, key, components, placement.instances);
    };
    const std::vector<double> moves = values("TRANSLATION", 3), turns = values("ROTATION", 4),
                              scales = values("SCALE", 3);
    std::vector<Affine3d> out;
    if (!gltf->ok()) return out;
    for (size_t i = 0; i < static_cast<size_t>(placement.instances); ++i) {
        Affine3d local;
        if (!turns.empty()) {
            const double* q = &turns[i * 4];
            local = rotation_of(q[0], q[1], q[2], q[3]);
        }
        if (!scales.empty())
            scale_axes(scales[i * 3], scales[i * 3 + 1], scales[i * 3 + 2], &local);
        if (!moves.empty()) local.t = {moves[i * 3], moves[i * 3 + 1], moves[i * 3 + 2]};
        out.push_back(product(placement.transform, local));
    }
    return out;
}

}  // namespace openfab::mesh

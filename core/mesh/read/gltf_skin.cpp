// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/gltf_skin.h"

#include <fmt/format.h>

#include <cmath>

#include "base/affine.h"
#include "mesh/read/messages.h"

namespace openfab::mesh {
namespace {

void add_share(const Affine3d& of, double share, Affine3d* out) {
    for (size_t i = 0; i < 9; ++i)
        out->m[i] += share * of.m[i];
    out->t = out->t + of.t * share;
}

}  // namespace

std::vector<Affine3d> gltf_joints(GltfFile* gltf, const GltfScene& scene,
                                  const GltfPlacement& placement) {
    const JsonValue& node = *placement.node;
    if (node.find("skin") == nullptr) return {};
    const JsonValue* skin = gltf->item("skins", gltf->integer(node, "skin", 0), "a node");
    const JsonValue* joints = gltf_member(skin, "joints");
    if (joints == nullptr) return {};
    std::vector<double> to_joints;
    if (skin->find("inverseBindMatrices") != nullptr) {
        Result<GltfArray> read =
            gltf->array(gltf->integer(*skin, "inverseBindMatrices", 0), GltfFile::Use::kMatrices);
        if (!read || !gltf->ok()) return {};
        to_joints = std::move(read->values);
        if (to_joints.size() / 16 < joints->items.size()) {
            gltf->fail(*skin, fmt::format(messages::kSkinMatrices, joints->items.size(),
                                          to_joints.size() / 16));
            return {};
        }
    }
    std::vector<Affine3d> out;
    for (size_t j = 0; j < joints->items.size(); ++j) {
        const double index = joints->items[j].number;
        const bool is_node = index >= 0 && index < static_cast<double>(scene.transforms.size());
        const std::optional<Affine3d> pose =
            is_node ? scene.transforms[static_cast<size_t>(index)] : std::nullopt;
        if (!pose) return {};
        const double* m = to_joints.empty() ? nullptr : &to_joints[j * 16];
        out.push_back(m == nullptr ? *pose : product(*pose, gltf_matrix(m)));
    }
    return out;
}

Result<GltfSkinning> GltfSkinning::read(GltfFile* gltf, const JsonValue& primitive, size_t vertices,
                                        const std::vector<Affine3d>& joints,
                                        const Affine3d& transform) {
    GltfSkinning out;
    out.transform_ = transform;
    out.mirrors_ = determinant(transform) < 0;
    const JsonValue* attributes = gltf_member(&primitive, "attributes");
    for (int set = 0; set < kMaxJointSets && !joints.empty(); ++set) {
        const std::string followed = fmt::format("JOINTS_{}", set);
        const std::string shares = fmt::format("WEIGHTS_{}", set);
        if (gltf_member(attributes, followed) == nullptr ||
            gltf_member(attributes, shares) == nullptr)
            break;
        Result<GltfArray> of =
            gltf->array(gltf->integer(*attributes, followed.c_str(), 0), GltfFile::Use::kNumbers);
        if (!of) return of.error();
        Result<GltfArray> by =
            gltf->array(gltf->integer(*attributes, shares.c_str(), 0), GltfFile::Use::kShares);
        if (!by) return by.error();
        if (!gltf->ok()) return gltf->error();
        for (const GltfArray* array : {&*of, &*by}) {
            if (array->components == 4 && array->count() == vertices) continue;
            gltf->fail(*attributes, fmt::format(messages::kJointValues, followed, shares,
                                                array->count(), array->components, vertices));
            return gltf->error();
        }
        for (const double joint : of->values) {
            if (joint >= 0 && joint < static_cast<double>(joints.size())) continue;
            gltf->fail(*attributes,
                       fmt::format(messages::kRefersToNoJoint, followed, joint, joints.size()));
            return gltf->error();
        }
        out.followed_.push_back(std::move(*of));
        out.shares_.push_back(std::move(*by));
    }
    if (out.followed_.empty()) return out;
    // The skeleton places the mesh, and its own node does not.
    out.joints_ = &joints;
    out.mirrors_ = determinant(joints[0]) < 0;
    return out;
}

Affine3d GltfSkinning::blended(size_t v) const {
    Affine3d out{{}, {}};
    double sum = 0;
    for (size_t set = 0; set < followed_.size(); ++set) {
        for (size_t k = 0; k < 4; ++k) {
            const double share = shares_[set].values[v * 4 + k];
            if (!(share > 0)) continue;
            const auto joint = static_cast<size_t>(followed_[set].values[v * 4 + k]);
            add_share((*joints_)[joint], share, &out);
            sum += share;
        }
    }
    if (!(sum > 0)) return (*joints_)[0];
    for (double& m : out.m)
        m /= sum;
    out.t = out.t * (1 / sum);
    return out;
}

}  // namespace openfab::mesh

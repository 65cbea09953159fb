// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The attributes of stages, `attr.voxelCenter`: which there are.
#include "compiler/check/attributes.h"

#include <fmt/format.h>

#include "compiler/check/uses.h"

namespace openfab::check {

namespace {

struct AttributeInfo {
    std::string_view name;
    Attribute id;
    Type type;
    unsigned of;  ///< the stages that have it
};
constexpr unsigned kOfSurface = 1, kOfVolume = 2, kOfDither = 4, kOfShape = 8, kOfGrow = 16;
constexpr AttributeInfo kAttributes[] = {
    {"p", Attribute::kP, kFloat3Type, kOfSurface | kOfShape},
    {"n", Attribute::kN, kFloat3Type, kOfSurface},
    {"ng", Attribute::kNg, kFloat3Type, kOfSurface},
    {"uv", Attribute::kUv, {Base::kFloat, 2}, kOfSurface},
    {"dpdu", Attribute::kDpdu, kFloat3Type, kOfSurface},
    {"dpdv", Attribute::kDpdv, kFloat3Type, kOfSurface},
    {"voxelCenter", Attribute::kVoxelCenter, kFloat3Type, kOfVolume},
    {"voxelSize", Attribute::kVoxelSize, kFloat3Type, kOfVolume | kOfDither},
    {"buildPosition", Attribute::kBuildPosition, kFloat3Type, kOfVolume},
    {"instance", Attribute::kInstance, kIntType, kOfSurface | kOfVolume},
    {"voxel", Attribute::kVoxel, {Base::kInt, 3}, kOfDither},
    {"seed", Attribute::kSeed, kUintType, kOfDither},
    {"count", Attribute::kCount, kIntType, kOfDither},
    {"child", Attribute::kChild, kIntType, kOfGrow},
    {"level", Attribute::kLevel, kIntType, kOfGrow},
    {"path", Attribute::kPath, kUintType, kOfGrow},
};

unsigned stage_of(const Type& attributes) {
    if (attributes.is(Base::kSurfaceAttributes)) return kOfSurface;
    if (attributes.is(Base::kShapeAttributes)) return kOfShape;
    if (attributes.is(Base::kGrowAttributes)) return kOfGrow;
    return attributes.is(Base::kVolumeAttributes) ? kOfVolume : kOfDither;
}

}  // namespace

std::vector<StructMember> attribute_members(const Type& attributes) {
    std::vector<StructMember> out;
    for (const AttributeInfo& info : kAttributes) {
        if ((info.of & stage_of(attributes)) != 0)
            out.push_back({std::string(info.name), info.type, {}});
    }
    return out;
}

std::optional<Attribute> find_attribute(std::string_view name, const Type& attributes, Type* type) {
    for (const AttributeInfo& info : kAttributes) {
        if (info.name != name || (info.of & stage_of(attributes)) == 0) continue;
        *type = info.type;
        return info.id;
    }
    return std::nullopt;
}

}  // namespace openfab::check

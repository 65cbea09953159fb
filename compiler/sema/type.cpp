// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/sema/type.h"

#include <fmt/format.h>

#include <vector>

#include "compiler/diag/suggest.h"

namespace openfab::sema {

namespace {

struct Named {
    std::string_view name;
    Base base;
};
constexpr Named kNumeric[] = {
    {"bool", Base::kBool}, {"int", Base::kInt}, {"uint", Base::kUint}, {"float", Base::kFloat}};
constexpr Named kOther[] = {
    {"void", Base::kVoid},
    {"ImageTexture2D", Base::kTexture2D},
    {"Material", Base::kMaterial},
    {"MaterialComposition", Base::kComposition},
    {"SurfaceAttributes", Base::kSurfaceAttributes},
    {"VolumeAttributes", Base::kVolumeAttributes},
};

struct Text {
    std::string_view name;
    std::string_view text;
};
constexpr Text kUnsupported[] = {
    {"ImageTexture3D", "`ImageTexture3D` is"},
    {"Object", "`Object` is"},
    {"SurfacePoint", "`SurfacePoint` is"},
};
// Words for types in other languages.
constexpr Text kHabits[] = {
    {"vec2", "float2"},
    {"vec3", "float3"},
    {"vec4", "float4"},
    {"ivec2", "int2"},
    {"ivec3", "int3"},
    {"ivec4", "int4"},
    {"uvec2", "uint2"},
    {"uvec3", "uint3"},
    {"uvec4", "uint4"},
    {"bvec2", "bool2"},
    {"bvec3", "bool3"},
    {"bvec4", "bool4"},
    {"mat2", "float2x2"},
    {"mat3", "float3x3"},
    {"mat4", "float4x4"},
    {"Texture2D", "ImageTexture2D"},
    {"Texture3D", "ImageTexture3D"},
    {"sampler2D", "ImageTexture2D"},
    {"sampler3D", "ImageTexture3D"},
    {"double", "float"},
    {"half", "float"},
    {"color", "float3"},
    {"point", "float3"},
    {"vector", "float3"},
    {"normal", "float3"},
    {"unsigned", "uint"},
    {"string", ""},
    {"auto", ""},
    {"var", ""},
};

std::string nearest_name(std::string_view name) {
    std::vector<std::string> candidates;
    for (const Named& n : kNumeric) {
        candidates.emplace_back(n.name);
        for (char side : {'2', '3', '4'})
            candidates.push_back(std::string(n.name) + side);
    }
    for (const Named& n : kOther)
        candidates.emplace_back(n.name);
    for (const Text& t : kUnsupported)
        candidates.emplace_back(t.name);
    return diag::suggest(name, candidates);
}

}  // namespace

std::string type_name(const Type& type) {
    for (const Named& n : kNumeric) {
        if (n.base != type.base) continue;
        return type.size == 1 ? std::string(n.name) : fmt::format("{}{}", n.name, type.size);
    }
    for (const Named& n : kOther) {
        if (n.base == type.base) return std::string(n.name);
    }
    return "?";
}

ir::Type component_type(const Type& type) {
    switch (type.base) {
        case Base::kBool:
            return ir::Type::kBool;
        case Base::kUint:
            return ir::Type::kUint;
        case Base::kFloat:
        case Base::kComposition:
            return ir::Type::kFloat;
        default:
            return ir::Type::kInt;  // a Material or texture is its index
    }
}

TypeLookup find_type(std::string_view name) {
    for (const Named& n : kNumeric) {
        if (name.substr(0, n.name.size()) != n.name) continue;
        const std::string_view rest = name.substr(n.name.size());
        if (rest.empty()) return {{n.base, 1}, "", ""};
        if (rest.size() == 1 && rest[0] >= '2' && rest[0] <= '4')
            return {{n.base, rest[0] - '0'}, "", ""};
        const auto side = [](char c) { return c >= '1' && c <= '4'; };
        if (rest.size() == 3 && side(rest[0]) && rest[1] == 'x' && side(rest[2])) {
            return {{}, "matrices are", ""};
        }
    }
    for (const Named& n : kOther) {
        if (n.name == name) return {{n.base, 1}, "", ""};
    }
    for (const Text& t : kUnsupported) {
        if (t.name == name) return {{}, t.text, ""};
    }
    for (const Text& t : kHabits) {
        if (t.name != name) continue;
        return {{}, "", t.text.empty() ? "" : fmt::format("write `{}`", t.text)};
    }
    const std::string near = nearest_name(name);
    return {{}, "", near.empty() ? "" : fmt::format("did you mean `{}`?", near)};
}

}  // namespace openfab::sema

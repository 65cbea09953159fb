// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/type.h"

#include <fmt/format.h>

#include "abi/curve_table.h"

namespace openfab::check {

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
    {"ImageTexture3D", Base::kTexture3D},
    {"Material", Base::kMaterial},
    {"Object", Base::kObject},
    {"Spline", Base::kSpline},
    {"ColorRamp", Base::kColorRamp},
    {"MaterialComposition", Base::kComposition},
    {"SurfaceAttributes", Base::kSurfaceAttributes},
    {"VolumeAttributes", Base::kVolumeAttributes},
    {"DitherAttributes", Base::kDitherAttributes},
    {"ShapeAttributes", Base::kShapeAttributes},
    {"GrowAttributes", Base::kGrowAttributes},
    {"SurfacePoint", Base::kSurfacePoint},
};

bool is_matrix_side(char c) {
    return c >= '2' && c <= '4';
}

}  // namespace

int Type::length() const {
    if (is_array()) return extents[0];
    return is_matrix() ? rows : size;
}

Type Type::element() const {
    Type out = *this;
    if (is_array()) {
        --out.dimensions;
        for (size_t i = 0; i + 1 < out.extents.size(); ++i)
            out.extents[i] = extents[i + 1];
        out.extents.back() = 0;
    } else if (is_matrix()) {
        out.rows = 0;
    } else {
        out.size = 1;
    }
    return out;
}

Type array_of(const Type& element, int extent) {
    Type out = element;
    for (size_t i = out.extents.size() - 1; i > 0; --i)
        out.extents[i] = element.extents[i - 1];
    out.extents[0] = extent;
    ++out.dimensions;
    return out;
}

std::string type_name(const Type& type) {
    std::string out = "?";
    for (const Named& n : kNumeric) {
        if (n.base != type.base) continue;
        out = n.name;
        if (type.rows > 0) {
            out += fmt::format("{}x{}", type.rows, type.size);
        } else if (type.size > 1) {
            out += fmt::format("{}", type.size);
        }
    }
    for (const Named& n : kOther) {
        if (n.base == type.base) out = n.name;
    }
    if (type.base == Base::kStruct && type.record != nullptr) out = type.record->name;
    for (int i = 0; i < type.dimensions; ++i)
        out += fmt::format("[{}]", type.extents[i]);
    return out;
}

ir::Type component_type(const Type& type) {
    switch (type.base) {
        case Base::kBool:
            return ir::Type::kBool;
        case Base::kUint:
            return ir::Type::kUint;
        case Base::kFloat:
        case Base::kSpline:
        case Base::kColorRamp:
        case Base::kComposition:
            return ir::Type::kFloat;
        case Base::kInt:
        case Base::kMaterial:
        case Base::kTexture2D:
        case Base::kTexture3D:
        case Base::kObject:  // of what the world has, the index
        case Base::kError:   // from here on: they have no components of one type
        case Base::kVoid:
        case Base::kSurfaceAttributes:
        case Base::kVolumeAttributes:
        case Base::kDitherAttributes:
        case Base::kShapeAttributes:
        case Base::kGrowAttributes:
        case Base::kSurfacePoint:
        case Base::kStruct:
            return ir::Type::kInt;
    }
    return ir::Type::kInt;
}

bool contains(const Type& type, Base base) {
    if (type.base == base) return true;
    if (type.base != Base::kStruct || type.record == nullptr) return false;
    for (const StructMember& member : type.record->members) {
        if (contains(member.type, base)) return true;
    }
    return false;
}

int64_t min_components(const Type& type, int64_t composition) {
    int64_t count = type.is_error() || type.base == Base::kVoid ? 0 : 1;
    if (is_number(type.base)) {
        count = type.rows > 0 ? type.matrix_components() : type.size;
    } else if (type.base == Base::kStruct) {
        count = 0;
        for (const StructMember& member : type.record->members)
            count += min_components(member.type, composition);
    } else if (type.base == Base::kSpline || type.base == Base::kColorRamp) {
        count = abi::curve_size(curve_channels(type));
    } else if (type.base == Base::kComposition) {
        count = composition;
    }
    for (int i = 0; i < type.dimensions; ++i)
        count *= type.extents[i];
    return count;
}

std::vector<std::string> type_names() {
    std::vector<std::string> out;
    for (const Named& n : kNumeric) {
        out.emplace_back(n.name);
        for (char side : {'2', '3', '4'})
            out.push_back(std::string(n.name) + side);
    }
    for (const char* matrix : {"float2x2", "float3x3", "float4x4"})
        out.emplace_back(matrix);
    for (const Named& n : kOther)
        out.emplace_back(n.name);
    return out;
}

Type find_type(std::string_view name) {
    for (const Named& n : kNumeric) {
        if (name.substr(0, n.name.size()) != n.name) continue;
        const std::string_view rest = name.substr(n.name.size());
        if (rest.empty()) return {n.base, 1};
        if (rest.size() == 1 && is_matrix_side(rest[0])) return {n.base, rest[0] - '0'};
        if (rest.size() != 3 || rest[1] != 'x') continue;
        if (n.base == Base::kFloat && is_matrix_side(rest[0]) && is_matrix_side(rest[2])) {
            return {n.base, rest[2] - '0', rest[0] - '0'};
        }
        return {};
    }
    for (const Named& n : kOther) {
        if (n.name == name) return {n.base, 1};
    }
    return {};
}

}  // namespace openfab::check

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The types of values, and the type names of OpenFL.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::check {

enum class Base : uint8_t {
    kError,  ///< poisoned: an error was reported, no further ones are
    kVoid,
    kBool,
    kInt,
    kUint,
    kFloat,
    kTexture2D,
    kTexture3D,
    kMaterial,
    kObject,
    kSpline,
    kColorRamp,
    kComposition,
    kSurfaceAttributes,
    kVolumeAttributes,
    kDitherAttributes,
    kShapeAttributes,
    kGrowAttributes,
    kSurfacePoint,
    kStruct,
};

/// True for what numbers are made of, in the order in which they convert to each other.
constexpr bool is_number(Base base) {
    return base >= Base::kBool && base <= Base::kFloat;
}

struct StructType;

/// The most dimensions of an array, and the most components of any value.
constexpr int kMaxDimensions = 4;
constexpr int kMaxComponents = 16384;

/// A scalar, a vector (`size` 2 to 4), a matrix (`rows` of `size`), a non-numeric type, a struct,
/// or an array of one of them.
struct Type {
    Base base = Base::kError;
    int size = 1;                               ///< components of a vector, columns of a matrix
    int rows = 0;                               ///< of a matrix, else 0
    int dimensions = 0;                         ///< of an array, else 0
    std::array<int, kMaxDimensions> extents{};  ///< of an array, outermost first
    const StructType* record = nullptr;
    bool operator==(const Type&) const = default;

    bool is_error() const { return base == Base::kError; }
    bool is_array() const { return dimensions > 0; }
    /// True for a `base`, not for an array of it.
    bool is(Base which) const { return base == which && dimensions == 0; }
    /// True for a scalar or a vector.
    bool is_numeric() const { return is_arithmetic() && rows == 0; }
    bool is_matrix() const { return is_arithmetic() && rows > 0; }
    bool is_arithmetic() const { return is_number(base) && dimensions == 0; }
    bool is_integer() const { return is_numeric() && (base == Base::kInt || base == Base::kUint); }
    bool is_scalar() const { return is_numeric() && size == 1; }
    bool is_vector() const { return is_numeric() && size > 1; }
    bool is_attributes() const {
        return is(Base::kSurfaceAttributes) || is(Base::kVolumeAttributes) ||
               is(Base::kDitherAttributes) || is(Base::kShapeAttributes) ||
               is(Base::kGrowAttributes);
    }
    /// True for types that refer to things of the world and cannot be computed.
    bool is_handle() const {
        return is(Base::kTexture2D) || is(Base::kTexture3D) || is(Base::kObject);
    }
    /// True for types of curves, which the world gives by keys.
    bool is_curve() const { return is(Base::kSpline) || is(Base::kColorRamp); }
    int matrix_components() const { return rows * size; }
    /// The number of elements `[i]` of an array, matrix or vector, and the type of each.
    int length() const;
    Type element() const;
};

struct StructMember {
    std::string name;
    Type type;
    source::Span span;
};

struct StructType {
    std::string name;
    source::Span span;
    std::vector<StructMember> members;
};

constexpr Type kErrorType{};
constexpr Type kVoidType{Base::kVoid, 1};
constexpr Type kBoolType{Base::kBool, 1};
constexpr Type kIntType{Base::kInt, 1};
constexpr Type kUintType{Base::kUint, 1};
constexpr Type kFloatType{Base::kFloat, 1};
constexpr Type kFloat3Type{Base::kFloat, 3};

/// Returns the type of an array of `extent` elements.
Type array_of(const Type& element, int extent);

/// Returns a type as written in OpenFL: `float3`, `Material`, `float2x2[4]`.
std::string type_name(const Type& type);

/// Returns the IR type of each component; not for structs and arrays of them.
ir::Type component_type(const Type& type);

/// True if a type is a `base` or has one in an element or a member.
bool contains(const Type& type, Base base);

/// Returns the components of a value: `composition` for each composition; 1 for a surface point,
/// whose number only the fablet knows.
int64_t min_components(const Type& type, int64_t composition = 1);

/// Returns the numbers that a curve gives.
constexpr int curve_channels(const Type& curve) {
    return curve.base == Base::kColorRamp ? 3 : 1;
}

/// Returns the built-in type of a name; kErrorType if there is none.
Type find_type(std::string_view name);

/// Returns the names of all built-in types.
std::vector<std::string> type_names();

}  // namespace openfab::check

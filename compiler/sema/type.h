// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The types that a value can have, and what each type name of OpenFL stands for.

#include <cstdint>
#include <string>
#include <string_view>

#include "compiler/ir/ir.h"

namespace openfab::sema {

enum class Base : uint8_t {
    kError,  ///< poisoned: an error was reported, nothing more is said
    kVoid,
    kBool,
    kInt,
    kUint,
    kFloat,
    kTexture2D,
    kMaterial,
    kComposition,
    kSurfaceAttributes,
    kVolumeAttributes,
};

/// `size` is 1 for a scalar and 2 to 4 for a vector; 1 for what is no number.
struct Type {
    Base base = Base::kError;
    int size = 1;
    bool operator==(const Type&) const = default;

    bool is_error() const { return base == Base::kError; }
    bool is_numeric() const { return base >= Base::kBool && base <= Base::kFloat; }
    bool is_integer() const { return base == Base::kInt || base == Base::kUint; }
    bool is_scalar() const { return is_numeric() && size == 1; }
    bool is_vector() const { return is_numeric() && size > 1; }
};

constexpr Type kErrorType{};
constexpr Type kVoidType{Base::kVoid, 1};
constexpr Type kBoolType{Base::kBool, 1};
constexpr Type kIntType{Base::kInt, 1};
constexpr Type kUintType{Base::kUint, 1};
constexpr Type kFloatType{Base::kFloat, 1};
constexpr Type kFloat3Type{Base::kFloat, 3};

/// `float3`, `Material`: as written in OpenFL.
std::string type_name(const Type& type);

/// IR type of one component; for numbers only.
ir::Type component_type(const Type& type);

/// What a name in the place of a type is.
struct TypeLookup {
    Type type;                     ///< kErrorType unless it is a type of this compiler
    std::string_view unsupported;  ///< `matrices are`: OpenFL has it, this compiler not yet
    std::string help;              ///< what was probably meant, where it is neither
};
TypeLookup find_type(std::string_view name);

}  // namespace openfab::sema

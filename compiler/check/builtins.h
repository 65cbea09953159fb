// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The built-in functions: which exist, and how their arguments are typed.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/check/intrinsics.h"

namespace openfab::check {

enum class Intrinsic : uint8_t {
#define OPENFAB_INTRINSIC_NAME(name, ...) k##name,
    OPENFAB_INTRINSICS(OPENFAB_INTRINSIC_NAME)
#undef OPENFAB_INTRINSIC_NAME
};

/// The families of compiler/check/intrinsics.h.
enum class Family : uint8_t {
    kComponent,
    kGeometric,
    kChoice,
    kElementary,
    kBitwise,
    kSeveral,
    kBending,
    kDerivative,
    kField,
};
constexpr Family family(Intrinsic id) {
    switch (id) {
        OPENFAB_INTRINSIC_CASES(COMPONENT)
        return Family::kComponent;
        OPENFAB_INTRINSIC_CASES(GEOMETRIC)
        return Family::kGeometric;
        OPENFAB_INTRINSIC_CASES(CHOICE)
        return Family::kChoice;
        OPENFAB_INTRINSIC_CASES(ELEMENTARY)
        return Family::kElementary;
        OPENFAB_INTRINSIC_CASES(BITWISE)
        return Family::kBitwise;
        OPENFAB_INTRINSIC_CASES(SEVERAL)
        return Family::kSeveral;
        OPENFAB_INTRINSIC_CASES(BENDING)
        return Family::kBending;
        OPENFAB_INTRINSIC_CASES(DERIVATIVE)
        return Family::kDerivative;
        OPENFAB_INTRINSIC_CASES(FIELD)
        return Family::kField;
    }
    return Family::kComponent;
}

/// How an intrinsic types its arguments and result.
enum class Shape : uint8_t {
    kNumeric,     ///< all arguments to their common type, which is the result
    kFloat,       ///< as kNumeric, with components converted to float
    kToInt,       ///< as kNumeric, result int
    kToBool,      ///< as kFloat, result bool
    kReduceBool,  ///< one argument of any numeric type, result a scalar bool
    kDot,         ///< as kNumeric, result a scalar
    kReduce,      ///< as kFloat, result a scalar
    kFloat3,      ///< all float3
    kBool,        ///< all arguments to bools of one size, which is that of the result
    kSelect,      ///< a condition and two values of one type
    kBits,        ///< one numeric argument; the result type is in the name, or uint
    kOwn,         ///< see compiler/check/own_functions.cpp; arity   is the maximum
};

struct IntrinsicInfo {
    Intrinsic id;
    std::string_view name;
    int arity;
    Shape shape;
};

/// Returns the intrinsic of that name, or null.
const IntrinsicInfo* find_intrinsic(std::string_view name);
/// Returns the names of all built-in functions, those checked elsewhere too.
std::vector<std::string> function_names();

}  // namespace openfab::check

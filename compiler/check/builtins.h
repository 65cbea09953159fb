// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The built-in functions: which exist, and how their arguments are typed.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace openfab::sema {

enum class Intrinsic : uint8_t {
#define OPENFAB_INTRINSIC(name, spelling, arity, shape) k##name,
#include "compiler/check/intrinsics.def"
};

/// How an intrinsic types its arguments and result.
enum class Shape : uint8_t {
    kNumeric,     ///< all arguments to their common type, which is the result
    kFloat,       ///< as kNumeric with components made float
    kToInt,       ///< as kNumeric, result int
    kToBool,      ///< as kFloat, result bool
    kReduceBool,  ///< one argument of any numeric type, result a scalar bool
    kDot,         ///< as kNumeric, result a scalar
    kReduce,      ///< as kFloat, result a scalar
    kFloat3,      ///< all float3
    kBits,        ///< one argument, numeric; the result as the name says, or uint
    kOwn,         ///< as compiler/check/check_functions.cpp says; arity is the most
};

struct IntrinsicInfo {
    Intrinsic id;
    std::string_view name;
    int arity;
    Shape shape;
};

/// Null where there is none of that name.
const IntrinsicInfo* find_intrinsic(std::string_view name);
/// All names of functions that are built in, those that are checked elsewhere too.
std::vector<std::string> function_names();

}  // namespace openfab::sema

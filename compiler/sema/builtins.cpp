// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/sema/builtins.h"

#include <algorithm>
#include <iterator>

namespace openfab::sema {

namespace {

constexpr IntrinsicInfo kIntrinsics[] = {
#define OPENFAB_INTRINSIC(name, spelling, arity, shape) \
    {Intrinsic::k##name, spelling, arity, Shape::shape},
#include "compiler/sema/intrinsics.def"
};

constexpr std::string_view kUnsupported[] = {
    "mul", "transpose", "determinant", "printf", "assert", "over",
};

struct Habit {
    std::string_view theirs;
    std::string_view ours;
};
constexpr Habit kHabits[] = {
    {"mix", "lerp"},          {"fract", "frac"},      {"mod", "fmod"},
    {"inversesqrt", "rsqrt"}, {"fabs", "abs"},        {"fmin", "min"},
    {"fmax", "max"},          {"sqrtf", "sqrt"},      {"clamp01", "saturate"},
    {"roundEven", "round"},   {"texture", "Sample4"}, {"texture2D", "Sample4"},
    {"tex2D", "Sample4"},     {"len", "length"},
};

}  // namespace

const IntrinsicInfo* find_intrinsic(std::string_view name) {
    for (const IntrinsicInfo& info : kIntrinsics) {
        if (info.name == name) return &info;
    }
    return nullptr;
}

bool is_unsupported_function(std::string_view name) {
    return std::find(std::begin(kUnsupported), std::end(kUnsupported), name) !=
           std::end(kUnsupported);
}

std::string_view habit_function(std::string_view name) {
    for (const Habit& habit : kHabits) {
        if (habit.theirs == name) return habit.ours;
    }
    return "";
}

std::vector<std::string> intrinsic_names() {
    std::vector<std::string> names;
    for (const IntrinsicInfo& info : kIntrinsics)
        names.emplace_back(info.name);
    for (std::string_view name : kUnsupported)
        names.emplace_back(name);
    return names;
}

}  // namespace openfab::sema

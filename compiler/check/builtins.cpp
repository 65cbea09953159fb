// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/builtins.h"

namespace openfab::check {

namespace {

constexpr IntrinsicInfo kIntrinsics[] = {
#define OPENFAB_INTRINSIC_INFO(name, spelling, arity, shape) \
    {Intrinsic::k##name, spelling, arity, Shape::shape},
    OPENFAB_INTRINSICS(OPENFAB_INTRINSIC_INFO)
#undef OPENFAB_INTRINSIC_INFO
};

}  // namespace

const IntrinsicInfo* find_intrinsic(std::string_view name) {
    for (const IntrinsicInfo& info : kIntrinsics) {
        if (info.name == name) return &info;
    }
    return nullptr;
}

std::vector<std::string> function_names() {
    std::vector<std::string> names;
    for (const IntrinsicInfo& info : kIntrinsics)
        names.emplace_back(info.name);
    for (const char* name :
         {"mul", "transpose", "determinant", "inverse", "over", "nearest", "distance_to",
          "walk_end", "gradient", "mean_curvature", "printf", "assert"}) {
        names.emplace_back(name);
    }
    return names;
}

}  // namespace openfab::check

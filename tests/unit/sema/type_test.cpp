// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/sema/type.h"

#include <gtest/gtest.h>

#include "compiler/sema/builtins.h"

namespace openfab::sema {
namespace {

TEST(Types, NamesGoBothWays) {
    for (const char* name :
         {"bool", "int2", "uint3", "float4", "float", "Material", "MaterialComposition",
          "ImageTexture2D", "SurfaceAttributes", "VolumeAttributes", "void"}) {
        EXPECT_EQ(type_name(find_type(name).type), name);
    }
}

TEST(Types, WhatIsNotThereYetSaysSo) {
    for (const char* name : {"float3x3", "int1x4", "Object", "SurfacePoint", "ImageTexture3D"}) {
        EXPECT_TRUE(find_type(name).type.is_error()) << name;
        EXPECT_FALSE(find_type(name).unsupported.empty()) << name;
    }
    for (const char* name : {"float5", "float33", "float5x2", "floatx", "int0", ""}) {
        EXPECT_TRUE(find_type(name).type.is_error()) << name;
        EXPECT_TRUE(find_type(name).unsupported.empty()) << name;
    }
}

TEST(Types, HabitsAreAnswered) {
    EXPECT_EQ(find_type("vec3").help, "write `float3`");
    EXPECT_EQ(find_type("Texture2D").help, "write `ImageTexture2D`");
    EXPECT_EQ(find_type("flaot").help, "did you mean `float`?");
    EXPECT_EQ(find_type("material").help, "did you mean `Material`?");
    EXPECT_EQ(habit_function("mix"), "lerp");
    EXPECT_EQ(habit_function("lerp"), "");
}

TEST(Builtins, NothingIsBothThereAndNot) {
    for (const std::string& name : intrinsic_names()) {
        EXPECT_NE(find_intrinsic(name) != nullptr, is_unsupported_function(name)) << name;
        EXPECT_EQ(habit_function(name), "") << name;
    }
}

}  // namespace
}  // namespace openfab::sema

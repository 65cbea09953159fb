// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/type.h"

#include <gtest/gtest.h>

#include "compiler/check/builtins.h"
#include "compiler/check/foreign_names.h"

namespace openfab::check {
namespace {

TEST(Types, NamesGoBothWays) {
    for (const char* name :
         {"bool", "int2", "uint3", "float4", "float", "Material", "MaterialComposition",
          "ImageTexture2D", "ImageTexture3D", "Object", "SurfacePoint", "float3x3", "float2x4",
          "SurfaceAttributes", "VolumeAttributes", "void"}) {
        EXPECT_EQ(type_name(find_type(name)), name);
    }
}

TEST(Types, WhatIsNoTypeIsNone) {
    for (const char* name : {"float5", "float33", "float5x2", "floatx", "int0", "", "int2x2"}) {
        EXPECT_TRUE(find_type(name).is_error()) << name;
    }
    EXPECT_EQ(foreign_type_help("int1x4"), "a matrix is of floats, with 2 to 4 rows and columns");
}

TEST(Types, ArraysPeelFromTheOutside) {
    const Type table = array_of(array_of(find_type("float2x3"), 4), 5);
    EXPECT_EQ(type_name(table), "float2x3[5][4]");
    EXPECT_EQ(min_components(table), 5 * 4 * 6);
    EXPECT_EQ(type_name(table.element()), "float2x3[4]");
    EXPECT_EQ(type_name(table.element().element()), "float2x3");
    EXPECT_EQ(type_name(table.element().element().element()), "float3");
    EXPECT_EQ(table.element().element().length(), 2);
    EXPECT_EQ(table.element(), array_of(find_type("float2x3"), 4));
}

TEST(Types, HabitsAreAnswered) {
    EXPECT_EQ(foreign_type_help("vec3"), "write `float3`");
    EXPECT_EQ(foreign_type_help("Texture2D"), "write `ImageTexture2D`");
    EXPECT_EQ(foreign_function_help("mix"), "OpenFL calls it `lerp`");
    EXPECT_EQ(foreign_function_help("vec3"), "write `float3`");
    EXPECT_EQ(foreign_function_help("lerp"), "");
}

TEST(Habits, AreNoWordsOfOurs) {
    for (const std::string& name : function_names())
        EXPECT_EQ(foreign_function_help(name), "") << name;
    for (const std::string& name : type_names())
        EXPECT_EQ(foreign_type_help(name), "") << name;
}

}  // namespace
}  // namespace openfab::check

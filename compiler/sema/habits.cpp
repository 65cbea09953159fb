// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/sema/habits.h"

#include <fmt/format.h>

namespace openfab::sema {

namespace {

struct Habit {
    std::string_view theirs;
    std::string_view ours;
};

/// Types: GLSL, HLSL, OSL, C.
constexpr Habit kTypes[] = {
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
    {"matrix", "float4x4"},
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
    {"int32_t", "int"},
    {"uint32_t", "uint"},
};

/// Functions that have another name here.
constexpr Habit kFunctions[] = {
    {"mix", "lerp"},       {"fract", "frac"},   {"inversesqrt", "rsqrt"}, {"fabs", "abs"},
    {"fmin", "min"},       {"fmax", "max"},     {"sqrtf", "sqrt"},        {"powf", "pow"},
    {"sinf", "sin"},       {"cosf", "cos"},     {"clamp01", "saturate"},  {"roundEven", "round"},
    {"len", "length"},     {"dFdx", "ddx"},     {"dFdy", "ddy"},          {"fma", "mad"},
    {"snoise", "simplex"}, {"print", "printf"},
};

constexpr std::string_view kSample =
    "a texture is read by its methods: `picture.Sample4(uv, 0)` reads 4 channels from channel 0 on";

/// Where a name alone would not do.
constexpr Habit kFunctionHelp[] = {
    {"rand", "`hash(x)` is a random number for each x"},
    {"random", "`hash(x)` is a random number for each x"},
    {"cellnoise", "`hash(floor(p))` is a random number for each cell"},
    {"voronoi", "`cellular(p)` gives the nearest two points and the cell"},
    {"mod", "`fmod(x, y)` truncates; what `mod` gives is `x - y * floor(x / y)`"},
    {"texture", kSample},
    {"texture2D", kSample},
    {"tex2D", kSample},
    {"tex3D", kSample},
    {"Sample", kSample},
    {"f16tof32", "there are no 16-bit floats; `asfloat` takes the bits of a 32-bit one"},
    {"f32tof16", "there are no 16-bit floats; `asuint` gives the bits of a 32-bit one"},
    {"lit", "nothing is lit: write the terms out with `dot`, `max` and `pow`"},
    {"dst", "write `float4(1, a.y * b.y, a.z, b.w)`"},
    {"msad4", "write the sum out with `abs`"},
    {"ddx_coarse", "there is one derivative, `ddx`; it is exact"},
    {"ddx_fine", "there is one derivative, `ddx`; it is exact"},
    {"ddy_coarse", "there is one derivative, `ddy`; it is exact"},
    {"ddy_fine", "there is one derivative, `ddy`; it is exact"},
    {"abort", "`assert(false)` reports the point; a print goes on"},
    {"errorf", "`printf` prints a line with the point it is about"},
    {"log1p", "write `log(1 + x)`"},
    {"expm1", "write `exp(x) - 1`"},
    {"hypot", "write `length(float2(x, y))`"},
    {"perlin", "Perlin's noise is `noise(p)`"},
    {"clip", "a voxel is void where the stage returns an empty `MaterialComposition`"},
};

constexpr Habit kNameHelp[] = {
    {"discard", "a voxel is void where the stage returns an empty `MaterialComposition`"},
    {"PI", "declare it: `const float PI = 3.14159265;`"},
    {"M_PI", "declare it: `const float PI = 3.14159265;`"},
    {"pi", "declare it: `const float PI = 3.14159265;`"},
    {"NULL", "there are no pointers; the built-in material of nothing is `VOID`"},
    {"null", "there are no pointers; the built-in material of nothing is `VOID`"},
    {"nullptr", "there are no pointers; the built-in material of nothing is `VOID`"},
    {"void_material", "the built-in material of nothing is `VOID`"},
};

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

bool is_side(char c) {
    return c >= '2' && c <= '4';
}

template <size_t N>
std::string_view look_up(const Habit (&table)[N], std::string_view name) {
    for (const Habit& habit : table) {
        if (habit.theirs == name) return habit.ours;
    }
    return "";
}

}  // namespace

std::string renamed_type(std::string_view name) {
    return std::string(look_up(kTypes, name));
}

std::string renamed_function(std::string_view name) {
    const std::string_view ours = look_up(kFunctions, name);
    return ours.empty() ? renamed_type(name) : std::string(ours);
}

std::string habit_of_type(std::string_view name) {
    if (const std::string ours = renamed_type(name); !ours.empty()) {
        return fmt::format("write `{}`", ours);
    }
    // `int3x3`, `float1x4`, `float5x5`
    const size_t cross = name.find('x');
    if (cross == std::string_view::npos || cross < 4 || cross + 2 != name.size()) return "";
    const char rows = name[cross - 1];
    const char columns = name[cross + 1];
    const std::string_view base = name.substr(0, cross - 1);
    const bool numbers = base == "bool" || base == "int" || base == "uint" || base == "float";
    const bool ours = base == "float" && is_side(rows) && is_side(columns);
    if (!numbers || ours || !is_digit(rows) || !is_digit(columns)) return "";
    return "a matrix is of floats, with 2 to 4 rows and columns";
}

std::string habit_of_function(std::string_view name) {
    if (const std::string_view help = look_up(kFunctionHelp, name); !help.empty()) {
        return std::string(help);
    }
    const std::string_view ours = look_up(kFunctions, name);
    return ours.empty() ? habit_of_type(name) : fmt::format("OpenFL calls it `{}`", ours);
}

std::string habit_of_name(std::string_view name) {
    if (name.substr(0, 3) == "gl_") {
        return "what a stage knows of its place are the members of its attributes: "
               "`attr.voxelCenter`, `attr.p`";
    }
    return std::string(look_up(kNameHelp, name));
}

}  // namespace openfab::sema

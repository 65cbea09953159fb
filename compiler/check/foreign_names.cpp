// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/foreign_names.h"

#include <fmt/format.h>

#include <algorithm>

#include "compiler/check/signatures.h"

namespace openfab::check {

namespace {

struct ForeignName {
    std::string_view theirs;
    std::string_view ours;
};

/// Types: GLSL, HLSL, OSL, C.
constexpr ForeignName kTypes[] = {
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
    {"int64_t", "int"},
    {"uint64_t", "uint"},
    {"int8_t", "int"},
    {"uint8_t", "uint"},
    {"size_t", "uint"},
    {"byte", "uint"},
    {"char", "int"},
    {"short", "int"},
    {"long", "int"},
    {"integer", "int"},
    {"i32", "int"},
    {"u32", "uint"},
    {"f32", "float"},
    {"f64", "float"},
    {"real", "float"},
    {"number", "float"},
    {"boolean", "bool"},
    {"half2", "float2"},
    {"half3", "float3"},
    {"half4", "float4"},
    {"double3", "float3"},
    {"dvec3", "float3"},
    {"float1", "float"},
    {"int1", "int"},
    {"uint1", "uint"},
    {"bool1", "bool"},
    {"Vec2", "float2"},
    {"Vec3", "float3"},
    {"Vec4", "float4"},
    {"half2x2", "float2x2"},
    {"half3x3", "float3x3"},
    {"half4x4", "float4x4"},
    {"double2", "float2"},
    {"double4", "float4"},
    {"fixed", "float"},
    {"fixed3", "float3"},
    {"fixed4", "float4"},
    {"min16float", "float"},
    {"Float", "float"},
    {"Texture2DArray", "ImageTexture3D"},
    {"texture3D", "ImageTexture3D"},
    {"Volume", "ImageTexture3D"},
    {"Vector2", "float2"},
    {"Vector3", "float3"},
    {"Vector4", "float4"},
    {"vec2f", "float2"},
    {"vec3f", "float3"},
    {"vec4f", "float4"},
    {"mat2x3", "float3x2"},
    {"mat3x2", "float2x3"},
    {"mat3x4", "float4x3"},
    {"mat4x3", "float3x4"},
    {"texture2D", "ImageTexture2D"},
    {"Texture", "ImageTexture2D"},
    {"Image", "ImageTexture2D"},
    {"Volume3D", "ImageTexture3D"},
    {"Mesh", "Object"},
    {"Mixture", "MaterialComposition"},
    {"Composition", "MaterialComposition"},
};

constexpr std::string_view kNameTheType = "declare a variable with its type: `float x = 1;`";
constexpr std::string_view kNoStrings =
    "strings are allowed only in `printf`, `assert` and annotations";

/// Types that need more than renaming.
constexpr ForeignName kTypeHelp[] = {
    {"var", kNameTheType},
    {"let", kNameTheType},
    {"val", kNameTheType},
    {"auto", kNameTheType},
    {"mut", kNameTheType},
    {"def", kNameTheType},
    {"define", kNameTheType},
    {"string", kNoStrings},
    {"String", kNoStrings},
    {"str", kNoStrings},
    {"goto", "there is no `goto`: leave a loop with `break`, a function with `return`"},
    {"using", "types cannot be renamed"},
    {"typedef", "types cannot be renamed"},
    {"enum", "an enum is declared in a file or a fablet: `enum Pattern { STRIPES, DOTS };`"},
    {"class", "there are no classes; a `struct` holds values"},
    {"uniform", "uniforms are declared in the fablet: `@uniform { float x = 1; }`"},
    {"sampler", "an `ImageTexture2D` is read without one: `picture.Sample4(uv, 0)`"},
    {"SamplerState", "an `ImageTexture2D` is read without one: `picture.Sample4(uv, 0)`"},
    {"list", "an array is declared `float a[3]`"},
    {"array", "an array is declared `float a[3]`"},
    {"function", "a function begins with the type of its result: `float f(float x) { … }`"},
    {"delete", "there is nothing to delete: a value lives until the end of its block"},
    {"print", "write `printf(\"%g\\n\", x)`"},
};

/// Functions that are named differently here.
constexpr ForeignName kFunctions[] = {
    {"mix", "lerp"},        {"fract", "frac"},       {"inversesqrt", "rsqrt"},
    {"fabs", "abs"},        {"fmin", "min"},         {"fmax", "max"},
    {"sqrtf", "sqrt"},      {"powf", "pow"},         {"sinf", "sin"},
    {"cosf", "cos"},        {"clamp01", "saturate"}, {"roundEven", "round"},
    {"len", "length"},      {"dFdx", "ddx"},         {"dFdy", "ddy"},
    {"fma", "mad"},         {"snoise", "simplex"},   {"print", "printf"},
    {"trace", "printf"},    {"absf", "abs"},         {"floorf", "floor"},
    {"ceilf", "ceil"},      {"tanf", "tan"},         {"fmodf", "fmod"},
    {"expf", "exp"},        {"logf", "log"},         {"log2f", "log2"},
    {"arccos", "acos"},     {"arcsin", "asin"},      {"arctan", "atan"},
    {"arctan2", "atan2"},   {"power", "pow"},        {"round_even", "round"},
    {"truncate", "trunc"},  {"maximum", "max"},      {"minimum", "min"},
    {"clip01", "saturate"}, {"deg2rad", "radians"},  {"rad2deg", "degrees"},
    {"where", "select"},    {"logical_and", "and"},  {"logical_or", "or"},
    {"isNan", "isnan"},     {"isInf", "isinf"},
};

constexpr std::string_view kSample =
    "a texture is read with its methods: `picture.Sample4(uv, 0)` reads 4 channels from channel 0 "
    "on";

/// Functions that need more than renaming.
constexpr ForeignName kFunctionHelp[] = {
    {"rand", "`hash(x)` is a random number for each x"},
    {"random", "`hash(x)` is a random number for each x"},
    {"worley",
     "Worley's noise is `cellular(p)`: the distance to the nearest point, to the second, and "
     "a number of the cell"},
    {"sdSphere", "write it out: `length(p - center) - radius`"},
    {"sdf", "the distance to the part's own surface is `distance(p)`"},
    {"signed_distance", "the distance to the part's own surface is `distance(p)`"},
    {"depth", "the depth below the surface is `-distance(p)`"},
    {"Set", "it is a method of `MaterialComposition`: `mc.Set(material, amount)`"},
    {"Add", "it is a method of `MaterialComposition`: `mc.Add(material, amount)`"},
    {"Get", "it is a method of `MaterialComposition`: `mc.Get(material)`"},
    {"exit", "a stage ends with `return`"},
    {"log_e", "write `log(x)`"},
    {"ln", "write `log(x)`"},
    {"sqr", "write `x * x`"},
    {"square", "write `x * x`"},
    {"string", kNoStrings},
    {"range", "a loop is written `for (int i = 0; i < 4; ++i)`"},
    {"normalise", "write `normalize(v)`"},
    {"remap", "write `lerp(c, d, (x - a) / (b - a))`"},
    {"map", "write `lerp(c, d, (x - a) / (b - a))`"},
    {"sum", "write it out, or `dot(v, float3(1, 1, 1))`"},
    {"norm", "write `length(v)`"},
    {"magnitude", "write `length(v)`"},
    {"outerProduct", "write it out row by row: `float3x3(a.x * b, a.y * b, a.z * b)`"},
    {"matrixCompMult", "`a * b` works component by component"},
    {"lessThan", "write `a < b`"},
    {"greaterThan", "write `a > b`"},
    {"equal", "write `a == b`"},
    {"imageLoad", kSample},
    {"textureLod", kSample},
    {"cellnoise", "`hash(floor(p))` is a random number for each cell"},
    {"sizeof",
     "nothing has a size that matters: a number has 32 bits, an array the elements of its "
     "declaration"},
    {"mod", "`fmod(x, y)` truncates; what `mod` gives is `x - y * floor(x / y)`"},
    {"texture", kSample},
    {"texture2D", kSample},
    {"tex2D", kSample},
    {"tex3D", kSample},
    {"texture3D", kSample},
    {"textureLOD", kSample},
    {"texture2DLod", kSample},
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
    {"abort", "`assert(false)` reports the point; the print continues"},
    {"errorf", "`printf` prints a line with the point it is about"},
    {"log1p", "write `log(1 + x)`"},
    {"expm1", "write `exp(x) - 1`"},
    {"hypot", "write `length(float2(x, y))`"},
    {"perlin", "Perlin's noise is `noise(p)`"},
    {"spline", "a curve is a uniform of type `Spline` or `ColorRamp`"},
    {"getattribute", "attributes of the mesh are inputs of a stage: `@nearest float2 uv`"},
    {"getuserdata", "attributes of the mesh are inputs of a stage: `@nearest float2 uv`"},
    {"diffuse", "nothing is lit: a stage returns what a voxel is made of"},
    {"emission", "nothing is lit: a stage returns what a voxel is made of"},
    {"transform", "a vector is transformed by a matrix with `mul(m, v)`"},
    {"clip", "a voxel is void where the stage returns an empty `MaterialComposition`"},
};

/// Functions that have another name in the library.
struct OtherName {
    std::string_view theirs;
    LibraryName ours;
};
constexpr OtherName kLibraryNames[] = {
    {"linearstep", {"grade_linear", "grade_linear(x, from, to)", false}},
    {"linstep", {"grade_linear", "grade_linear(x, from, to)", false}},
    {"smootherstep", {"grade_smoother", "grade_smoother(x, from, to)", false}},
    {"smin", {"solid_union_smooth", "solid_union_smooth(a, b, radius)", true}},
    {"smoothmin", {"solid_union_smooth", "solid_union_smooth(a, b, radius)", true}},
    {"smooth_min", {"solid_union_smooth", "solid_union_smooth(a, b, radius)", true}},
    {"opUnion", {"solid_union", "solid_union(a, b)", true}},
    {"opIntersection", {"solid_intersection", "solid_intersection(a, b)", true}},
    {"opSubtraction", {"solid_difference", "solid_difference(from, what)", false}},
    {"opSmoothUnion", {"solid_union_smooth", "solid_union_smooth(a, b, radius)", true}},
    {"smax", {"solid_intersection_smooth", "solid_intersection_smooth(a, b, radius)", true}},
    {"smooth_max", {"solid_intersection_smooth", "solid_intersection_smooth(a, b, radius)", true}},
    {"opSmoothIntersection",
     {"solid_intersection_smooth", "solid_intersection_smooth(a, b, radius)", true}},
    {"opSmoothSubtraction",
     {"solid_difference_smooth", "solid_difference_smooth(a, b, radius)", false}},
    {"sdSphere", {"solid_ball", "solid_ball(p, radius)", true}},
    {"sdBox", {"solid_box", "solid_box(p, size, round)", false}},
    {"sdTorus", {"solid_torus", "solid_torus(p, ring, radius)", false}},
    {"sdCapsule", {"solid_capsule", "solid_capsule(p, from, to, radius)", true}},
    {"sdCylinder", {"solid_cylinder", "solid_cylinder(p, radius, height)", false}},
    {"sdCone", {"solid_cone", "solid_cone(p, low, high, height)", false}},
    {"sdGyroid", {"gyroid", "gyroid(p, cell)", false}},
    {"hsv2rgb", {"hsv_to_rgb", "hsv_to_rgb(c)", true}},
    {"rgb2hsv", {"rgb_to_hsv", "rgb_to_hsv(c)", true}},
    {"hsvtorgb", {"hsv_to_rgb", "hsv_to_rgb(c)", true}},
    {"luma", {"luminance", "luminance(c)", true}},
    {"checkerboard", {"checks", "checks(p, …)", false}},
    {"brick", {"bricks", "bricks(p, …)", false}},
};

constexpr ForeignName kNameHelp[] = {
    {"P", "a stage reads its position from its attributes: `attr.voxelCenter`, `attr.p`"},
    {"N", "the normal of a surface point is `attr.n`, of the nearest one `nearest(p).normal`"},
    {"Ci", "a stage returns what a voxel is made of, a `MaterialComposition`"},
    {"RAND_MAX", "`hash(x)` is from 0 to 1"},
    {"FLT_MAX", "write `3.4028235e38`"},
    {"FLT_EPSILON", "write `1.1920929e-7`"},
    {"INT_MAX", "write `0x7fffffff`"},
    {"vector", "vectors are `float2` to `float4`, `int2` to `int4` and so on"},
    {"discard", "a voxel is void where the stage returns an empty `MaterialComposition`"},
    {"PI", "declare it: `const float PI = 3.14159265;`"},
    {"M_PI", "declare it: `const float PI = 3.14159265;`"},
    {"pi", "declare it: `const float PI = 3.14159265;`"},
    {"NULL", "there are no pointers; the built-in empty material is `VOID`"},
    {"null", "there are no pointers; the built-in empty material is `VOID`"},
    {"nullptr", "there are no pointers; the built-in empty material is `VOID`"},
    {"void_material", "the built-in empty material is `VOID`"},
    {"None", "the built-in empty material is `VOID`"},
    {"NONE", "the built-in empty material is `VOID`"},
    {"none", "the built-in empty material is `VOID`"},
    {"nil", "the built-in empty material is `VOID`"},
    {"EMPTY", "the built-in empty material is `VOID`"},
    {"AIR", "the built-in empty material is `VOID`"},
    {"math", "functions have no prefix: `sin(x)`"},
    {"Math", "functions have no prefix: `sin(x)`"},
    {"np", "functions have no prefix: `sin(x)`"},
    {"std", "functions have no prefix: `sin(x)`"},
    {"this", "refer to members of the fablet by name alone"},
    {"self", "refer to members of the fablet by name alone"},
    {"cout", "`printf` prints a line with the point it is about"},
    {"console", "`printf` prints a line with the point it is about"},
    {"inf", "write `1e38`, or `asfloat(0x7f800000)`"},
    {"INFINITY", "write `1e38`, or `asfloat(0x7f800000)`"},
    {"nan", "write `asfloat(0x7fc00000)`"},
    {"NAN", "write `asfloat(0x7fc00000)`"},
    {"E", "declare it: `const float E = 2.71828183;`"},
    {"TAU", "declare it: `const float TAU = 6.28318531;`"},
    {"fragCoord", "the position of a voxel is `attr.voxelCenter`"},
    {"iTime", "a print does not change with time; declare a uniform"},
    {"time", "a print does not change with time; declare a uniform"},
    {"throw", "there are no exceptions; use `assert` to find faults"},
};

/// Attributes by their names in other languages, for each stage.
constexpr ForeignName kVolumeAttributes[] = {
    {"position", "the voxel is at `voxelCenter` in the part and at `buildPosition` on the tray"},
    {"pos", "the voxel is at `voxelCenter` in the part and at `buildPosition` on the tray"},
    {"p", "the voxel is at `voxelCenter` in the part and at `buildPosition` on the tray"},
    {"center", "the voxel is at `voxelCenter` in the part and at `buildPosition` on the tray"},
    {"n", "the normal of the nearest surface point is `nearest(p).normal`"},
    {"normal", "the normal of the nearest surface point is `nearest(p).normal`"},
    {"uv", "texture coordinates come from the mesh: add `@nearest float2 uv` to the varyings"},
    {"distance", "it is a function: `distance(attr.voxelCenter)`"},
    {"depth", "the depth below the surface is `-distance(attr.voxelCenter)`"},
};
constexpr ForeignName kDitherAttributes[] = {
    {"index", "the voxel's index in the print is `voxel`, an `int3`"},
    {"fractions", "the fractions are `Fraction(0)` to `Fraction(count - 1)`"},
    {"fraction", "the fractions are `Fraction(0)` to `Fraction(count - 1)`"},
    {"blueNoise", "the mask's threshold is `BlueNoise(face)`, of face 0 inside a mixture"},
    {"voxelCenter", "a dither rule has the voxel's index, `voxel`, and its sides, `voxelSize`"},
};
constexpr ForeignName kShapeAttributes[] = {
    {"position", "the point is `p`"},
    {"pos", "the point is `p`"},
    {"point", "the point is `p`"},
    {"voxelCenter", "a shape is asked at any point, not at voxels; the point is `p`"},
    {"voxelSize", "a shape is the same for all voxels: declare a uniform"},
    {"buildPosition",
     "a shape is the same wherever it is placed; the point is `p`, of its own space"},
    {"instance", "a shape is the same for all its instances"},
    {"n", "a shape's normal follows from its function: `normalize(gradient(f, p))`"},
    {"normal", "a shape's normal follows from its function: `normalize(gradient(f, p))`"},
};
constexpr ForeignName kGrowAttributes[] = {
    {"index", "the number among its parent's children is `child`"},
    {"depth", "how many parents it has is `level`"},
    {"seed", "a number of its own is `path`: `hash(attr.path)`"},
    {"id", "a number of its own is `path`: `hash(attr.path)`"},
    {"p", "a node is where its members say: `parent.end[1]`"},
};
constexpr ForeignName kSurfaceAttributes[] = {
    {"position", "the point is `p`"},
    {"pos", "the point is `p`"},
    {"voxelCenter", "a surface stage has no voxels; the point is `p`"},
    {"normal", "the normal is `n`"},
    {"texcoord", "the texture coordinates are `uv`"},
    {"u", "the texture coordinates are `uv`"},
    {"v", "the texture coordinates are `uv`"},
};

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

bool is_side(char c) {
    return c >= '2' && c <= '4';
}

template <size_t N>
std::string_view find_help(const ForeignName (&table)[N], std::string_view name) {
    for (const ForeignName& entry : table) {
        if (entry.theirs == name) return entry.ours;
    }
    return "";
}

}  // namespace

std::string renamed_type(std::string_view name) {
    return std::string(find_help(kTypes, name));
}

std::string renamed_function(std::string_view name) {
    const std::string_view ours = find_help(kFunctions, name);
    return ours.empty() ? renamed_type(name) : std::string(ours);
}

std::string foreign_type_help(std::string_view name) {
    if (const std::string ours = renamed_type(name); !ours.empty()) {
        return fmt::format("write `{}`", ours);
    }
    if (const std::string_view help = find_help(kTypeHelp, name); !help.empty()) {
        return std::string(help);
    }
    // `int3x3`, `float1x4`, `float5x5`
    for (std::string_view base : {"float", "int", "uint", "bool"}) {
        const std::string_view rest = name.substr(std::min(base.size(), name.size()));
        if (name.starts_with(base) && rest.size() == 1 && is_digit(rest[0]) && !is_side(rest[0]))
            return "a vector has 2 to 4 components";
    }
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

std::string foreign_function_help(std::string_view name) {
    if (const std::string_view help = find_help(kFunctionHelp, name); !help.empty()) {
        return std::string(help);
    }
    const std::string_view ours = find_help(kFunctions, name);
    if (!ours.empty()) return fmt::format("OpenFL calls it `{}`", ours);
    if (const std::string help = foreign_type_help(name); !help.empty()) return help;
    // `fabsf`, `fminf`, `asinf`
    if (name.size() < 3 || !name.ends_with('f')) return "";
    const std::string_view stem = name.substr(0, name.size() - 1);
    const std::string_view known = find_help(kFunctions, stem);
    if (known == name) return "";  // `printf` is no `print` of floats
    if (!known.empty()) return fmt::format("OpenFL calls it `{}`", known);
    return signatures_of(stem).empty() ? "" : fmt::format("OpenFL calls it `{}`", stem);
}

bool infers_type(std::string_view name) {
    return name == "auto" || name == "var" || name == "let" || name == "val" || name == "def";
}

LibraryName library_name(std::string_view name) {
    for (const OtherName& entry : kLibraryNames) {
        if (entry.theirs == name) return entry.ours;
    }
    return {};
}

std::string constant_of(std::string_view name) {
    if (name == "PI" || name == "M_PI" || name == "pi")
        return fmt::format("const float {} = 3.14159265;", name);
    if (name == "TAU") return "const float TAU = 6.28318531;";
    return name == "E" ? "const float E = 2.71828183;" : "";
}

bool is_foreign_lookup(std::string_view name) {
    return find_help(kFunctionHelp, name) == kSample;
}

std::string foreign_attribute_help(std::string_view name, const Type& attributes) {
    if (attributes.is(Base::kSurfaceAttributes))
        return std::string(find_help(kSurfaceAttributes, name));
    if (attributes.is(Base::kShapeAttributes))
        return std::string(find_help(kShapeAttributes, name));
    if (attributes.is(Base::kGrowAttributes)) return std::string(find_help(kGrowAttributes, name));
    return std::string(attributes.is(Base::kVolumeAttributes) ? find_help(kVolumeAttributes, name)
                                                              : find_help(kDitherAttributes, name));
}

std::string foreign_name_help(std::string_view name) {
    if (name.substr(0, 3) == "gl_") {
        return "a stage reads its position from its attributes: "
               "`attr.voxelCenter`, `attr.p`";
    }
    return std::string(find_help(kNameHelp, name));
}

}  // namespace openfab::check

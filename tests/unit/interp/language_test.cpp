// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Results of programs: control flow, assignment, functions, built-in functions, against closed
// forms.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/unit/interp/fixture.h"

namespace openfab::testing {
namespace {

TEST(Language, OperatorsAndPrecedence) {
    EXPECT_EQ(evaluate("return x + y * z - x / y;", 6, 2, 5), 13);
    EXPECT_EQ(evaluate("return i + 7 % 4 << 1 & 30 | 1;", 0, 0, 0, 5), 17);
    EXPECT_EQ(evaluate("return i / j + i % j;", 0, 0, 0, -7, 2), -4);
    EXPECT_EQ(evaluate("return -x;", 3), -3);
    EXPECT_EQ(evaluate("return ~i;", 0, 0, 0, 5), -6);
    EXPECT_EQ(evaluate("return !i ? 1 : 2;", 0, 0, 0, 0), 1);
    EXPECT_EQ(evaluate("return (x < y) + (x <= y) + (x == y);", 1, 2), 2);
    EXPECT_EQ(evaluate("uint u = i; return u / 2u;", 0, 0, 0, -1), 2147483647.0f);
    EXPECT_EQ(evaluate("return i > 0 == j > 0;", 0, 0, 0, -1, -2), 1);
}

TEST(Language, PromotionsGoThroughTheWiderType) {
    EXPECT_EQ(evaluate("return i / 2;", 0, 0, 0, 5), 2);
    EXPECT_EQ(evaluate("return i / 2.0;", 0, 0, 0, 5), 2.5f);
    EXPECT_EQ(evaluate("return (x > 0) + (y > 0);", 1, 1), 2);
    EXPECT_EQ(evaluate("float a = 7; a /= i; return a;", 0, 0, 0, 2), 3.5f);
    EXPECT_EQ(evaluate("int a = 7; a = int(a * x); return a;", 0.5f), 3);
}

TEST(Language, CompoundAssignmentWorksInTheWiderType) {
    EXPECT_EQ(evaluate("int a = i; a *= 1.5; return a;", 0, 0, 0, 5), 7);
    EXPECT_EQ(
        evaluate("float2 v = float2(x, y); v *= 2; v += float2(1, 10); return v.x * 100 + v.y;", 1,
                 2),
        314);
    EXPECT_EQ(evaluate("int2 v = int2(i, j); v.y -= 0.5; return v.x * 10 + v.y;", 0, 0, 0, 3, 4),
              33);
}

TEST(Language, VectorsSwizzlesAndIndices) {
    EXPECT_EQ(
        evaluate("float3 v = float3(x, y, z); return v.zyx.x * 100 + v[1] * 10 + v.r;", 1, 2, 3),
        321);
    EXPECT_EQ(
        evaluate("float4 v = 0; v.wy = float2(x, y); return v.w * 1000 + v.y * 10 + v.x;", 1, 2),
        1020);
    EXPECT_EQ(evaluate("float3 v = float3(x, y, z); v.xy = v.yx; return v.x * 10 + v.y;", 1, 2),
              21);
    EXPECT_EQ(evaluate("float2 v = float2(x, y) * 2 + 1; return v.x + v.y;", 1, 2), 8);
    EXPECT_EQ(evaluate("float4 v = float4(float2(x, y), z, 1); return v.z;", 1, 2, 3), 3);
    EXPECT_EQ(evaluate("float s = 0; float3 v = float3(x, y, z); for (int k = 0; k < 3; k++) s = s "
                       "* 10 + v[k]; return s;",
                       1, 2, 3),
              123);
    EXPECT_EQ(evaluate("float3 v = 0; int k = 0; v[k++] += x; return v.x * 10 + k;", 2), 21);
}

TEST(Language, IfMergesWhatItAssigns) {
    const std::string body =
        "float a = 1, b = 2; if (x > 0) { a = 10; } else { b = 20; } return a * 100 + b;";
    EXPECT_EQ(evaluate(body, 1), 1002);
    EXPECT_EQ(evaluate(body, -1), 120);
    EXPECT_EQ(evaluate(body, std::numeric_limits<float>::quiet_NaN()), 120);
}

TEST(Language, EarlyReturnStopsWhatFollows) {
    const std::string body =
        "float a = 1; if (x > 0) { if (y > 0) return a; a = 2; } else if (z > 0) return 9; a += "
        "10; if (a > 11) return a; return -a;";
    EXPECT_EQ(evaluate(body, 1, 1), 1);
    EXPECT_EQ(evaluate(body, 1, -1), 12);
    EXPECT_EQ(evaluate(body, -1, 0, 1), 9);
    EXPECT_EQ(evaluate(body, -1, 0, -1), -11);
}

TEST(Language, NothingIsWrittenAfterAReturn) {
    const std::string program =
        "float f(float x, out float y) { y = 1; if (x > 0) return 5; y = 2; return 6; }\n"
        "fablet A { @uniform { float x; Material m; } @Volume() { MaterialComposition mc; float y; "
        "float r = f(x, y);"
        " mc.Set(m, r * 10 + y); return mc; } }";
    const ir::Fablet fablet = compile(program);
    MapEnvironment env;
    env.set(OPENFAB_ARG_UNIFORM, 0, 0, 1.0f);
    EXPECT_EQ(as_float(interp::evaluate(fablet.volume, env)[0]), 51);
    env.set(OPENFAB_ARG_UNIFORM, 0, 0, -1.0f);
    EXPECT_EQ(as_float(interp::evaluate(fablet.volume, env)[0]), 62);
}

TEST(Language, LoopsRunAndLeave) {
    EXPECT_EQ(evaluate("int s = 0; for (int k = 1; k <= 10; k++) s += k; return s;"), 55);
    EXPECT_EQ(
        evaluate("int s = 0; for (int k = 0; k < 10; k++) { if (k == i) break; s += 1; } return s;",
                 0, 0, 0, 4),
        4);
    EXPECT_EQ(evaluate("int s = 0; for (int k = 0; k < 10; k++) { if (k % 2 == i) continue; s += "
                       "k; } return s;",
                       0, 0, 0, 0),
              25);
    EXPECT_EQ(evaluate("for (int k = 0; k < 10; k++) { if (k * k > i) return k; } return -1;", 0, 0,
                       0, 17),
              5);
    EXPECT_EQ(evaluate("for (int k = 0; k < 10; k++) { if (k * k > i) return k; } return -1;", 0, 0,
                       0, 100),
              -1);
    EXPECT_EQ(
        evaluate("int k = 0; do { k++; if (k == i) break; } while (k < 5); return k;", 0, 0, 0, 3),
        3);
    EXPECT_EQ(evaluate("int k = 0; while (true) { if (++k == 7) break; } return k;"), 7);
    EXPECT_EQ(evaluate("int s = 0; for (int a = 0; a < 4; a++) for (int b = 0; b < 4; b++) { if (b "
                       "== a) break; s += i; } return s;",
                       0, 0, 0, 2),
              12);
    EXPECT_EQ(evaluate("int s = 0; for (int a = 0; a < 3; a++) { for (int b = 0; b < 3; b++) { if "
                       "(b == i) continue; if (a == j) break; s += "
                       "10 * a + b; } s += 100; } return s;",
                       0, 0, 0, 1, 2),
              324);
}

TEST(Language, ShortCircuitSkipsSideEffects) {
    EXPECT_EQ(evaluate("int n = 0; bool b = x > 0 && ++n > 0; return n * 10 + b;", 1), 11);
    EXPECT_EQ(evaluate("int n = 0; bool b = x > 0 && ++n > 0; return n * 10 + b;", -1), 0);
    EXPECT_EQ(evaluate("int n = 0; bool b = x > 0 || ++n > 0; return n * 10 + b;", 1), 1);
    EXPECT_EQ(evaluate("int n = 0; bool b = x > 0 || ++n > 0; return n * 10 + b;", -1), 11);
    EXPECT_EQ(
        evaluate("int a = 0, b = 0; int c = x > 0 ? ++a : --b; return a * 100 + b * 10 + c;", 1),
        101);
    EXPECT_EQ(
        evaluate("int a = 0, b = 0; int c = x > 0 ? ++a : --b; return a * 100 + b * 10 + c;", -1),
        -11);
}

TEST(Language, IncrementGivesTheOldOrTheNewValue) {
    EXPECT_EQ(evaluate("int a = i; int b = a++; return a * 10 + b;", 0, 0, 0, 3), 43);
    EXPECT_EQ(evaluate("int a = i; int b = --a; return a * 10 + b;", 0, 0, 0, 3), 22);
    EXPECT_EQ(evaluate("float a, b; a = b = x; return a + b;", 3), 6);
}

TEST(Language, BuiltInFunctions) {
    EXPECT_EQ(evaluate("return clamp(x, 0, 1) + 10 * saturate(y);", 7, -2), 1);
    EXPECT_EQ(evaluate("return saturate(x);", std::numeric_limits<float>::quiet_NaN()), 0);
    EXPECT_EQ(evaluate("return sign(x) * 10 + sign(y);", -3, 4), -9);
    EXPECT_EQ(evaluate("return frac(x);", -1.25f), 0.75f);
    EXPECT_EQ(evaluate("return fmod(x, y);", -5.5f, 2), -1.5f);
    EXPECT_EQ(evaluate("return round(x) * 10 + trunc(y);", 2.5f, -1.5f), 19);
    EXPECT_EQ(evaluate("return rsqrt(x);", 16), 0.25f);
    EXPECT_EQ(evaluate("return step(x, y) * 10 + step(y, x);", 1, 2), 10);
    EXPECT_EQ(evaluate("return smoothstep(0, 4, x);", 1), 0.15625f);
    EXPECT_EQ(evaluate("return lerp(x, y, z);", 2, 4, 0.25f), 2.5f);
    EXPECT_EQ(evaluate("return mad(x, y, z);", 2, 4, 3), 11);
    EXPECT_EQ(evaluate("return dot(float3(x, y, z), float3(1, 10, 100));", 1, 2, 3), 321);
    EXPECT_EQ(evaluate("return length(float2(x, y)) + distance(float2(x, 0), float2(0, y));", 3, 4),
              10);
    EXPECT_EQ(
        evaluate("float3 c = cross(float3(x, 0, 0), float3(0, y, 0)); return c.x + c.y + c.z;", 2,
                 3),
        6);
    EXPECT_EQ(evaluate("float2 n = normalize(float2(x, y)); return n.x * 10 + n.y;", 3, 4), 6.8f);
    EXPECT_EQ(
        evaluate("float2 r = reflect(float2(x, y), float2(0, 1)); return r.x * 10 + r.y;", 1, -2),
        12);
    EXPECT_EQ(evaluate("return any(float2(x, y)) * 10 + all(float2(x, y));", 0, 1), 10);
    EXPECT_EQ(evaluate("return isnan(x) * 100 + isinf(y) * 10 + isfinite(z);",
                       std::numeric_limits<float>::quiet_NaN(),
                       -std::numeric_limits<float>::infinity(), 3),
              111);
    EXPECT_EQ(evaluate("return abs(i) + max(i, j) + min(i, j);", 0, 0, 0, -3, 5), 5);
    EXPECT_EQ(evaluate("return dot(int2(i, j), int2(i, j));", 0, 0, 0, 3, 4), 25);
    EXPECT_FLOAT_EQ(evaluate("return radians(x) + degrees(y);", 180, 3.14159265f), 183.14159f);
}

TEST(Language, MaterialsAreSlots) {
    const ir::Fablet fablet = compile(
        "fablet A { @uniform { Material a, b; float x; } @Volume() { MaterialComposition p, q;\n"
        "Material m = x > 0 ? a : b; p.Set(m, 2); p.Add(m, 3); p.Set(VOID, 1); q.Set(b, 10);\n"
        "if (m == a) q.Add(a, p.Total()); else q.Clear(); q.Add(VOID, q.Get(b)); return lerp(p, q "
        "+ p * 2, 0.5); } }");
    EXPECT_EQ(fablet.slot_count, 3);
    EXPECT_EQ(fablet.void_slot, 2);
    MapEnvironment env;
    env.set(OPENFAB_ARG_UNIFORM, 0, 0, 1.0f);
    std::vector<uint32_t> out = interp::evaluate(fablet.volume, env);
    EXPECT_EQ(as_float(out[0]), 10.5f);  // (5 + 6 + 10) / 2
    EXPECT_EQ(as_float(out[1]), 5);
    EXPECT_EQ(as_float(out[2]), 6.5f);  // (1 + 10 + 2) / 2
    env.set(OPENFAB_ARG_UNIFORM, 0, 0, -1.0f);
    out = interp::evaluate(fablet.volume, env);
    EXPECT_EQ(as_float(out[0]), 0);
    EXPECT_EQ(as_float(out[1]), 7.5f);
    EXPECT_EQ(as_float(out[2]), 1.5f);
}

TEST(Language, ASampleRunsOnlyWhereItsPathIsTaken) {
    const ir::Fablet fablet = compile(
        "fablet A { @uniform { ImageTexture2D t; float x, y; Material m; }\n"
        "float look(float u) { if (x > 0) return t.Sample1(u, 0.5, 0); return 0; }\n"
        "@Volume() { MaterialComposition mc; float s = 0;\n"
        "for (int k = 0; k < 3; k++) { if (k >= y) break; s += look(0.5); }\n"
        "bool b = x > 0 && t.Sample1(0.5, 0.5, 0) > 0; float c = y > 2 ? t.Sample1(0.5, 0.5, 1) : "
        "0;\n"
        "if (y < 0) return mc; mc.Set(m, s + b + c + t.Sample1(0.1, 0.1, 0)); return mc; } }");
    const auto sample_count = [&](float x, float y) {
        MapEnvironment env;
        env.pictures.emplace_back(1, 1, 1, std::vector<float>{1}, 0, 0);
        env.set(OPENFAB_ARG_UNIFORM, 0, 0, x);
        env.set(OPENFAB_ARG_UNIFORM, 1, 0, y);
        (void)interp::evaluate(fablet.volume, env);
        return env.sample_count;
    };
    // Equal lookups under the same condition are one instruction: with x > 0 alone those of &&
    // merge …
    EXPECT_EQ(sample_count(-1, -1), 0);
    EXPECT_EQ(sample_count(-1, 0), 1);
    EXPECT_EQ(sample_count(-1, 3), 2);
    EXPECT_EQ(sample_count(1, -1), 1);
    // … and each iteration under x > 0 and y adds one.
    EXPECT_EQ(sample_count(1, 1), sample_count(1, 0) + 1);
    EXPECT_EQ(sample_count(1, 2), sample_count(1, 0) + 2);
}

TEST(Language, AttributesComeFromTheFrameInTheOrderOfTheAbi) {
    const ir::Fablet fablet = compile(
        "fablet A { @uniform { Material a, b, c, d, e; } @Volume(@varying { VolumeAttributes attr "
        "}) { MaterialComposition mc;\n"
        "mc.Set(a, attr.voxelCenter.y); mc.Set(b, attr.buildPosition.z); mc.Set(c, "
        "attr.voxelSize.x);\n"
        "mc.Set(d, attr.instance); mc.Set(e, distance(attr.voxelCenter)); return mc; } }");
    MapEnvironment env;
    for (int32_t k = 0; k < OPENFAB_FRAME_COUNT; ++k)
        env.set(OPENFAB_ARG_FRAME, k, 0, 0.1f * static_cast<float>(k + 1));
    env.set(ir::kVoxelCoord, 0, 0, 3.5f);
    env.set(ir::kVoxelCoord, 1, 0, 7.5f);
    env.set(ir::kVoxelCoord, 2, 0, 11.5f);
    env.set(OPENFAB_ARG_INSTANCE, 0, 0, 4);
    env.set(OPENFAB_ARG_DISTANCE, 0, 0, -0.25f);
    const auto frame = [](int k) { return 0.1f * static_cast<float>(k + 1); };
    const std::vector<uint32_t> out = interp::evaluate(fablet.volume, env);
    EXPECT_EQ(as_float(out[0]),
              ((3.5f * frame(1) + 7.5f * frame(4)) + 11.5f * frame(7)) + frame(10) + frame(13));
    EXPECT_EQ(as_float(out[1]), frame(20) + 11.5f * frame(17));
    EXPECT_EQ(as_float(out[2]), frame(15));
    EXPECT_EQ(as_float(out[3]), 4);
    EXPECT_EQ(as_float(out[4]), -0.25f);
}

TEST(Language, DefaultsAreEvaluated) {
    const ir::Fablet fablet = compile(
        "const float W = 2;\nfloat twice(float x) { return x * 2; }\n"
        "fablet A { @uniform { float2 s = W + 1; int n = twice(1.5) > 2 ? 7 : 8; float w; } "
        "@Surface(@varying { float2 uv = float2(1, W) }) "
        "{ return uv.x; } @Volume() { MaterialComposition mc; return mc; } }");
    EXPECT_EQ(fablet.uniforms[0].default_bits, (std::vector<uint32_t>{0x40400000u, 0x40400000u}));
    EXPECT_EQ(fablet.uniforms[1].default_bits, (std::vector<uint32_t>{7}));
    EXPECT_TRUE(fablet.uniforms[2].default_bits.empty());
    EXPECT_EQ(fablet.surface_inputs[0].default_bits,
              (std::vector<uint32_t>{0x3f800000u, 0x40000000u}));
}

TEST(Language, OutputsThatCopyAnInputSaySo) {
    const ir::Fablet fablet = compile(
        "fablet A { @Surface(@varying { float2 uv, float2 st, int face, out float2 a, out float2 "
        "b, out float2 c, out int d, out float e })\n"
        "{ a = st; b = uv.yx; c = float2(uv.x, st.y); d = face; e = face; return 0; }\n"
        "@Volume() { MaterialComposition mc; return mc; } }");
    std::vector<int32_t> sources;
    for (const ir::Varying& v : fablet.surface_outputs)
        sources.push_back(v.source);
    EXPECT_EQ(sources, (std::vector<int32_t>{1, -1, -1, 2, -1}));
}

}  // namespace
}  // namespace openfab::testing

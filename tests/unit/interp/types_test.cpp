// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Semantics of arrays, structs, matrices, `switch` and compositions, by the interpreter.

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/interp/fixture.h"

namespace openfab::testing {
namespace {

TEST(Arrays, AVaryingIndexIsClamped) {
    const std::string list = "float a[4] = {10, 11, 12, 13}; ";
    for (int32_t i : {-100, -1, 0, 1, 2, 3, 4, 1000}) {
        const float there = 10.0f + static_cast<float>(std::clamp(i, 0, 3));
        EXPECT_EQ(evaluate(list + "return a[i];", 0, 0, 0, i), there) << i;
        EXPECT_EQ(evaluate(list + "a[i] = 0; return 46 - (a[0] + a[1] + a[2] + a[3]);", 0, 0, 0, i),
                  there)
            << i;
        EXPECT_EQ(evaluate(list + "return (a[i] += 1) - 1;", 0, 0, 0, i), there) << i;
    }
    // A uint above INT_MAX is past the end, not before the start.
    EXPECT_EQ(evaluate(list + "return a[uint(i) + 0x80000000u];"), 13);
}

TEST(Arrays, OfArrays) {
    const std::string table = "float t[2][3] = {{0, 1, 2}, {10, 11, 12}}; ";
    for (int32_t i = 0; i < 2; ++i) {
        for (int32_t j = 0; j < 3; ++j) {
            const auto value = static_cast<float>(10 * i + j);
            EXPECT_EQ(evaluate(table + "return t[i][j];", 0, 0, 0, i, j), value);
            EXPECT_EQ(evaluate(table + "float row[3] = t[i]; return row[j];", 0, 0, 0, i, j),
                      value);
            EXPECT_EQ(
                evaluate(table + "t[i][j] = 100; float s = 0; for (int k = 0; k < 6; k++) s += "
                                 "t[k / 3][k % 3]; return 136 - s;",
                         0, 0, 0, i, j),
                value);
        }
    }
}

TEST(Arrays, AnIndexIsEvaluatedOnce) {
    EXPECT_EQ(evaluate("float a[3] = {1, 2, 3}; int k = i; a[k++] += 10; return a[0] * 100 + k;"),
              1101);
    EXPECT_EQ(evaluate("float a[3] = {1, 2, 3}; int k = i; a[k++]++; return a[0] * 100 + k;"), 201);
}

TEST(Arrays, OfVectorsAndTheirComponents) {
    EXPECT_EQ(evaluate("float3 v[2] = {1, 2, 3, 4, 5, 6}; v[i].zx = float2(x, y); return v[1].x * "
                       "10 + v[1].z;",
                       7, 8, 0, 1),
              87);
    EXPECT_EQ(evaluate("float3 v[2] = {{1, 2, 3}, {4, 5, 6}}; return v[i][j];", 0, 0, 0, 1, 2), 6);
    EXPECT_EQ(evaluate("float3 p = {1, 2, 3}; p[i] = 9; return p.x + p.y + p.z;", 0, 0, 0, 1), 13);
}

TEST(Arrays, AsParametersAndResults) {
    const std::string text =
        "fablet A { @uniform { int i; Material m; }\n"
        "struct Box { float a[2]; };\n"
        "Box make(float x) { Box b = {{x, x + 1}}; return b; }\n"
        "void swap(inout float a[2]) { float t = a[0]; a[0] = a[1]; a[1] = t; }\n"
        "@Volume() { float a[2] = {1, 2}; swap(a); float row[2][2] = {a, {5, 6}}; swap(row[i]);\n"
        "MaterialComposition mc; mc.Set(m, a[0] * 1000 + make(7).a[i] * 100 + row[1][0] * 10 + "
        "row[0][0]); return mc; } }";
    const ir::Fablet fablet = compile(text);
    MapEnvironment env;
    env.set(OPENFAB_ARG_UNIFORM, 0, 0, 1);
    EXPECT_EQ(as_float(interp::evaluate(fablet.volume, env)[0]), 2000 + 800 + 60 + 2);
}

TEST(Arrays, UniformsAndMaterials) {
    const ir::Fablet fablet = compile(
        "fablet A { @uniform { Material m[3]; float w[3] = {1, 2, 3}; int i; Material last; }\n"
        "@Volume() { MaterialComposition mc; mc.Set(m[i], w[i]); mc.Add(last, 7); return mc; "
        "} }");
    EXPECT_EQ(fablet.slot_count, 4);
    EXPECT_EQ(fablet.uniforms[1].default_bits.size(), 3u);
    EXPECT_EQ(fablet.uniforms[3].first_index, 3);
    for (int32_t i = 0; i < 3; ++i) {
        MapEnvironment env;
        for (int32_t k = 0; k < 3; ++k)
            env.set(OPENFAB_ARG_UNIFORM, k, 0, static_cast<float>(k + 1));
        env.set(OPENFAB_ARG_UNIFORM, 3, 0, i);
        const std::vector<uint32_t> out = interp::evaluate(fablet.volume, env);
        for (int32_t k = 0; k < 3; ++k) {
            EXPECT_EQ(as_float(out[k]), k == i ? static_cast<float>(i + 1) : 0);
        }
        EXPECT_EQ(as_float(out[3]), 7);
    }
}

TEST(Structs, AreValues) {
    const std::string decl = "struct P { float a; int b[2]; }; P p = {x, {1, 2}}; P q = p; ";
    EXPECT_EQ(evaluate(decl + "q.a = 5; q.b[1] = 9; return p.a * 100 + p.b[1] * 10 + q.b[1];", 3),
              329);
    EXPECT_EQ(evaluate(decl + "P list[2] = {p, q}; list[i].b[j] = 50; return list[1].b[0] + "
                              "list[0].b[0];",
                       0, 0, 0, 1, 0),
              51);
    EXPECT_EQ(evaluate(decl + "p = i > 0 ? q : (P)7; return p.a + p.b[0];", 3), 14);
    EXPECT_EQ(evaluate(decl + "P z = {}; return z.a + z.b[0] + P(1, {2, 3}).b[1];"), 3);
}

TEST(Matrices, AreRowMajor) {
    const std::string m = "float2x3 m = {1, 2, 3, 4, 5, 6}; ";
    EXPECT_EQ(evaluate(m + "return m[1][2] * 100 + m._m01 * 10 + m._21;"), 624);
    EXPECT_EQ(evaluate(m + "return m[i][j];", 0, 0, 0, 1, 0), 4);
    EXPECT_EQ(evaluate(m + "return mul(m, float3(1, 10, 100)).y;"), 654);
    EXPECT_EQ(evaluate(m + "return mul(float2(1, 10), m).z;"), 63);
    EXPECT_EQ(evaluate(m + "return transpose(m)[2][1];"), 6);
    EXPECT_EQ(evaluate(m + "float2x2 s = mul(m, transpose(m)); return s[0][1] + s[1][1];"),
              32 + 77);
    EXPECT_EQ(evaluate(m + "float2x2 c = (float2x2)m; return c[1][1];"), 5);
    EXPECT_EQ(evaluate("float3x3 d = float3x3(2, 0, 1, 1, 3, 2, 1, 1, 1); return determinant(d);"),
              0);
    EXPECT_EQ(evaluate("float3x3 d = float3x3(2, 0, 0, 1, 3, 2, 1, 1, 1); return determinant(d);"),
              2);
    EXPECT_EQ(evaluate("float2x2 a = float2x2(1, 2, 3, 4) * 2 + 1; return a[1][1];"), 9);
}

TEST(Matrices, TheInverseUndoes) {
    const std::string m =
        "float4x4 m = float4x4(2, 0, 1, 0, 1, 3, 2, 0, 0, 1, 4, 1, 0, 0, 0, 1); "
        "float4x4 one = mul(m, inverse(m)); ";
    for (int32_t i = 0; i < 4; ++i) {
        for (int32_t j = 0; j < 4; ++j) {
            EXPECT_NEAR(evaluate(m + "return one[i][j];", 0, 0, 0, i, j), i == j ? 1 : 0, 1e-6);
        }
    }
}

TEST(Switch, RunsOneSection) {
    const std::string body =
        "float r = 1; switch (i) { case 0: r = 10; break; case 1: case 2: if (j > 0) break; r = "
        "20; "
        "break; default: r = 30; break; case 5: return 50; } return r + 0.5;";
    EXPECT_EQ(evaluate(body, 0, 0, 0, 0), 10.5f);
    EXPECT_EQ(evaluate(body, 0, 0, 0, 1), 20.5f);
    EXPECT_EQ(evaluate(body, 0, 0, 0, 2), 20.5f);
    EXPECT_EQ(evaluate(body, 0, 0, 0, 2, 1), 1.5f);
    EXPECT_EQ(evaluate(body, 0, 0, 0, 3), 30.5f);
    EXPECT_EQ(evaluate(body, 0, 0, 0, 5), 50.0f);
}

TEST(Switch, BreakLeavesItAndContinueTheLoopAround) {
    const std::string body =
        "float r = 0; for (int k = 0; k < 5; k++) { switch (k + i) { case 1: continue; case 3: "
        "break; "
        "default: r += 1; break; } r += 10; } return r;";
    EXPECT_EQ(evaluate(body), 3 + 40);               // k = 0 … 4: 1 continues, 3 adds 10 only
    EXPECT_EQ(evaluate(body, 0, 0, 0, 10), 5 + 50);  // all in `default`
}

TEST(Compositions, OverFillsWhatIsLeftFree) {
    const auto amounts = [](float top, float bottom) {
        const ir::Fablet fablet = compile(
            "fablet A { @uniform { float x, y; Material a, b; }\n@Volume() { "
            "MaterialComposition t, u; t.Set(a, x); u.Set(b, y); return over(t, u); } }");
        MapEnvironment env;
        env.set(OPENFAB_ARG_UNIFORM, 0, 0, top);
        env.set(OPENFAB_ARG_UNIFORM, 1, 0, bottom);
        const std::vector<uint32_t> out = interp::evaluate(fablet.volume, env);
        return std::pair{as_float(out[0]), as_float(out[1])};
    };
    EXPECT_EQ(amounts(0.25f, 2), (std::pair{0.25f, 1.5f}));
    EXPECT_EQ(amounts(1, 2), (std::pair{1.0f, 0.0f}));
    EXPECT_EQ(amounts(3, 2), (std::pair{3.0f, 0.0f}));
    EXPECT_EQ(amounts(-1, 2), (std::pair{-1.0f, 2.0f}));
}

TEST(Compositions, InArraysAndStructs) {
    const ir::Fablet fablet = compile(
        "fablet A { @uniform { int i; Material a, b; }\n"
        "struct Two { MaterialComposition top, bottom; };\n"
        "@Volume() { MaterialComposition list[3]; int k = i; list[k++].Set(a, 5); "
        "list[k].Add(b, 1); Two two; two.top = list[1]; two.bottom.Set(b, list[2].Get(b)); "
        "return two.top + two.bottom; } }");
    MapEnvironment env;
    env.set(OPENFAB_ARG_UNIFORM, 0, 0, 1);
    const std::vector<uint32_t> out = interp::evaluate(fablet.volume, env);
    EXPECT_EQ(as_float(out[0]), 5);
    EXPECT_EQ(as_float(out[1]), 1);
}

TEST(Textures, AVaryingOneIsLookedUpByThoseWhoMeanIt) {
    const ir::Fablet fablet = compile(
        "fablet A { @uniform { ImageTexture2D t[3]; int i; Material m; }\n@Volume() { "
        "MaterialComposition mc; mc.Set(m, t[i].Sample1(0.5, 0.5, 0, 0)); return mc; } }");
    int samples = 0;
    for (const ir::Instr& instr : fablet.volume.instrs)
        samples += instr.op == ir::Op::kSample ? 1 : 0;
    EXPECT_EQ(samples, 3);
    for (int32_t i = 0; i < 3; ++i) {
        MapEnvironment env;
        for (int k = 0; k < 3; ++k)
            env.pictures.emplace_back(1, 1, 1, std::vector<float>{static_cast<float>(k + 1)}, 0, 0);
        env.set(OPENFAB_ARG_UNIFORM, 0, 0, i);
        EXPECT_EQ(as_float(interp::evaluate(fablet.volume, env)[0]), static_cast<float>(i + 1));
        EXPECT_EQ(env.sample_count, 1);
    }
}

/// The printfs that are compiled in, each with its number of values.
std::vector<std::pair<std::string, size_t>> prints_of(const std::string& body, bool on) {
    source::SourceManager sources;
    diag::Sink sink;
    const uint32_t file = sources.add(
        "test.fl",
        "fablet A { @uniform { float x; int i; Material m; }\n@Volume(@varying { VolumeAttributes "
        "attr }) {" +
            body + " MaterialComposition mc; return mc; } }");
    const std::optional<ir::Module> module =
        frontend::compile_to_ir(sources, file, sink, {.enable_printf = on});
    EXPECT_TRUE(module.has_value()) << diag::render_text(sink, sources);
    std::vector<std::pair<std::string, size_t>> out;
    if (!module) return out;
    const ir::Stage& volume = module->fablets[0].volume;
    EXPECT_EQ(ir::verify(volume), "");
    for (const ir::Instr& instr : volume.instrs) {
        if (instr.op != ir::Op::kPrintf) continue;
        out.emplace_back(volume.printfs[instr.a].format, instr.args.size() - 1);
    }
    return out;
}

TEST(Prints, AreCompiledInWhereTheyAreAskedFor) {
    using List = std::vector<std::pair<std::string, size_t>>;
    const std::string body =
        "printf(\"%d\\n%5.2f%%\", i, attr.voxelCenter); if (i > 0) assert(x > 1); assert(true);"
        "assert(x < 1, \"x %g\", x);";
    EXPECT_EQ(prints_of(body, false), List{});
    EXPECT_EQ(prints_of(body, true),
              (List{{"%d\n%5.2f %5.2f %5.2f%%", 4}, {"assertion failed", 0}, {"x %g", 1}}));
    // Equal values print two lines.
    EXPECT_EQ(prints_of("printf(\"a\"); printf(\"a\");", true).size(), 2u);
    EXPECT_EQ(prints_of("for (int k = 0; k < 3; k++) printf(\"a\");", true).size(), 3u);
}

}  // namespace
}  // namespace openfab::testing

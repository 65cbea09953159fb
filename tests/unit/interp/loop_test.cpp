// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Loops with data-dependent trip counts: the same text in OpenFL and in C++.
#include <algorithm>
#include <cmath>
#include <string>

#include "tests/unit/interp/fixture.h"

namespace openfab::testing {
namespace {

size_t count_loops(const ir::Stage& stage) {
    return static_cast<size_t>(
        std::count_if(stage.instrs.begin(), stage.instrs.end(),
                      [](const ir::Instr& instr) { return instr.op == ir::Op::kLoop; }));
}

ir::Fablet compile_body(const std::string& functions, const std::string& body) {
    return compile("fablet A { @uniform { float x, y, z; int i, j; Material m; }\n" + functions +
                   "float f() {" + body +
                   "}\n@Volume() { MaterialComposition mc; mc.Set(m, f()); return mc; } }");
}

float run(const ir::Fablet& fablet, float x, int32_t i, int32_t j = 0) {
    MapEnvironment env;
    for (int32_t k = 0; k < 3; ++k)
        env.set(OPENFAB_ARG_UNIFORM, k, 0, x);
    env.set(OPENFAB_ARG_UNIFORM, 3, 0, i);
    env.set(OPENFAB_ARG_UNIFORM, 4, 0, j);
    const std::vector<uint32_t> out = interp::evaluate(fablet.volume, env);
    EXPECT_EQ(out.size(), 1u);
    return out.empty() ? -1.0f : as_float(out[0]);
}

TEST(RealLoop, BreakContinueAndReturn) {
    const ir::Fablet fablet = compile_body("",
                                           "float s = 0;"
                                           "int n = min(i, 40);"
                                           "for (int k = 0; k < n; ++k) {"
                                           "    if (k == 3) continue;"
                                           "    if (s > x) break;"
                                           "    if (k == 30) return -1;"
                                           "    s += k * 0.5;"
                                           "}"
                                           "return s;");
    EXPECT_EQ(count_loops(fablet.volume), 1u);
    const auto expected = [](float x, int32_t i) {
        float s = 0;
        const int32_t n = std::min(i, 40);
        for (int32_t k = 0; k < n; ++k) {
            if (k == 3) continue;
            if (s > x) break;
            if (k == 30) return -1.0f;
            s += static_cast<float>(k) * 0.5f;
        }
        return s;
    };
    for (const float x : {-1.0f, 0.0f, 10.0f, 1000.0f}) {
        for (const int32_t i : {-5, 0, 1, 3, 4, 7, 30, 31, 100})
            EXPECT_EQ(run(fablet, x, i), expected(x, i)) << x << ' ' << i;
    }
}

TEST(RealLoop, NestedWithInnerReturn) {
    const ir::Fablet fablet = compile_body("",
                                           "float s = 0;"
                                           "for (int a = 0; a < min(i, 50); ++a) {"
                                           "    int b = 0;"
                                           "    do {"
                                           "        s += a * 10 + b;"
                                           "        if (s > x) return s;"
                                           "        b += 2;"
                                           "    } while (b < min(j, 33));"
                                           "    if (a == 5) continue;"
                                           "    s -= 1;"
                                           "}"
                                           "return -s;");
    EXPECT_EQ(count_loops(fablet.volume), 2u);
    const auto expected = [](float x, int32_t i, int32_t j) {
        float s = 0;
        for (int32_t a = 0; a < std::min(i, 50); ++a) {
            int32_t b = 0;
            do {
                s += static_cast<float>(a * 10 + b);
                if (s > x) return s;
                b += 2;
            } while (b < std::min(j, 33));
            if (a == 5) continue;
            s -= 1;
        }
        return -s;
    };
    for (const float x : {-1.0f, 50.0f, 1e6f}) {
        for (const int32_t i : {0, 1, 6, 9}) {
            for (const int32_t j : {-1, 2, 9})
                EXPECT_EQ(run(fablet, x, i, j), expected(x, i, j)) << x << ' ' << i << ' ' << j;
        }
    }
}

TEST(RealLoop, InFunctionsBranchesAndConditions) {
    const ir::Fablet fablet = compile_body(
        "int steps(int from, inout float s) {"
        "    int n = 0;"
        "    while (true) {"
        "        if (n >= 100 || n >= from) return n;"
        "        s = s * 0.5 + n;"
        "        n++;"
        "    }"
        "    return n;"
        "}\n",
        "float s = x; float t = 0;"
        "if (i > 2 && steps(min(j, 9), s) > 3) { t = steps(min(i, 12), s); } else { t = 0.25; }"
        "return s + t;");
    const auto steps = [](int32_t from, float* s) {
        int32_t n = 0;
        for (; n < 100 && n < from; ++n)
            *s = *s * 0.5f + static_cast<float>(n);
        return n;
    };
    for (const int32_t i : {0, 2, 3, 8}) {
        for (const int32_t j : {-3, 3, 4, 20}) {
            float s = 1.5f;
            float t = 0.25f;
            if (i > 2 && steps(std::min(j, 9), &s) > 3) {
                t = static_cast<float>(steps(std::min(i, 12), &s));
            }
            EXPECT_EQ(run(fablet, 1.5f, i, j), s + t) << i << ' ' << j;
        }
    }
}

TEST(RealLoop, ManyConstantTrips) {
    const ir::Fablet fablet =
        compile_body("", "float s = x; for (int k = 0; k < 5000; ++k) s = s * 0.75 + k; return s;");
    EXPECT_EQ(count_loops(fablet.volume), 1u);
    float s = 2;
    for (int k = 0; k < 5000; ++k)
        s = s * 0.75f + static_cast<float>(k);
    EXPECT_EQ(run(fablet, 2, 0), s);
}

TEST(RealLoop, FewConstantTripsAreUnrolled) {
    const ir::Fablet fablet = compile_body(
        "", "float s = x; for (int k = 0; k < 8; ++k) { if (s > 9) break; s += k; } return s;");
    EXPECT_EQ(count_loops(fablet.volume), 0u);
    EXPECT_EQ(run(fablet, 2, 0), 12.0f);
}

// All of it folds to one constant, which would take as many steps as the loops have trips.
TEST(RealLoop, LongNestsOfConstantTripsAreNotUnrolled) {
    const ir::Fablet fablet = compile_body("",
                                           "float s = 0;"
                                           "for (int a = 0; a < 64; ++a)"
                                           "    for (int b = 0; b < 64; ++b)"
                                           "        for (int c = 0; c < 256; ++c) s += a * b * c;"
                                           "return s;");
    EXPECT_GE(count_loops(fablet.volume), 1u);
    float expected = 0;
    for (int a = 0; a < 64; ++a) {
        for (int b = 0; b < 64; ++b) {
            for (int c = 0; c < 256; ++c)
                expected += static_cast<float>(a * b * c);
        }
    }
    EXPECT_EQ(run(fablet, 0, 0), expected);
}

TEST(RealLoop, ConstantsAreUnrolledFurther) {
    const std::string sum =
        "float sum() {"
        "    float s = 0;"
        "    for (int a = 0; a < 200; ++a)"
        "        for (int b = 0; b < 250; ++b) s += 1;"
        "    return s;"
        "}";
    EXPECT_GE(count_loops(compile_body(sum, "return sum();").volume), 1u);
    const ir::Fablet constant =
        compile_body(sum + "const float SUM = sum();",
                     "float s = 0; for (int a = 0; a < 4; ++a) s += SUM; return s;");
    EXPECT_EQ(count_loops(constant.volume), 0u);
    EXPECT_EQ(run(constant, 0, 0), 200000);
}

TEST(RealLoop, CountersOfAllKinds) {
    const char* const loops[] = {
        "for (float t = 0; t < 1000; t += 0.125) s += t;",
        "for (int n = clamp(i, 0, 300); n > 0; n--) s += n;",
        "int n = clamp(i, 0, 300); while (n-- > 0) s += n;",
        "for (uint n = 3; n < 4000; n += 7) s += n;",
        "for (int n = 0; n < (i & 255); n += s > 9 ? 2 : 1) s += n;",
        "for (int n = 0; n < int(clamp(x, 0, 90)); ++n) { if (s > 100) continue; s += n; }",
        "for (int n = 0; !(n >= i % 100 || s > 40); ++n) s += n;",
    };
    for (const char* text : loops) {
        const ir::Fablet fablet =
            compile_body("", std::string("float s = 0;") + text + "return s;");
        EXPECT_EQ(count_loops(fablet.volume), 1u) << text;
        run(fablet, 3, 70);
    }
}

std::string errors_of(const std::string& body) {
    source::SourceManager sources;
    diag::Sink sink;
    const uint32_t file = sources.add(
        "test.fl", "fablet A { @uniform { float x; int i; Material m; }\nfloat f() {" + body +
                       "}\n@Volume() { MaterialComposition mc; mc.Set(m, f()); return mc; } }");
    frontend::compile_to_ir(sources, file, sink);
    return diag::render_text(sink, sources);
}

TEST(RealLoop, ArraysStartAtZero) {
    const ir::Fablet fablet = compile_body(
        "", "float a[40]; for (int k = 0; k < min(i, 40); ++k) a[k] += k + 1; return a[j];");
    for (const int32_t j : {0, 5, 6, 39})
        EXPECT_EQ(run(fablet, 0, 6, j), j < 6 ? static_cast<float>(j + 1) : 0.0f) << j;
}

TEST(RealLoop, WithoutABoundIsAnError) {
    for (const char* text : {
             "float s = 0; for (int k = 0; k < i; ++k) s += k; return s;",
             "float s = x; while (s > 1) s *= 0.5; return s;",
             "int k = 0; for (;;) { k += i; if (k > 100) break; } return k;",
             "int n = 0; for (int k = 0; k < min(i, 9); k += i) n++; return n;",
             "int n = 0; for (int k = 0; k != min(i, 9); ++k) n++; return n;",
             "float s = 0; for (float t = 1e8; t < 1e8 + 4000; t += 1) s += 1; return s;",
         }) {
        EXPECT_NE(errors_of(text).find("[loop-unbounded]"), std::string::npos) << text;
    }
}

TEST(RealLoop, DefiniteAssignment) {
    EXPECT_EQ(errors_of("float s; int k = 0; do { s = k; k++; } while (k < min(i, 99)); return s;"),
              "");
    EXPECT_NE(errors_of("float s; for (int k = 0; k < min(i, 99); ++k) s = k; return s;"), "");
    EXPECT_EQ(errors_of("float s; if (i > 0) s = 1; float t = 0;"
                        "if (i > 0) { for (int k = 0; k < min(i, 99); ++k) t += s; } return t;"),
              "");
}

}  // namespace
}  // namespace openfab::testing

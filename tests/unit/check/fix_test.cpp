// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Applying the fix of a diagnostic repairs the program.

#include <gtest/gtest.h>

#include <algorithm>

#include "compiler/diag/render.h"
#include "compiler/frontend/frontend.h"

namespace openfab::testing {
namespace {

std::string apply(std::string text, std::vector<diag::Edit> edits) {
    std::stable_sort(edits.begin(), edits.end(), [](const diag::Edit& a, const diag::Edit& b) {
        return a.span.begin > b.span.begin;
    });
    for (const diag::Edit& edit : edits)
        text.replace(edit.span.begin, edit.span.end - edit.span.begin, edit.text);
    return text;
}

/// Returns the text with the fix of the first diagnostic, and whether it was the only one.
std::string fixed(const std::string& text) {
    source::SourceManager sources;
    diag::Sink sink;
    (void)frontend::compile_to_ir(sources, sources.add("t.fl", text), sink);
    const std::vector<diag::Diagnostic> found = sink.sorted();
    EXPECT_EQ(found.size(), 1u) << diag::render_text(sink, sources);
    if (found.empty()) return text;
    EXPECT_FALSE(found[0].fix.empty()) << diag::render_text(sink, sources);
    return apply(text, found[0].fix);
}

std::string program(const std::string& body) {
    return "fablet A { @uniform { Material white; float3 p; }\n"
           "@Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; " +
           body + " return mc; } }";
}

TEST(Fixes, MendTheProgram) {
    for (const char* body :
         {"int n = p.x * 2;", "float2 q = p + 1;", "float f = -p;", "mc.Sett(white, 1);",
          "mc.Set(whte, 1);", "flaot f = 1;", "vec3 v = 1;", "float f = mix(1, 2, 0.5);",
          "float3 v = vec3(1, 2, 3);", "float f = abss(1.0);", "float3 v = attr.voxelCentre;",
          "mc.Set(white, 1)", "float4x4 m = 1; float2x2 n = m;",
          "int i = 3; @bond(4) while (i < p.x) i++;", "mc.Set(0.5, white);",
          "int k = 1; if (k = 2) mc.Set(white, 1);", "int k = 1; k == 2; mc.Set(white, k);",
          "bool b = True;",
          // Of other languages.
          "bool b = true and false;", "if (p.x > 0 or p.y > 0) mc.Set(white, 1);",
          "bool b = not true;", "bool b = not(p.x > 0);", "x := 3.0; mc.Set(white, x);",
          "float x := 3.0;", "if (p.x > 0) { } elif (p.y > 0) { }", "x = 1.0; mc.Set(white, x);",
          "for (i = 0; i < 3; i++) mc.Set(white, i);", "float x[3] = [1, 2, 3];",
          "float x[3] = float[3](1, 2, 3);", "float[3] x = {1, 2, 3};", "float[] x = {1, 2, 3};",
          "for x in range(10) { mc.Set(white, x); }", "for (int x in range(2, 8)) { }",
          "bool3 m = (p > 0) && (p < 1);", "float x = 1/2;", "float3 q = p.stp;", "float x = p.X;",
          "float x = p.y();", "float3 n = p.normalize();", "float x = p.x.clamp(0, 1);",
          "float a[3] = {1, 2, 3}; int n = a.length();", "float a[3] = {1, 2, 3}; int n = len(a);",
          "auto x = p.x;", "let x = float2(1, 2);", "float3x3 m = float3x3(1);",
          "float3x3 m = (float3x3)1; float3 v = m * p;", "float3 v{1, 2, 3};", "float3 v(1, 2, 3);",
          "float3 v = float3{1, 2, 3};", "float3 v = new float3(1, 2, 3);",
          "[unroll] for (int i = 0; i < 3; ++i) { }", "float x = attr->voxelCenter.x;",
          "float x = std::sin(1.0);", "bool b = p.x <> 1;", "bool b = p.x !== 1;",
          "mc.Set(white, 50%);", "float x = 1.0d;", "float x = 1,5;", "float my-name = 1;",
          "x: float = 1; mc.Set(white, x);", "int i = int 2.5;", "float x = abs 3;",
          "float x = max(1, 2));", "float x = max(1 2);", "float x = max(1, 2; mc.Set(white, x);",
          "float x 5;", "float a b;", "if p.x > 0 { mc.Set(white, 1); }", "float x = 3 \u2212 1;",
          "float x = 3 \u00d7 2;", "float x =\u00a01;", "bool b = p.x \u2264 2;",
          "printf(\u201chi\u201d);", "printf('hi');", "printf(p);", "float x = PI;", "Float x = 1;",
          "float1 x = 1;", "float x = 2^3;", "float x = srgb_to_linear(p).x;",
          "float3 c = hsv2rgb(p);", "float x = gyroid(p, 1);", "float x = sdSphere(p, 1);",
          "float x = opUnion(p.x, 1);", "float3 x = where(p > 0, p, 0);"}) {
        const std::string text = fixed(program(body));
        source::SourceManager sources;
        diag::Sink sink;
        (void)frontend::compile_to_ir(sources, sources.add("t.fl", text), sink);
        EXPECT_EQ(diag::render_text(sink, sources), "") << body;
    }
}

/// Code of other languages outside of a stage.
TEST(Fixes, MendADeclaration) {
    const std::string volume =
        " @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; mc.Set(m, 1); "
        "return mc; } }";
    const std::string right = "fablet A { @uniform { Material m; }" + volume;
    EXPECT_EQ(fixed("fablet A { uniform Material m;" + volume),
              "fablet A { @uniform { Material m; }" + volume);
    EXPECT_EQ(fixed("fablet A { @uniform Material m;" + volume),
              "fablet A { @uniform { Material m; }" + volume);
    EXPECT_EQ(fixed("shader A { @uniform { Material m; }" + volume), right);
    EXPECT_EQ(fixed("Fablet A { @uniform { Material m; }" + volume), right);
    source::SourceManager sources;
    diag::Sink sink;
    (void)frontend::compile_to_ir(sources, sources.add("t.fl", right), sink);
    EXPECT_EQ(diag::render_text(sink, sources), "");
}

/// Declarations and lines of other languages around a fablet that is right.
TEST(Fixes, MendAFile) {
    const std::string right =
        "fablet A { @uniform { Material m; } @Volume(@varying { VolumeAttributes attr }) { "
        "MaterialComposition mc; mc.Set(m, 1); return mc; } }";
    for (const char* before : {"#include \"color.fl\"\n",
                               "#include <math.h>\n",
                               "#define WIDTH 2.5\n",
                               "#define COUNT 3\n",
                               "# a comment\n",
                               "import color.fl;\n",
                               "import lattice.*;\n",
                               "import lattice as l;\n",
                               "import \"lattice\";\n",
                               "from lattice import gyroid;\n",
                               "import color, lattice;\n",
                               "inline float f(float x) { return x; }\n",
                               "class S { float x; };\n",
                               "struct S { float x; }\n",
                               "enum class E { A, B };\n",
                               "enum E : int { A, B };\n",
                               "enum E { A; B };\n",
                               "void f(float &x) { x = 1; }\n",
                               "void f(float* x) { x = 1; }\n",
                               "void g(out float x) { x = 1; } void f() { float x; g(out x); }\n",
                               "void g(out float x) { x = 1; } void f() { float x; g(&x); }\n"}) {
        const std::string text = fixed(before + right);
        source::SourceManager sources;
        diag::Sink sink;
        (void)frontend::compile_to_ir(sources, sources.add("t.fl", text), sink);
        EXPECT_EQ(diag::render_text(sink, sources), "") << before;
    }
}

TEST(Fixes, MendUniforms) {
    for (const char* uniform : {"uniform float x;", "const float x = 5;", "Texture2D<float4> x;",
                                "Texture3D x;", "float[3] x;", "float x = 5 [[ min = 0 ]];",
                                "float x = 5 [[ float min = 0; float max = 9 ]];"}) {
        const std::string text =
            std::string("fablet A { @uniform { Material m; ") + uniform +
            " } @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; "
            "mc.Set(m, 1); return mc; } }";
        std::string mended = text;
        for (int round = 0; round < 2;
             ++round) {  // of a type with parameters the name is wrong, too
            source::SourceManager sources;
            diag::Sink sink;
            (void)frontend::compile_to_ir(sources, sources.add("t.fl", mended), sink);
            const std::vector<diag::Diagnostic> found = sink.sorted();
            if (!found.empty()) mended = apply(mended, found[0].fix);
        }
        source::SourceManager sources;
        diag::Sink sink;
        (void)frontend::compile_to_ir(sources, sources.add("t.fl", mended), sink);
        EXPECT_NE(mended, text);
        EXPECT_EQ(diag::render_text(sink, sources), "") << uniform;
    }
}

TEST(Fixes, AForgottenReturn) {
    EXPECT_EQ(
        fixed("fablet A {\n    @uniform { Material m; }\n    @Volume(@varying { VolumeAttributes "
              "attr })\n    {\n        MaterialComposition mc;\n        mc.Set(m, 1);\n    }\n}\n"),
        "fablet A {\n    @uniform { Material m; }\n    @Volume(@varying { VolumeAttributes "
        "attr })\n    {\n        MaterialComposition mc;\n        mc.Set(m, 1);\n        return "
        "mc;\n    }\n}\n");
}

/// A directive goes on behind a backslash.
TEST(Fixes, ADirectiveOfTwoLinesIsOneMistake) {
    source::SourceManager sources;
    diag::Sink sink;
    (void)frontend::compile_to_ir(sources,
                                  sources.add("t.fl",
                                              "#define WIDTH 2 \\\n + 1\nfablet A { @Volume() { "
                                              "MaterialComposition mc; return mc; } }"),
                                  sink);
    EXPECT_EQ(sink.errors(), 1u) << diag::render_text(sink, sources);
}

TEST(Fixes, AMissingMark) {
    EXPECT_EQ(fixed("fablet A { Volume() { MaterialComposition mc; return mc; } }"),
              "fablet A { @Volume() { MaterialComposition mc; return mc; } }");
}

}  // namespace
}  // namespace openfab::testing

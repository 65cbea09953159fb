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
          "bool b = True;"}) {
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

TEST(Fixes, AMissingMark) {
    EXPECT_EQ(fixed("fablet A { Volume() { MaterialComposition mc; return mc; } }"),
              "fablet A { @Volume() { MaterialComposition mc; return mc; } }");
}

}  // namespace
}  // namespace openfab::testing

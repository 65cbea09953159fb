// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Definite assignment and return: a table of programs and the diagnostic ids of each. Complete
// programs give none; incomplete ones are an error where the language requires every path
// (`return`, `out`); for variables, an error if certain, else a warning.

#include <gtest/gtest.h>

#include "compiler/diag/render.h"
#include "compiler/frontend/frontend.h"

namespace openfab::testing {
namespace {

struct Case {
    const char* body;
    const char* ids;  ///< in order, each preceded by a blank
};

void expect_ids(const std::string& program, const Case& item) {
    source::SourceManager sources;
    diag::Sink sink;
    (void)frontend::compile_to_ir(sources, sources.add("t.fl", program), sink);
    std::string ids;
    for (const diag::Diagnostic& d : sink.sorted())
        ids += std::string(" ") + diag::id_text(d.id);
    EXPECT_EQ(ids, item.ids) << item.body << "\n" << diag::render_text(sink, sources);
}

std::string volume(const std::string& file_level, const std::string& body) {
    return file_level +
           "\nfablet A { @uniform { Material m; int k; float x; int n; }\n"
           "@Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; " +
           body + " return mc; } }";
}

constexpr Case kReturns[] = {
    {"switch (k) { case 0: return 1; case 1: return 2; default: return 3; }", ""},
    {"switch (k) { default: return 3; case 0: return 1; case 1: return 2; }", ""},
    {"switch (k) { case 0: return 1; default: return 3; case 1: return 2; }", ""},
    {"switch (k) { case 0: case 1: return 1; case 2: default: return 3; }", ""},
    {"switch (k) { case 0: return 1; default: return 3; }", ""},
    {"switch (k) { default: return 3; }", ""},
    {"switch (k) { case 0: { return 1; } default: { if (x > 0) return 3; else return 4; } }", ""},
    {"switch (k) { case 0: if (x > 0) break; return 1; default: return 2; } return 3;", ""},
    {"switch (k) { case 0: if (x > 0) return 1; break; default: return 2; } return 3;", ""},
    {"switch (k) { case 0: if (x > 0) return 1; if (x < 0) break; return 4; default: return 2; }"
     " return 3;",
     ""},
    {"switch (k) { case 0: switch (int(x)) { case 0: return 1; default: return 2; }"
     " case 1: return 3; default: return 4; }",
     ""},
    {"switch (k) { case 0: return 1; default: break; } return 2;", ""},
    {"switch (k > 0) { case 0: return 1; default: return 2; }", ""},
    {"if (x > 0) return 1; else return 2;", ""},
    {"if (x > 0) return 1; return 2;", ""},
    {"if (x > 0) { if (k > 0) return 1; else return 2; } else { return 3; }", ""},
    {"if (x > 0) { if (k > 0) return 1; } else return 3; return 2;", ""},
    {"if (k == 0) return 1; else if (k == 1) return 2; else return 3;", ""},
    {"if (k > 2) return 1; if (k <= 2) return 2;", ""},
    {"do { return 1; } while (x > 0);", ""},
    {"do { if (x > 0) return 1; return 2; } while (true);", ""},
    {"do { switch (k) { case 0: return 1; default: return 2; } } while (true);", ""},
    {"for (;;) { if (x > 0) return 1; if (k > 0) break; return 2; } return 3;", ""},
    {"while (true) { if (x > 0) break; if (k > 0) break; return 2; } return 3;", ""},
    {"while (true) { switch (k) { case 0: return 1; default: return 2; } }", ""},
    {"for (int i = 0; i < 4; ++i) { if (i == 3) return 1; }", ""},
    {"for (int i = 0; i < 400; ++i) { if (x > i) return 1; } return 2;", ""},
    {"@bound(500) while (x > k) { return 1; } return 2;", ""},
    // Not on every path.
    {"switch (k) { case 0: return 1; case 1: return 2; }", " missing-return"},
    {"switch (k) { case 0: return 1; default: break; }", " missing-return"},
    {"switch (k) { case 0: if (x > 0) return 1; break; default: return 2; }", " missing-return"},
    {"switch (k) { case 0: return 1; default: if (x > 0) break; return 2; }", " missing-return"},
    {"if (x > 0) return 1;", " missing-return"},
    {"if (x > 0) { if (k > 0) return 1; } else return 3;", " missing-return"},
    {"if (x > 0) return 1; else if (x <= 0) return 2;", " missing-return"},  // NaN
    {"while (x > k) return 1;", " missing-return"},
    {"@bound(8) while (x > k) { return 1; }", " missing-return"},
    {"for (int i = 0; i < min(k, 8); ++i) return 1;", " missing-return"},
    {"for (int i = 0; i < 400; ++i) { if (x > i) return 1; }", " missing-return"},
    {"", " missing-return"},
};

TEST(Flow, EveryPathReturns) {
    for (const Case& item : kReturns) {
        const std::string function = "float f(int k, float x) { " + std::string(item.body) + " }";
        expect_ids(volume(function, "mc.Set(m, f(k, x));"), item);
    }
}

constexpr Case kOutputs[] = {
    {"switch (k) { case 0: v = 1; break; default: v = 2; }", ""},
    {"switch (k) { case 0: v = 1; break; case 1: v = 3; break; default: v = 2; }", ""},
    {"switch (k) { default: v = 2; break; case 0: v = 1; break; case 1: v = 3; break; }", ""},
    {"switch (k) { case 0: v = 1; break; default: v = 2; break; }", ""},
    {"switch (k) { case 0: v = 1; return; default: v = 2; }", ""},
    {"switch (k) { case 0: if (x > 0) { v = 1; break; } v = 2; break; default: v = 3; }", ""},
    {"switch (k) { case 0: break; default: v = 3; return; } v = 1;", ""},
    {"switch (k) { case 0: switch (int(x)) { case 1: v = 1; break; default: v = 2; } break;"
     " default: v = 3; }",
     ""},
    {"if (k == 0) v = 1; else v = 2;", ""},
    {"if (k == 0) { v = 1; return; } v = 2;", ""},
    {"if (k == 0) v = 1; if (k != 0) v = 2;", ""},
    {"if (k < 0) v = 1; else if (k == 0) v = 2; else v = 3;", ""},
    {"v = x > 0 ? 1 : 2;", ""},
    {"x > 0 && (v = 1) > 0; v = 2;", ""},
    {"do { v = x; } while (v < k && k < 0);", " loop-unbounded"},
    {"@bound(400) do { v = x; } while (x > k);", ""},
    {"@bound(400) do { if (x > 0) { v = 1; break; } if (k > 0) { v = 2; continue; } v = 3; }"
     " while (x > k);",
     ""},
    {"for (int i = 0; i < 400; ++i) { v = i; if (x > i) break; }", ""},
    {"for (int i = 0; i < 400; ++i) { if (x > i) { v = 1; break; } v = 2; }", ""},
    {"for (int i = 0; i < 4; ++i) { if (i == 2) v = 1; }", ""},
    {"while (true) { if (x > 0) { v = 1; break; } if (k > 0) { v = 2; break; } v = 3; break; }",
     ""},
    // Not on every path.
    {"switch (k) { case 0: v = 1; break; case 1: v = 2; }", " output-unassigned"},
    {"switch (k) { case 0: v = 1; break; default: break; }", " output-unassigned"},
    {"switch (k) { case 0: break; v = 1; default: v = 2; }", " output-unassigned"},
    {"switch (k) { case 0: if (x > 0) break; v = 1; break; default: v = 2; }",
     " output-unassigned"},
    {"if (k == 0) v = 1;", " output-unassigned"},
    {"if (k == 0) return; v = 2;", " output-unassigned"},
    {"x > 0 && (v = 1) > 0;", " output-unassigned"},
    {"x > 0 || (v = 1) > 0;", " output-unassigned"},
    {"for (int i = 0; i < min(k, 8); ++i) v = i;", " output-unassigned"},
    {"for (int i = 0; i < 400; ++i) { if (x > i) break; v = 1; }", " output-unassigned"},
    {"for (int i = 0; i < 400; ++i) { if (x > i) continue; v = 1; }", " output-unassigned"},
    {"", " output-unassigned"},
};

TEST(Flow, EveryPathAssignsAnOutput) {
    for (const Case& item : kOutputs) {
        const std::string function =
            "void g(int k, float x, out float v) { " + std::string(item.body) + " }";
        expect_ids(volume(function, "float v; g(k, x, v); mc.Set(m, v);"), item);
        // Of the surface stage, whose paths end with `return`.
        std::string body = item.body;
        for (size_t at = 0; (at = body.find("return;", at)) != std::string::npos; at += 9)
            body.replace(at, 7, "return 0;");
        expect_ids(
            "fablet A { @uniform { int k; float x; Material m; }\n"
            "@Surface(@varying { out float v }) { " +
                body +
                " return 0; }\n"
                "@Volume(@varying { @nearest float v }) { MaterialComposition mc; "
                "mc.Set(m, v); return mc; } }",
            item);
    }
}

constexpr Case kVariables[] = {
    {"float v; switch (k) { case 0: v = 1; break; default: v = 2; } mc.Set(m, v);", ""},
    {"float v; switch (k) { case 0: v = 1; break; case 1: v = 3; break; default: v = 2; }"
     " mc.Set(m, v);",
     ""},
    {"float v; switch (k) { case 0: return mc; default: v = 2; } mc.Set(m, v);", ""},
    {"float v; if (k == 1) v = 2; else return mc; mc.Set(m, v);", ""},
    {"float v; if (k == 1) v = 2; if (k == 1) mc.Set(m, v);", ""},
    {"float v; if (k == 1) v = 2; if (k != 1) return mc; mc.Set(m, v);", ""},
    {"float v; if (k > 1) v = 2; if (1 < k) mc.Set(m, v);", ""},
    {"float v; if (n > 0) for (int i = 0; i < min(n, 8); ++i) v = i; else v = 0; mc.Set(m, v);",
     ""},
    {"float v; if (n >= 0) for (int i = 0; i < min(n, 8); ++i) v = i; else v = 0; mc.Set(m, v);",
     " maybe-uninitialized"},
    {"float v; for (int i = 0; i < 300; ++i) v = i; mc.Set(m, v);", ""},
    {"float v; for (int i = 0; i < 300; ++i) { if (x > i) v = 1; else v = 2; } mc.Set(m, v);", ""},
    {"float v; @bound(300) do v = x; while (x > k); mc.Set(m, v);", ""},
    {"float v; for (int i = 0; i < 300; ++i) { switch (k) { case 0: v = 1; continue;"
     " default: v = 2; } } mc.Set(m, v);",
     ""},
    {"float v; int i = 0; @bound(300) while (i < n) { v = x; ++i; } if (n > 0) mc.Set(m, v);", ""},
    {"float s; for (int i = 0; i < min(n, 8); ++i) s = i; mc.Set(m, s);", " maybe-uninitialized"},
    {"float s; for (int i = 0; i < 300; ++i) if (x > i) s = i; mc.Set(m, s);",
     " maybe-uninitialized"},
    {"float3 b; float d = 9; for (int i = 0; i < 300; ++i) if (i < d) { d = x; b = i; }"
     " mc.Set(m, b.x);",
     " maybe-uninitialized"},
    // What earlier trips do is not followed.
    {"float p; for (int i = 0; i < 300; ++i) { if (i > 0) mc.Add(m, p); p = x; }",
     " maybe-uninitialized"},
    {"float p; for (int i = 0; i < 300; ++i) { if (i > 0) mc.Add(m, p); if (i > 0) p = x; }",
     " maybe-uninitialized"},
    {"float p; for (int i = 0; i < 300; ++i) { if (i > n) mc.Add(m, p); p = x; }",
     " maybe-uninitialized"},
    {"float p; for (int i = 0; i < 3; ++i) { if (i > 0) mc.Add(m, p); p = x; }", ""},
    {"float s; if (n > 3) s = 1; mc.Set(m, s);", " maybe-uninitialized"},
    {"float s; x > 0 && (s = 1) > 0; mc.Set(m, s);", " maybe-uninitialized"},
    {"float s; if (n > 3) s = 1; mc.Set(m, s); mc.Add(m, s);", " maybe-uninitialized"},
    {"float s; for (int i = 0; i < min(n, 8); ++i) { for (int j = 0; j < min(n, 8); ++j) s = j; }"
     " mc.Set(m, s);",
     " maybe-uninitialized"},
    // Certain.
    {"float s; for (int i = 0; i < min(n, 8); ++i) s += i; mc.Set(m, s);",
     " uninitialized maybe-uninitialized"},
    {"float s; for (int i = 0; i < 300; ++i) s += i; mc.Set(m, s);", " uninitialized"},
    {"float s; for (int i = 0; i < 300; ++i) for (int j = 0; j < 300; ++j) s += i; mc.Set(m, s);",
     " uninitialized"},
    {"float s; for (int i = 0; i < 3; ++i) s += i; mc.Set(m, s);", " uninitialized"},
    {"float s; for (int i = 0; i < 300; ++i) { mc.Add(m, s); s = x; }", " uninitialized"},
    {"float s; @bound(300) while (s < x) s = n;", " uninitialized"},
    {"float s; if (n > 3) mc.Set(m, s);", " uninitialized"},
    {"float s; switch (k) { case 0: s = 1; break; default: mc.Set(m, s); }", " uninitialized"},
    {"float s; for (int i = 0; i < 300; ++i) mc.Add(m, x); mc.Set(m, s);", " uninitialized"},
};

TEST(Flow, AVariableHasAValue) {
    for (const Case& item : kVariables)
        expect_ids(volume("", item.body), item);
}

// Elements of arrays start at zero, whatever fills them.
constexpr Case kArrays[] = {
    {"float a[300]; mc.Set(m, a[n]);", ""},
    {"float a[300]; for (int i = 0; i < min(n, 300); ++i) a[i] = x; mc.Set(m, a[k]);", ""},
    {"float a[8]; for (int i = 0; i < 8; ++i) a[i] += i; mc.Set(m, a[k]);", ""},
    {"float a[9][9]; a[k][n] = x; mc.Set(m, a[n][k]);", ""},
    {"P p; p.a[k] = x; mc.Set(m, p.a[n]);", ""},
    {"P p; p.a[k] = x; mc.Set(m, p.b);", " uninitialized"},
    {"P p[4]; p[k].b = x; mc.Set(m, p[n].b);", ""},
};

TEST(Flow, ArraysStartAtZero) {
    for (const Case& item : kArrays)
        expect_ids(volume("struct P { float a[4]; float b; };", item.body), item);
}

constexpr Case kSections[] = {
    {"switch (k) { case 0: switch (n) { case 1: return mc; default: return mc; } case 1: break; }",
     ""},
    {"for (int i = 0; i < 9; ++i) switch (k) { case 0: switch (n) { case 1: continue;"
     " default: return mc; } default: break; }",
     ""},
    {"switch (k) { case 0: if (x > 0) break; else return mc; default: break; }", ""},
    {"switch (k) { case 0: case 1: default: break; }", ""},
    {"switch (k) { case 0: break; case 1: }", ""},
    {"switch (k) { case 0: switch (n) { case 1: break; default: return mc; } case 1: break; }",
     " fall-through"},
    {"switch (k) { case 0: switch (n) { case 1: return mc; } case 1: break; }", " fall-through"},
    {"switch (k) { case 0: switch (n) { case 1: if (x > 0) break; return mc; default: return mc; }"
     " case 1: break; }",
     " fall-through"},
    {"switch (k) { case 0: while (x > 0) break; case 1: break; }", " fall-through"},
    {"switch (k) { case 0: mc.Set(m, x); default: break; }", " fall-through"},
};

TEST(Flow, SectionsOfASwitchEnd) {
    for (const Case& item : kSections)
        expect_ids(volume("", item.body), item);
}

}  // namespace
}  // namespace openfab::testing

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
    {"float a[300]; for (int i = 0; i < 300; ++i) a[i] = i; mc.Set(m, a[n]);", ""},
    {"float a[300]; for (int i = 0; i < 299; ++i) a[i] = i; mc.Set(m, a[n]);",
     " maybe-uninitialized"},
    {"float a[300]; for (int i = 0; i < 300; ++i) { if (x > i) break; a[i] = i; }"
     " mc.Set(m, a[n]);",
     " maybe-uninitialized"},
    {"float a[300]; for (int i = 0; i < 300; ++i) { a[i] = i; if (x > i) break; }"
     " mc.Set(m, a[0]);",
     ""},
    {"float a[300]; for (int i = 0; i < 300; ++i) { a[i] = i; if (x > i) break; }"
     " mc.Set(m, a[1]);",
     " maybe-uninitialized"},
    {"float s; for (int i = 0; i < min(n, 8); ++i) s = i; mc.Set(m, s);", " maybe-uninitialized"},
    {"float s; for (int i = 0; i < 300; ++i) if (x > i) s = i; mc.Set(m, s);",
     " maybe-uninitialized"},
    {"float3 b; float d = 9; for (int i = 0; i < 300; ++i) if (i < d) { d = x; b = i; }"
     " mc.Set(m, b.x);",
     " maybe-uninitialized"},
    {"float p; for (int i = 0; i < 300; ++i) { if (i > 0) mc.Add(m, p); p = x; }", ""},
    {"float p; for (int i = 0; i < 300; ++i) { if (i > 0) mc.Add(m, p); if (i > 0) p = x; }",
     " maybe-uninitialized"},
    {"float p; for (int i = 0; i < 300; ++i) { if (i > 1) mc.Add(m, p); if (i % 2 == 1) p = x; }",
     ""},
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

// Arrays that loops fill and read, and nearly the same that leave something without a value.
constexpr Case kFilledArrays[] = {
    // Up to a number that is known at run time only.
    {"float w[8]; for (int i = 0; i < min(n, 8); ++i) w[i] = i;"
     " for (int i = 0; i < min(n, 8); ++i) mc.Add(m, w[i]);",
     ""},
    {"float w[8]; for (int i = 0; i < min(n, 8); ++i) w[i] = i;"
     " for (int i = 0; i < min(k, 8); ++i) mc.Add(m, w[i]);",
     " maybe-uninitialized"},
    {"float w[8]; int c = min(n, 8); for (int i = 0; i < c; ++i) w[i] = i;"
     " for (int i = 1; i < c; ++i) mc.Add(m, w[i] - w[i - 1]);",
     ""},
    {"float w[8]; int c = min(n, 8); for (int i = 1; i < c; ++i) w[i] = i;"
     " for (int i = 1; i < c; ++i) mc.Add(m, w[i] - w[i - 1]);",
     " maybe-uninitialized"},
    {"float w[8]; int c = min(n, 8); for (int i = 0; i < c; ++i) w[i] = i;"
     " c = min(c + 1, 8); for (int i = 0; i < c; ++i) mc.Add(m, w[i]);",
     " maybe-uninitialized"},
    {"float w[8]; int c = min(n, 8); for (int i = 0; i < c; ++i) w[i] = i;"
     " for (int i = 0; i <= c; ++i) mc.Add(m, w[i]);",
     " maybe-uninitialized"},
    {"float w[9]; int c = min(n, 8); w[0] = 0; for (int i = 0; i < c; ++i) w[i + 1] = w[i] + x;"
     " for (int i = 0; i <= c; ++i) mc.Add(m, w[i]);",
     ""},
    {"float w[8]; int c = min(n, 8); for (int i = 0; i < c; i += 2) w[i] = i;"
     " for (int i = 0; i < c; ++i) mc.Add(m, w[i]);",
     " maybe-uninitialized"},
    {"float w[8]; int c = clamp(n, 1, 8); for (int i = 0; i < c; ++i) w[i] = i; mc.Set(m, w[0]);",
     ""},
    {"float w[8]; int c = clamp(n, 0, 8); for (int i = 0; i < c; ++i) w[i] = i; mc.Set(m, w[0]);",
     " maybe-uninitialized"},
    {"float w[8]; int c = min(n, 8); for (int i = 0; i < c; ++i) w[i] = i;"
     " if (n > 3) mc.Set(m, w[3]);",
     ""},
    {"float w[8]; int c = min(n, 8); for (int i = 0; i < c; ++i) w[i] = i;"
     " if (n > 3) mc.Set(m, w[4]);",
     " maybe-uninitialized"},
    {"float w[8]; int c = n & 7; for (int i = 0; i < c; ++i) w[i] = i;"
     " for (int i = 0; i < c; ++i) mc.Add(m, w[i]);",
     ""},
    {"float w[8]; uint c = min(uint(n), 8u); for (uint i = 0; i < c; ++i) w[i] = i;"
     " for (uint i = 0; i < c; ++i) mc.Add(m, w[i]);",
     ""},
    {"float w[8]; @bound(8) for (int i = 0; i < n; ++i) w[i] = i;"
     " @bound(8) for (int i = 0; i < n; ++i) mc.Add(m, w[i]);",
     ""},
    {"float w[8]; @bound(7) for (int i = 0; i < n; ++i) w[i] = i;"
     " @bound(8) for (int i = 0; i < n; ++i) mc.Add(m, w[i]);",
     " maybe-uninitialized"},
    {"float w[8]; int c = min(n, 8); for (int i = 0; i < c; ++i) w[i] = i;"
     " float t = 0; for (int i = 0; i < c; ++i) t += w[i];"
     " for (int i = 0; i < c; ++i) { w[i] /= t; mc.Add(m, w[i]); }",
     ""},
    {"float w[8]; int c = min(n, 8); for (int i = 0; i < c; ++i) { if (k > 2) w[i] = i; }"
     " if (k > 2) { for (int i = 0; i < c; ++i) mc.Add(m, w[i]); }",
     ""},
    {"float w[8]; int c = min(n, 8); for (int i = 0; i < c; ++i) { if (k > i) w[i] = i; }"
     " for (int i = 0; i < c; ++i) mc.Add(m, w[i]);",
     " maybe-uninitialized"},
    {"float w[8]; int c = min(n, 8); for (int i = 0; i < c; ++i) { if (x > i) break; w[i] = i; }"
     " for (int i = 0; i < c; ++i) mc.Add(m, w[i]);",
     " maybe-uninitialized"},
    {"float w[8]; int c = min(n, 8); for (int i = 0; i < c; ++i) w[i] = x * i; int i = 0;"
     " while (i < c) { if (w[i] > x) break; mc.Add(m, w[i++]); }",
     ""},
    {"float w[8]; int c = min(n, 8); for (int i = 0; i < c; ++i) w[i] = x * i; int i = 0;"
     " while (i < c) { if (w[i] > x) break; mc.Add(m, w[++i]); }",
     " maybe-uninitialized"},
    {"float w[8]; int c = min(n, 8); for (int i = 0; i < c; ++i) w[i] = x * i;"
     " for (int i = 0; i < c; ++i) for (int j = 0; j < i; ++j) mc.Add(m, w[i] * w[j]);",
     ""},
    {"float w[8]; int c = min(n, 8); for (int i = 0; i < c; ++i) w[i] = x * i;"
     " for (int i = 0; i < c; ++i) for (int j = 0; j < i; ++j) mc.Add(m, w[i] * w[j + 2]);",
     " maybe-uninitialized"},
    {"float w[9][9]; for (int i = 0; i < min(n, 9); ++i) for (int j = 0; j < min(k, 9); ++j)"
     " w[i][j] = x; for (int i = 0; i < min(n, 9); ++i) for (int j = 0; j < min(k, 9); ++j)"
     " mc.Add(m, w[i][j]);",
     ""},
    {"float w[9][9]; for (int i = 0; i < min(n, 9); ++i) for (int j = 0; j < min(k, 9); ++j)"
     " w[i][j] = x; for (int i = 0; i < min(n, 9); ++i) for (int j = 0; j < min(k, 9); ++j)"
     " mc.Add(m, w[j][i]);",
     " maybe-uninitialized"},
    // By rows.
    {"float w[360]; for (int i = 0; i < 18; ++i) for (int j = 0; j < 20; ++j)"
     " w[i * 20 + j] = fbm(float3(x * i * j), 6); mc.Set(m, w[n]);",
     ""},
    {"float w[360]; for (int i = 0; i < 18; ++i) for (int j = 0; j < 19; ++j)"
     " w[i * 20 + j] = fbm(float3(x * i * j), 6); mc.Set(m, w[n]);",
     " maybe-uninitialized"},
    {"float w[360]; for (int i = 0; i < 17; ++i) for (int j = 0; j < 20; ++j)"
     " w[i * 20 + j] = fbm(float3(x * i * j), 6); mc.Set(m, w[n]);",
     " maybe-uninitialized"},
    {"float w[360]; for (int i = 0; i < 18; ++i) for (int j = 1; j <= 20; ++j)"
     " w[i * 20 + j] = fbm(float3(x * i * j), 6); mc.Set(m, w[n]);",
     " maybe-uninitialized"},
    {"float w[360]; for (int i = 0; i < 18; ++i) for (int j = 0; j < 20; ++j)"
     " w[i * 19 + j] = fbm(float3(x * i * j), 6); mc.Set(m, w[n]);",
     " maybe-uninitialized"},
    {"float w[360]; for (int i = 17; i >= 0; --i) for (int j = 19; j >= 0; --j)"
     " w[i * 20 + j] = fbm(float3(x * i * j), 6); mc.Set(m, w[n]);",
     ""},
    {"float w[360]; for (int j = 0; j < 20; ++j) for (int i = 0; i < 18; ++i)"
     " w[i * 20 + j] = fbm(float3(x * i * j), 6); mc.Set(m, w[n]);",
     ""},
    {"float w[360]; for (int j = 0; j < 20; ++j) for (int i = 0; i < 18; i += 2)"
     " w[i * 20 + j] = fbm(float3(x * i * j), 6); mc.Set(m, w[n]);",
     " maybe-uninitialized"},
    {"float w[360]; for (int i = 0; i < 18; ++i) for (int j = 0; j < 20; j += 2) {"
     " w[i * 20 + j] = fbm(float3(x * i * j), 6); w[i * 20 + j + 1] = 1; } mc.Set(m, w[n]);",
     ""},
    {"float w[360]; for (int i = 0; i < 18; ++i) for (int j = 0; j < 20; ++j) {"
     " if (j == 7) continue; w[i * 20 + j] = fbm(float3(x * i * j), 6); } mc.Set(m, w[n]);",
     " maybe-uninitialized"},
    {"float w[360]; for (int i = 0; i < 18; ++i) for (int j = 0; j < 20; ++j) {"
     " w[i * 20 + j] = fbm(float3(x * i * j), 6); if (x > i) break; } mc.Set(m, w[n]);",
     " maybe-uninitialized"},
    {"float w[360]; for (int i = 0; i < 18; ++i) for (int j = 0; j < 20; ++j) {"
     " if (x > j) { w[i * 20 + j] = 0; continue; }"
     " w[i * 20 + j] = fbm(float3(x * i * j), 6); } mc.Set(m, w[n]);",
     ""},
    {"float w[360]; for (int i = 0; i < 18; ++i) for (int j = 0; j < i; ++j)"
     " w[i * 20 + j] = fbm(float3(x * i * j), 6); mc.Set(m, w[n]);",
     " maybe-uninitialized"},
    {"float w[343]; for (int i = 0; i < 7; ++i) for (int j = 0; j < 7; ++j)"
     " for (int l = 0; l < 7; ++l) w[(i * 7 + j) * 7 + l] = fbm(float3(x * i * j), 9);"
     " mc.Set(m, w[n]);",
     ""},
    {"float w[343]; for (int i = 0; i < 7; ++i) for (int j = 0; j < 6; ++j)"
     " for (int l = 0; l < 7; ++l) w[(i * 7 + j) * 7 + l] = fbm(float3(x * i * j), 9);"
     " mc.Set(m, w[n]);",
     " maybe-uninitialized"},
    // Read while it is filled.
    {"float w[360]; for (int i = 0; i < 18; ++i) for (int j = 0; j < 20; ++j) {"
     " w[i * 20 + j] = fbm(float3(x * i * j), 6);"
     " if (j > 0) w[i * 20 + j] += w[i * 20 + j - 1];"
     " if (i > 0) w[i * 20 + j] += w[i * 20 + j - 20]; } mc.Set(m, w[n]);",
     ""},
    {"float w[360]; for (int i = 0; i < 18; ++i) for (int j = 0; j < 20; ++j) {"
     " w[i * 20 + j] = fbm(float3(x * i * j), 6);"
     " if (j > 0) w[i * 20 + j] += w[i * 20 + j + 1]; } mc.Set(m, w[n]);",
     " maybe-uninitialized"},
};

TEST(Flow, LoopsFillArrays) {
    for (const Case& item : kFilledArrays)
        expect_ids(volume("", item.body), item);
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

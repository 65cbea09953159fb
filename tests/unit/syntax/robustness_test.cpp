// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// For any bytes the front end ends, in bounded time, with diagnostics or valid IR: random bytes,
// random words of the language, and the postcard with pieces removed, duplicated or changed.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "compiler/diag/render.h"
#include "compiler/frontend/frontend.h"
#include "tests/support/places/places.h"

namespace openfab::testing {
namespace {

unsigned seed() {
    const char* given = std::getenv("OPENFAB_SEED");
    return given != nullptr ? static_cast<unsigned>(std::strtoul(given, nullptr, 10)) : 20130721u;
}

void survive(const std::string& text) {
    source::SourceManager sources;
    diag::Sink sink;
    const uint32_t file = sources.add("t.fl", text);
    const std::optional<ir::Module> module = frontend::compile_to_ir(sources, file, sink);
    const std::string printed = diag::render_text(sink, sources);
    EXPECT_EQ(module.has_value(), sink.errors() == 0) << printed;
    EXPECT_LT(printed.size(), 100000u);
    if (module) {
        for (const ir::Fablet& fablet : module->fablets) {
            EXPECT_EQ(ir::verify(fablet.surface), "") << text;
            EXPECT_EQ(ir::verify(fablet.volume), "") << text;
        }
    }
}

TEST(Robustness, RandomBytes) {
    std::mt19937 random(seed());
    for (int i = 0; i < 2000; ++i) {
        std::string text(random() % 300, '\0');
        for (char& c : text)
            c = static_cast<char>(random());
        survive(text);
    }
}

TEST(Robustness, RandomWords) {
    static const char* const kWords[] = {
        "fablet",
        "A",
        "{",
        "}",
        "(",
        ")",
        "[",
        "]",
        ";",
        ",",
        ".",
        "@uniform",
        "@Surface",
        "@Volume",
        "@Dither",
        "@varying",
        "@nearest",
        "@",
        "out",
        "inout",
        "const",
        "float",
        "float3",
        "int",
        "bool",
        "uint",
        "Material",
        "MaterialComposition",
        "ImageTexture2D",
        "VolumeAttributes",
        "DitherAttributes",
        "attr",
        "x",
        "y",
        "mc",
        "if",
        "else",
        "for",
        "while",
        "do",
        "return",
        "break",
        "continue",
        "switch",
        "struct",
        "import",
        "=",
        "==",
        "+",
        "-",
        "*",
        "/",
        "%",
        "&&",
        "||",
        "!",
        "?",
        ":",
        "++",
        "--",
        "+=",
        "<",
        ">",
        "1",
        "0.5",
        "2u",
        "true",
        "\"s\"",
        "Set",
        "Sample1",
        "distance",
        "sqrt",
        "min",
        "xyz",
        "[[",
        "]]",
        "//\n",
        "/*",
        "*/",
        "#define",
        "~",
        "<<",
        "VOID",
        "case",
        "default",
        "@bound(4)",
        "import color;",
        "printf(\"%d\",",
        "assert(",
        "float3x3",
        "mul",
        "[i]",
        "[3]",
        "{1, 2}",
        "static",
        "S",
        "struct S { float a; int b[2]; };",
        "S s;",
        "s.b",
        "nearest(p)",
        "SurfacePoint",
        "noise",
        "over",
    };
    std::mt19937 random(seed());
    for (int i = 0; i < 3000; ++i) {
        std::string text = random() % 2 == 0 ? ""
                                             : "fablet A { @uniform { float x; Material m; } "
                                               "@Volume(@varying { VolumeAttributes attr }) { ";
        for (unsigned n = random() % 60; n > 0; --n)
            text += std::string(kWords[random() % std::size(kWords)]) + " ";
        survive(text);
    }
}

std::string read(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// Removes, duplicates or changes a few pieces of the text.
std::string changed(std::string text, std::mt19937* random) {
    for (unsigned n = 1 + (*random)() % 3; n > 0; --n) {
        const size_t at = (*random)() % text.size();
        const size_t size = (*random)() % 20;
        switch ((*random)() % 4) {
            case 0:
                text.erase(at, size);
                break;
            case 1:
                text.insert(at, text.substr((*random)() % text.size(), size));
                break;
            case 2:
                text[at] = static_cast<char>((*random)());
                break;
            default:
                text[at] = "(){}[];,.@+-*/=<>&|!?:0a\"#"[(*random)() % 26];
                break;
        }
        if (text.empty()) return text;
    }
    return text;
}

TEST(Robustness, ChangedPostcards) {
    const std::string postcard = read(source_dir() / "gallery/magic_postcard/magic_postcard.fl");
    ASSERT_FALSE(postcard.empty());
    for (size_t i = 0; i < postcard.size(); ++i)
        survive(postcard.substr(0, i));
    std::mt19937 random(seed());
    for (int i = 0; i < 3000; ++i)
        survive(changed(postcard, &random));
}

TEST(Robustness, ChangedPrograms) {
#ifdef OPENFAB_SANITIZED
    constexpr int kRounds = 20;
#else
    constexpr int kRounds = 200;
#endif
    std::mt19937 random(seed());
    const std::filesystem::path folder = source_dir() / "tests/lang";
    int programs = 0;
    for (const char* kind : {"pass", "fail", "warn"}) {
        for (const auto& entry : std::filesystem::directory_iterator(folder / kind)) {
            // It tests its own size limit.
            if (entry.path().stem() == "too_complex") continue;
            const std::string program = read(entry.path());
            ASSERT_FALSE(program.empty());
            ++programs;
            for (int i = 0; i < kRounds; ++i)
                survive(changed(program, &random));
        }
    }
    EXPECT_GT(programs, 60);
}

std::string repeated(const std::string& piece, int count) {
    std::string out;
    for (int i = 0; i < count; ++i)
        out += piece;
    return out;
}

std::string volume(const std::string& body) {
    return "fablet A { @uniform { Material m; float x; } @Volume(@varying { VolumeAttributes attr "
           "}) { float a = x; " +
           body + " MaterialComposition mc; mc.Set(m, a); return mc; } }";
}

TEST(Robustness, DeepNestingIsRefused) {
    constexpr int kDeep = 100000;
    for (const char* piece : {"(", "-", "!", "{", "[", "a[", "f(", "if (1) ", "while (1) ", "do ",
                              "a = ", "a ? ", "(float)", "for (;;) "}) {
        survive(volume(repeated(piece, kDeep)));
        survive(volume("a = " + repeated(piece, kDeep) + "1;"));
    }
    survive(volume("a = 1" + repeated(" + a", kDeep) + ";"));
    survive(volume("a = a" + repeated(".x", kDeep) + ";"));
    survive(volume("a" + repeated("++", kDeep) + ";"));
    survive(volume("a = 1" + repeated(", 1", kDeep) + ";"));
    survive(volume(repeated("if (a > 1) a = 1; else ", kDeep) + ";"));
    survive(volume("float3 v = " + repeated("{", kDeep)));
    survive(repeated("fablet A {", 10000));
    survive(repeated("fablet A { @Volume(", 10000));
    survive("fablet A { @uniform { float a " + repeated("[", kDeep));
}

TEST(Robustness, LongAndHeavyProgramsEnd) {
    survive(volume(repeated("a += 1; ", 20000)));
    survive(volume(repeated("a = a * x + 1; ", 20000)));
    survive(volume(repeated("if (a > x) return mc2; ", 2000)));
    survive(volume(repeated("if (a > x) { MaterialComposition n; return n; } a = a * x; ", 1500)));
    survive(
        volume("for (int i = 0; i < 1000; i++) { if (a > x) break; a = a * x; if (a < i) continue; "
               "a += i; }"));
    survive(
        volume("for (int i = 0; i < 1024; i++) for (int j = 0; j < 1024; j++) for (int k = 0; k < "
               "1024; k++) a += i * j * k;"));
    survive(volume("for (int i = 0; i < 1024; i++) for (int j = 0; j < 1024; j++) { }"));
    std::string chain = "float f0(float x) { return x * x + 1; }\n";
    for (int i = 1; i < 40; ++i) {
        const std::string before = "f" + std::to_string(i - 1);
        chain += "float f" + std::to_string(i) + "(float x) { return " + before + "(x) + " +
                 before + "(x + 1); }\n";
    }
    survive(chain + volume("a = f39(a);"));
    survive(
        volume("float t[16][16][16][4]; for (int i = 0; i < 16; i++) t[i][i][i][i] = i; int k = "
               "attr.instance; a = t[k][k][k][k];"));
    survive(volume("float t[100][100]; int k = attr.instance; t[k][k] = a; a = t[k][k];"));
    survive(volume("float t[16384]; int k = attr.instance; " + repeated("t[k] += 1; ", 100)));
    survive(volume("MaterialComposition t[16384]; a = t[attr.instance].Total();"));
    survive(volume("switch (attr.instance) {" + repeated("case 1: ", 20000) + "}"));
    std::string labels;
    for (int i = 0; i < 3000; ++i)
        labels += "case " + std::to_string(i) + ": a += " + std::to_string(i) + "; break; ";
    survive(volume("switch (attr.instance) {" + labels + "}"));
    survive(volume("float big[] = {" + repeated("1, ", 200000) + "};"));
    survive(volume("float3x3 m = a; " + repeated("m = inverse(mul(m, m)); ", 300)));
    std::string records = "struct R0 { float a[4]; };\n";
    for (int i = 1; i < 40; ++i)
        records += "struct R" + std::to_string(i) + " { R" + std::to_string(i - 1) + " a, b; };\n";
    survive(records + volume("R39 r; R5 s = {}; a = s.a.b.a.b.a.a[1];"));
    std::string line = "float g0(float x) { return x; }\n";
    for (int i = 1; i < 2000; ++i)
        line += "float g" + std::to_string(i) + "(float x) { return g" + std::to_string(i - 1) +
                "(x); }\n";
    survive(line + volume("a = g1999(a);"));
    std::string uniforms = "fablet A { @uniform { ";
    for (int i = 0; i < 5000; ++i)
        uniforms += "Material m" + std::to_string(i) + "; ";
    survive(uniforms +
            "} @Volume() { MaterialComposition mc; for (int i = 0; i < 1000; i++) mc.Add(m7, 1); "
            "return mc; } }");
}

}  // namespace
}  // namespace openfab::testing

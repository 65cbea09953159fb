// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/format/format.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "compiler/syntax/token.h"
#include "tests/fuzz/differential/random_fablet.h"
#include "tests/fuzz/mutations/mutate.h"
#include "tests/support/long_run.h"
#include "tests/support/places/places.h"

namespace openfab::format {
namespace {

namespace fs = std::filesystem;

std::string read(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::ostringstream out;
    out << in.rdbuf();
    return out.str();
}

std::vector<fs::path> fablets_below(const std::vector<std::string>& folders) {
    std::vector<fs::path> out;
    for (const std::string& folder : folders) {
        for (const auto& entry : fs::recursive_directory_iterator(testing::source_dir() / folder)) {
            if (entry.path().extension() == ".fl") out.push_back(entry.path());
        }
    }
    std::sort(out.begin(), out.end());
    return out;
}

Result<std::string> formatted(const std::string& text) {
    source::SourceManager sources;
    diag::Sink sink;
    return format(sources, sources.add("test.fl", text), &sink);
}

/// Returns kinds and texts of the tokens, one a line.
std::string tokens_of(const std::string& text) {
    source::SourceManager sources;
    diag::Sink sink;
    std::string out;
    for (const syntax::Token& token : syntax::lex(sources, sources.add("test.fl", text), &sink))
        out += std::string(syntax::spelling(token.kind)) + " " + std::string(token.text) + "\n";
    return out;
}

/// Returns the texts of the comments, found without the lexer under test: no string here holds a slash.
std::vector<std::string> comments_of(const std::string& text) {
    std::vector<std::string> out;
    for (size_t at = 0; (at = text.find('/', at)) < text.size();) {
        const bool line = text.compare(at, 2, "//") == 0;
        if (!line && text.compare(at, 2, "/*") != 0) {
            ++at;
            continue;
        }
        const size_t end =
            std::min(line ? text.find('\n', at) : text.find("*/", at + 2) + 2, text.size());
        std::string comment;
        for (size_t i = at; i < end; ++i) {
            if (text[i] > ' ') comment += text[i];
        }
        out.push_back(comment);
        at = end;
    }
    return out;
}

void expect_same_program(const std::string& text, const std::string& what) {
    const Result<std::string> once = formatted(text);
    ASSERT_TRUE(once) << what << ": " << once.error().text() << "\n" << text;
    EXPECT_EQ(tokens_of(*once), tokens_of(text)) << what;
    EXPECT_EQ(comments_of(*once), comments_of(text)) << what << "\n" << *once;
    const Result<std::string> twice = formatted(*once);
    ASSERT_TRUE(twice) << what << ": " << twice.error().text() << "\n" << *once;
    EXPECT_EQ(*twice, *once) << what << "\n" << text;
    EXPECT_EQ(once->find(" \n"), std::string::npos) << what << "\n" << *once;
}

TEST(Format, OneStyleForAllThatIsInADeclaration) {
    const std::string text = R"(
import   shell ;
 const float A=1,B=-2 ;
struct  Range{float lo,hi;} ;


fablet  F{
@uniform{float2 border=float2(1,2)[[float min=0,string help="mm"]];Material a,b;}
float area(in float r,out float2 t){return r*r ;}
float twice(float r){float d=2*r;return d;}
@Surface(@varying{SurfaceAttributes attr,float2 uv=0,out float2 uvOut}) { uvOut=uv; return attr.n*0.1; }
@Volume ( @varying{VolumeAttributes attr,@nearest float2 uv} ) {

MaterialComposition mc;   // what is printed
if(uv.x<0.5)mc.Set(a,1);
else if(uv[1]>- -A){mc.Set(b,1);}else{mc.Set(a,(float)-1);;}
for(int i=0;i<3;i++){}
@bound(4)
while(true)break;
do{--A;}while(A>0&&!(B<1||~i==2));
switch(i){case 1:return mc;default:mc.Clear();
break;}
return mc;
}
};
)";
    const std::string expected = R"(import shell;
const float A = 1, B = -2;
struct Range { float lo, hi; };

fablet F {
    @uniform { float2 border = float2(1, 2) [[ float min = 0, string help = "mm" ]]; Material a, b; }
    float area(in float r, out float2 t) { return r * r; }
    float twice(float r)
    {
        float d = 2 * r;
        return d;
    }
    @Surface(@varying { SurfaceAttributes attr, float2 uv = 0, out float2 uvOut })
    {
        uvOut = uv;
        return attr.n * 0.1;
    }
    @Volume(@varying { VolumeAttributes attr, @nearest float2 uv })
    {
        MaterialComposition mc; // what is printed
        if (uv.x < 0.5) mc.Set(a, 1);
        else if (uv[1] > - -A) {
            mc.Set(b, 1);
        } else {
            mc.Set(a, (float)-1);
            ;
        }
        for (int i = 0; i < 3; i++) {}
        @bound(4) while (true) break;
        do {
            --A;
        } while (A > 0 && !(B < 1 || ~i == 2));
        switch (i) {
        case 1: return mc;
        default: mc.Clear();
            break;
        }
        return mc;
    }
};
)";
    const Result<std::string> made = formatted(text);
    ASSERT_TRUE(made) << made.error().text();
    EXPECT_EQ(*made, expected);
    EXPECT_EQ(*formatted(expected), expected);
}

TEST(Format, EnumsAreListsOfNames) {
    const std::string text =
        "enum  Pattern{STRIPES,DOTS=1+2,PLAIN[[string label=\"no ink\"]]} ;\n"
        "enum Kind {\nONE, // the first\nTWO\n};\nfloat f(){Hit h[2]=( Hit [ 2 ] )0; return "
        "(float[2])1 ;}\n";
    const Result<std::string> out = formatted(text);
    ASSERT_TRUE(out) << out.error().text();
    EXPECT_NE(
        out->find(
            "enum Pattern { STRIPES, DOTS = 1 + 2, PLAIN [[ string label = \"no ink\" ]] };\n"),
        std::string::npos)
        << *out;
    EXPECT_NE(out->find("Hit h[2] = (Hit[2])0;"), std::string::npos) << *out;
    expect_same_program(text, "enums");
}

TEST(Format, ClaimsOfAStageStandBehindItsVaryings) {
    const Result<std::string> out = formatted(
        "fablet A {\n@Shape( @varying{ShapeAttributes attr} )[[distance]] {return attr.p.x ;}\n"
        "@Shape(@varying{ShapeAttributes attr})\n[[ distance ]]\n{\nfloat d=1;\nreturn d;}\n}\n");
    ASSERT_TRUE(out) << out.error().text();
    EXPECT_EQ(*out,
              "fablet A {\n"
              "    @Shape(@varying { ShapeAttributes attr }) [[ distance ]] { return attr.p.x; }\n"
              "    @Shape(@varying { ShapeAttributes attr }) [[ distance ]]\n"
              "    {\n        float d = 1;\n        return d;\n    }\n}\n");
}

TEST(Format, WhatDoesNotFitContinuesUnderItsFirstPart) {
    const std::string text = R"(
float sum(float first_argument, float second_argument, float third_argument, float fourth_argument, float fifth) {
return first_argument * second_argument + third_argument * fourth_argument + fifth * first_argument + second_argument;
}
float pick(float first_argument, float second_argument) {
float x = first_argument > second_argument * 2 ? sum(first_argument, 1, 2, 3, second_argument) : sum(second_argument, 2, 3, 4, 5);
float3x3 m = float3x3(1, 0, 0,
0, 1, 0,
0, 0, 1);
const float TABLE[4] = {
1, 2,
3, 4,
};
}
)";
    const std::string expected =
        R"(float sum(float first_argument, float second_argument, float third_argument, float fourth_argument, float fifth)
{
    return first_argument * second_argument + third_argument * fourth_argument + fifth * first_argument +
           second_argument;
}
float pick(float first_argument, float second_argument)
{
    float x = first_argument > second_argument * 2 ? sum(first_argument, 1, 2, 3, second_argument)
                                                   : sum(second_argument, 2, 3, 4, 5);
    float3x3 m = float3x3(1, 0, 0,
                          0, 1, 0,
                          0, 0, 1);
    const float TABLE[4] = {
        1, 2,
        3, 4,
    };
}
)";
    const Result<std::string> made = formatted(text);
    ASSERT_TRUE(made) << made.error().text();
    EXPECT_EQ(*made, expected);
}

TEST(Format, CommentsStayWhereTheyAre) {
    const std::string text = R"(/* of the file */

// of a

const float a = 1; // behind a


    /* of b,
       in two lines */
const float b = /* inside */ 2;
float f(float x, // the first
        float y /* the second */)
{
    // first
    return x + // and
    // above y
    y;
    // last
}
// of nothing)";
    const std::string expected = R"(/* of the file */

// of a

const float a = 1; // behind a

/* of b,
   in two lines */
const float b = /* inside */ 2;
float f(float x, // the first
        float y /* the second */)
{
    // first
    return x + // and
           // above y
           y;
    // last
}
// of nothing
)";
    const Result<std::string> made = formatted(text);
    ASSERT_TRUE(made) << made.error().text();
    EXPECT_EQ(*made, expected);
}

TEST(Format, ASyntaxErrorIsReported) {
    source::SourceManager sources;
    diag::Sink sink;
    EXPECT_FALSE(format(sources, sources.add("test.fl", "float f( {"), &sink));
    EXPECT_GT(sink.errors(), 0U);
    // Was taken without its parenthesis, and laid out without an end.
    EXPECT_FALSE(
        formatted("fablet A {\n    @Volume(@varying { VolumeAttributes attr } {\n"
                  "        MaterialComposition mc;\n        return mc;\n    }\n}\n"));
}

TEST(Format, EveryFabletOfTheRepositoryKeepsItsTokens) {
    int done = 0;
    for (const fs::path& file : fablets_below({"stdlib", "gallery", "tools", "bench", "tests"})) {
        const std::string text = read(file);
        source::SourceManager sources;
        diag::Sink sink;
        const uint32_t source = sources.add("test.fl", text);
        if (!format(sources, source, &sink) && sink.errors() > 0) continue;
        expect_same_program(text, file.string());
        ++done;
    }
    EXPECT_GT(done, 120);
}

TEST(Format, TheRepositorysFabletsAreFormatted) {
    for (const fs::path& file :
         fablets_below({"stdlib", "gallery", "tools", "bench", "tests/property"})) {
        const std::string text = read(file);
        const Result<std::string> made = formatted(text);
        ASSERT_TRUE(made) << file;
        EXPECT_EQ(*made, text) << file << ": openflc fmt " << file;
    }
}

/// Writes the tokens of a program with other white space, and comments, between them.
std::string scattered(const std::string& text, std::mt19937_64* random) {
    source::SourceManager sources;
    diag::Sink sink;
    const uint32_t file = sources.add("test.fl", text);
    constexpr const char* kBetween[] = {" ",
                                        " ",
                                        " ",
                                        "\n",
                                        "\n\n\n",
                                        "  \t",
                                        "\r\n",
                                        " /* a */ ",
                                        " // line\n",
                                        "\n  // own\n",
                                        "\n/* two\n   lines */\n",
                                        " /* b */\n"};
    std::string out;
    const auto density = (*random)() % 4;
    for (const syntax::Token& token : syntax::lex(sources, file, &sink)) {
        const size_t kinds = (*random)() % 8 < density ? std::size(kBetween) : 4;
        out += kBetween[(*random)() % kinds];
        out += sources.text(token.span);
    }
    return out;
}

TEST(Format, RandomLayoutsOfRandomProgramsKeepTheirTokensAndComments) {
    const int programs = testing::long_run() ? 2000 : 60;
    std::mt19937_64 random(20261125);
    const std::vector<fs::path> files = fablets_below({"stdlib", "gallery", "tests/lang/pass"});
    for (int i = 0; i < programs && !HasFailure(); ++i) {
        const uint64_t seed = random();
        const std::string from =
            i % 2 == 0 ? testing::random_fablet(seed) : read(files[seed % files.size()]);
        expect_same_program(scattered(from, &random), "program " + std::to_string(i));
    }
}

TEST(Format, DamagedProgramsAreFormattedOrHaveSyntaxErrors) {
    const int programs = testing::long_run() ? 50000 : 2000;
    std::mt19937_64 random(20261127);
    const std::vector<fs::path> files = fablets_below({"stdlib", "gallery", "tests/lang"});
    int formatted_ones = 0;
    for (int i = 0; i < programs && !HasFailure(); ++i) {
        std::string text = read(files[random() % files.size()]);
        if (i % 2 == 0) {
            text = testing::mutate(text, true, &random);
        } else {
            text.erase(random() % text.size(), random() % 4);
        }
        const Result<std::string> made = formatted(text);
        if (!made) {
            EXPECT_EQ(made.error().code, ErrorCode::kUserInput) << made.error().text() << "\n"
                                                                << text;
            continue;
        }
        ++formatted_ones;
        expect_same_program(text, "program " + std::to_string(i));
    }
    EXPECT_GT(formatted_ones, programs / 10);
}

}  // namespace
}  // namespace openfab::format

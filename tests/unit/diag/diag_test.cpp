// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <set>

#include "base/json_text.h"
#include "compiler/diag/render.h"

namespace openfab::diag {
namespace {

struct Page {
    source::SourceManager sources;
    Sink sink;
    uint32_t file = 0;
    explicit Page(std::string text) { file = sources.add("card.fl", std::move(text)); }
    source::Span span(uint32_t begin, uint32_t end) const { return {file, begin, end}; }
    std::string text() const { return render_text(sink, sources); }
};

TEST(Render, IsTheFormOfTheStyleGuide) {
    Page p("first\n        return attr.n * distance(attr.p);\n");
    p.sink.report(p.span(30, 38), kStageMismatch, "distance", "called in a surface stage")
        .note(p.span(0, 5), "stage declared `@Surface` here")
        .help("pass the value in as a varying");
    EXPECT_EQ(p.text(),
              "card.fl:2:25: error: `distance` called in a surface stage [stage-mismatch]\n"
              " 2 |         return attr.n * distance(attr.p);\n"
              "   |                         ^~~~~~~~\n"
              "card.fl:1:1: note: stage declared `@Surface` here\n"
              "help: pass the value in as a varying\n");
}

TEST(Render, ATabIsOneColumnAndABadByteIsShown) {
    Page p("\tx\xC3\xA9\xFF y\x01z");
    p.sink.report(p.span(6, 7), kUnknownName, "y");
    EXPECT_EQ(p.text(),
              "card.fl:1:6: error: `y` is not declared here [unknown-name]\n"
              " 1 |  xé\xEF\xBF\xBD y z\n"
              "   |      ^\n");
}

TEST(Render, ASpanOfSeveralLinesEndsWithItsFirst) {
    Page p("one two\nthree\n");
    p.sink.report(p.span(4, 12), kNoFablet);
    EXPECT_NE(p.text().find(" 1 | one two\n   |     ^~~\n"), std::string::npos) << p.text();
}

TEST(Render, AnEmptySpanAndTheEndOfTheFileHaveACaret) {
    Page p("ab");
    p.sink.report(p.span(2, 2), kNoFablet);
    EXPECT_NE(
        p.text().find(
            "card.fl:1:3: error: the file contains no fablet [no-fablet]\n 1 | ab\n   |   ^\n"),
        std::string::npos)
        << p.text();
}

TEST(Render, ALongLineIsCutAroundTheCaret) {
    Page p(std::string(1000, 'a') + "b" + std::string(1000, 'c'));
    p.sink.report(p.span(1000, 1001), kUnknownName, "b");
    const std::string text = p.text();
    EXPECT_LT(text.size(), 700u);
    const size_t line = text.find(" 1 | ") + 5;
    const size_t caret_line = text.find("   | ", line) + 5;
    const std::string shown = text.substr(line, caret_line - 6 - line);
    const size_t column = text.find('^') - caret_line;
    EXPECT_EQ(shown[column + 2], 'b');  // the ellipsis is one column and three bytes
}

TEST(Sink, SortsAndDropsTheSecondOfTwo) {
    Page p("a b c");
    p.sink.report(p.span(4, 5), kUnknownName, "c");
    p.sink.report(p.span(0, 1), kNarrowing, "float", "int");
    p.sink.report(p.span(4, 5), kUnknownName, "c").help("lost");
    EXPECT_EQ(p.sink.errors(), 1u);
    EXPECT_EQ(p.sink.warnings(), 1u);
    const std::vector<Diagnostic> sorted = p.sink.sorted();
    ASSERT_EQ(sorted.size(), 2u);
    EXPECT_EQ(sorted[0].severity, Severity::kWarning);
    EXPECT_TRUE(sorted[1].helps.empty());
}

TEST(Render, StopsAfterTwentyErrors) {
    Page p(std::string(100, 'x'));
    for (uint32_t i = 0; i < 50; ++i)
        p.sink.report(p.span(i, i + 1), kUnknownName, "x");
    const std::string text = p.text();
    EXPECT_NE(text.find("card.fl:1:20:"), std::string::npos);
    EXPECT_EQ(text.find("card.fl:1:21:"), std::string::npos);
    EXPECT_NE(text.find("stopped after 20 of 50 errors\n"), std::string::npos);
}

TEST(Render, ShowsAnErrorBehindManyWarnings) {
    Page p(std::string(100, 'x'));
    for (uint32_t i = 0; i < 50; ++i)
        p.sink.report(p.span(i, i + 1), kNarrowing, "float", "int");
    p.sink.report(p.span(60, 61), kUnknownName, "x");
    const std::string text = p.text();
    EXPECT_NE(text.find("card.fl:1:20:"), std::string::npos);
    EXPECT_EQ(text.find("card.fl:1:21:"), std::string::npos);
    EXPECT_NE(text.find("card.fl:1:61: error:"), std::string::npos);
    EXPECT_NE(text.find("left out 30 of 50 warnings\n"), std::string::npos);
}

TEST(Sink, HoldsNoMoreThanItsLimit) {
    Page p("x");
    for (uint32_t i = 0; i < Sink::kMaxKept + 10; ++i)
        p.sink.report(p.span(i, i + 1), kUnknownName, "x").help("h");
    EXPECT_EQ(p.sink.errors(), Sink::kMaxKept + 10);
    EXPECT_EQ(p.sink.sorted().size(), Sink::kMaxKept);
}

TEST(Render, Json) {
    Page p("a\n\"b\"");
    p.sink.report(p.span(2, 5), kExpected, "`;`", "a string")
        .note(p.span(0, 1), "n")
        .help("h1")
        .help("h2")
        .insert_after(p.span(2, 5), ";");
    EXPECT_EQ(
        render_json(p.sink, p.sources),
        R"({"diagnostics":[{"id":"expected","severity":"error","message":"expected `;`, found a string",)"
        R"("file":"card.fl","line":2,"column":1,"end_line":2,"end_column":4,)"
        R"("notes":[{"message":"n","file":"card.fl","line":1,"column":1}],"help":["h1","h2"],"fix":[{"file":"card.fl","line":2,"column":4,"end_line":2,"end_column":4,"text":";"}]}],"errors":1,"warnings":0})"
        "\n");
}

TEST(Json, StringsAreAlwaysValid) {
    EXPECT_EQ(json_string("a\"b\\c\n\x01\xC3\xA9\xFF"),
              "\"a\\\"b\\\\c\\n\\u0001\xC3\xA9\xEF\xBF\xBD\"");
}

TEST(Diagnostics, IdsAreUniqueAndInKebabCase) {
    std::set<std::string> seen;
    for (int id = 0; id < static_cast<int>(Id::kCount); ++id) {
        const std::string text = id_text(static_cast<Id>(id));
        EXPECT_TRUE(seen.insert(text).second) << text;
        EXPECT_EQ(text.find_first_not_of("abcdefghijklmnopqrstuvwxyz-"), std::string::npos) << text;
    }
}

}  // namespace
}  // namespace openfab::diag

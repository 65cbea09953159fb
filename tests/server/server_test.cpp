// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The parts of the language server; tests/server/client_test.py has whole sessions.

#include "compiler/server/server.h"

#include "compiler/check/builtins.h"
#include "compiler/check/signatures.h"
#include "compiler/server/answers.h"
#include "compiler/server/reference.h"
#include "compiler/server/text_document.h"
#include "compiler/server/transport.h"

namespace openfab::server {
namespace {

TEST(TextDocument, PositionsCountCodeUnitsOfTheEncoding) {
    const TextDocument text("a𝄞é\r\nb\n");
    EXPECT_EQ(text.lines(), 3);
    struct Case {
        uint32_t offset;
        int64_t utf16, utf8;
    };
    for (const Case& c : {Case{0, 0, 0}, Case{1, 1, 1}, Case{5, 3, 5}, Case{7, 4, 7}}) {
        EXPECT_EQ(text.position(c.offset, Encoding::kUtf16), (Position{0, c.utf16}));
        EXPECT_EQ(text.position(c.offset, Encoding::kUtf8), (Position{0, c.utf8}));
        EXPECT_EQ(text.offset({0, c.utf16}, Encoding::kUtf16), c.offset);
        EXPECT_EQ(text.offset({0, c.utf8}, Encoding::kUtf8), c.offset);
    }
    EXPECT_EQ(text.offset({0, 2}, Encoding::kUtf16), 1U) << "within a code point is before it";
    EXPECT_EQ(text.offset({0, 99}, Encoding::kUtf16), 7U) << "behind the line is its end";
    EXPECT_EQ(text.offset({9, 0}, Encoding::kUtf16), 11U);
    EXPECT_EQ(text.offset({-1, -5}, Encoding::kUtf16), 0U);
}

TEST(TextDocument, ChangesReplaceRanges) {
    TextDocument text("one\ntwo\n");
    text.replace({{0, 3}, {1, 0}}, " ", Encoding::kUtf16);
    EXPECT_EQ(text.text(), "one two\n");
    text.replace({{0, 5}, {0, 2}}, "x", Encoding::kUtf16);
    EXPECT_EQ(text.text(), "one txwo\n") << "a range that ends before it starts is empty";
}

TEST(Uris, ArePathsAndBack) {
    const std::filesystem::path path("/a b/ü#%.fl");
    EXPECT_EQ(uri_of_path(path), "file:///a%20b/%C3%BC%23%25.fl");
    EXPECT_EQ(path_of_uri(uri_of_path(path)), path);
    EXPECT_EQ(path_of_uri("file://localhost/a.fl"), "/a.fl");
    EXPECT_TRUE(path_of_uri("untitled:one").empty());
    EXPECT_TRUE(path_of_uri("file:///a%00b").empty());
    EXPECT_EQ(path_of_uri("file:///a%2"), "/a%2");
}

TEST(Reference, HasEveryBuiltInFunction) {
    for (const std::string& name : check::function_names())
        EXPECT_FALSE(reference_of(name).empty()) << name << " is not in signatures.def";
    for (const char* name : {"Set", "Add", "Get", "Total", "Clear", "Sample1", "Sample2", "Sample3",
                             "Sample4", "Fraction", "BlueNoise"})
        EXPECT_FALSE(reference_of(name).empty()) << name;
    EXPECT_EQ(reference_of("Sample3").at(0).form,
              "float3 Sample3(float2 uv, int channel, float width = 1)");
    EXPECT_TRUE(reference_of("none").empty());
    EXPECT_TRUE(reference_of("").empty());
}

/// As many parameters as the checker takes, each with a type and a name.
TEST(Reference, SignaturesAreThoseOfTheChecker) {
    for (const check::Signature& one : check::signatures()) {
        const std::vector<std::string_view> parameters = check::parameters_of(one.form);
        for (std::string_view p : parameters)
            EXPECT_NE(p.find(' '), std::string_view::npos) << one.form;
        EXPECT_NE(one.form.find(" " + std::string(one.name) + "("), std::string_view::npos);
        EXPECT_FALSE(one.text.empty()) << one.form;
        const check::IntrinsicInfo* info = check::find_intrinsic(one.name);
        if (info == nullptr || one.name == "distance") continue;
        EXPECT_EQ(static_cast<int>(parameters.size()), info->arity) << one.form;
    }
    EXPECT_THAT(check::parameters_of("floatN lerp(floatN a, floatN b, floatN t)"),
                testing::ElementsAre("floatN a", "floatN b", "floatN t"));
    EXPECT_TRUE(check::parameters_of("float Total()").empty());
}

TEST(MessageReader, TakesMessagesFromAnyPieces) {
    const std::string bytes =
        framed("one") + "Content-Type: x\r\ncontent-length:3\r\n\r\ntwo" + framed("");
    for (const size_t piece : {size_t{1}, size_t{7}, bytes.size()}) {
        MessageReader reader;
        std::vector<std::string> got;
        for (size_t at = 0; at < bytes.size(); at += piece) {
            reader.add(std::string_view(bytes).substr(at, piece));
            while (const auto message = reader.next())
                got.push_back(*message);
        }
        EXPECT_THAT(got, testing::ElementsAre("one", "two", ""));
        EXPECT_FALSE(reader.broken());
    }
}

TEST(MessageReader, RefusesWhatIsNoHeaderOrTooLarge) {
    for (const std::string& bytes :
         {std::string("Content-Length: 99999999999\r\n\r\n"),
          std::string("Content-Length: 33554433\r\n\r\n"),
          std::string("Content-Length: -1\r\n\r\n"), std::string("Content-Length: 1x\r\n\r\n"),
          std::string("Content-Length:\r\n\r\n"), std::string("\r\n\r\n"),
          std::string("no header\r\n\r\n"),
          std::string("Content-Length: 1\r\nContent-Length: 2\r\n\r\n"), std::string(5000, 'a')}) {
        MessageReader reader;
        reader.add(bytes);
        EXPECT_FALSE(reader.next()) << bytes.substr(0, 60);
        EXPECT_TRUE(reader.broken()) << bytes.substr(0, 60);
    }
}

/// A mistake in syntax hides none in meaning, before it or after it.
TEST(Analysis, ShowsAllMistakes) {
    const std::string text =
        "fablet B {\n  @uniform { Material core, shell; }\n"
        "  @Volume(@varying { VolumeAttributes attr })\n  {\n    MaterialComposition mc;\n"
        "    float t = smothstep(0.5, 1, -distance(attr.voxelCenter));\n"
        "    mc.Set(core, t)\n    mc.Set(shel, 1 - t);\n    return mc;\n  }\n}\n";
    const Analysis analysis({}, text, {});
    std::vector<std::string> found;
    for (const diag::Diagnostic& d : analysis.diagnostics())
        found.emplace_back(diag::id_text(d.id));
    EXPECT_THAT(found, testing::ElementsAre("unknown-function", "expected", "unknown-name"));
}

TEST(Analysis, KnowsTheNamesOfEnums) {
    const std::string text =
        "enum Pattern { STRIPES, DOTS = 4 };\nfablet B {\n  @uniform { Material m; Pattern kind = "
        "DOTS; }\n"
        "  @Volume() { MaterialComposition mc; mc.Set(m, kind == STRIPES ? 1 : 0); return mc; "
        "}\n}\n";
    const Analysis analysis({}, text, {});
    EXPECT_TRUE(analysis.diagnostics().empty());
    const check::Use* type = analysis.name_at(static_cast<uint32_t>(text.rfind("Pattern")));
    ASSERT_NE(type, nullptr);
    EXPECT_EQ(describe(analysis, *type),
              "```openfl\nenum Pattern {\n    STRIPES,\n    DOTS = 4,\n};\n```\n");
    const check::Use* name = analysis.name_at(static_cast<uint32_t>(text.rfind("STRIPES")));
    ASSERT_NE(name, nullptr);
    EXPECT_EQ(name->declared.begin, text.find("STRIPES"));
}

TEST(Analysis, KnowsTheGoodPartsOfABadDocument) {
    const std::string text =
        "const float A = 1;\nfloat f(float x) { float y = x + A; return y; }\n"
        "fablet B {\n  @uniform { Material m; float u; }\n"
        "  @Volume(@varying { VolumeAttributes attr }) { float z = f(u) + nothing; attr. ";
    const Analysis analysis({}, text, {});
    EXPECT_GT(analysis.diagnostics().size(), 0U);
    const auto name = [&](std::string_view word) {
        const check::Use* use = analysis.name_at(static_cast<uint32_t>(text.rfind(word)));
        return use == nullptr ? std::string() : check::type_name(use->type) + " " + use->name;
    };
    EXPECT_EQ(name("y; }"), "float y");
    EXPECT_EQ(name("u)"), "float u");
    EXPECT_EQ(name("f(u"), "float f");
    EXPECT_EQ(name("attr."), "VolumeAttributes attr");
    EXPECT_EQ(name("nothing"), "");
}

TEST(Analysis, KnowsShapesAndRulesThatGrow) {
    const std::string text =
        "struct Node { float3 end[2]; float radius[2]; int children; float reach; };\n"
        "fablet Ball {\n  @uniform { Material m; }\n"
        "  @Shape(@varying { ShapeAttributes place, out float tint }) { tint = place.p.x; return "
        "length(place.p) - 3; }\n"
        "  @Volume(@varying { VolumeAttributes attr, @nearest float tint }) { MaterialComposition "
        "mc; mc.Set(m, tint); return mc; }\n}\n"
        "fablet Stick {\n  @uniform { Material m; }\n"
        "  @Grow(@varying { GrowAttributes rule, Node parent }) { Node n = parent; n.children = "
        "rule.level < 3 ? 2 : 0; n.reach = 2; return n; }\n"
        "  @Volume() { MaterialComposition mc; mc.Set(m, 1); return mc; }\n}\n";
    const Analysis analysis({}, text, {});
    for (const diag::Diagnostic& d : analysis.diagnostics())
        ADD_FAILURE() << diag::id_text(d.id);
    const auto type = [&](std::string_view word) {
        const check::Use* use = analysis.name_at(static_cast<uint32_t>(text.rfind(word)));
        return use == nullptr ? std::string() : check::type_name(use->type);
    };
    EXPECT_EQ(type("place.p) - 3"), "ShapeAttributes");
    EXPECT_EQ(type("rule.level"), "GrowAttributes");
    EXPECT_EQ(type("parent; n.children"), "Node");
    EXPECT_EQ(type("tint); return mc"), "float");
}

TEST(Server, AnswersWhatIsNotJsonOrNotAMessage) {
    Server server;
    EXPECT_THAT(server.handle("{").at(0), testing::HasSubstr("-32700"));
    EXPECT_THAT(server.handle("[]").at(0), testing::HasSubstr("-32600"));
    EXPECT_THAT(server.handle(R"({"id":1,"result":2})"), testing::IsEmpty());
    EXPECT_THAT(server.handle(R"({"id":"a","method":"x"})").at(0), testing::HasSubstr("-32002"));
    server.handle(R"({"method":"exit"})");
    EXPECT_TRUE(server.exited());
    EXPECT_EQ(server.exit_code(), 1);
}

TEST(Server, CountsBytesWhereTheClientPrefersThem) {
    Server server;
    const std::string answer =
        server
            .handle(
                R"({"id":1,"method":"initialize","params":{"capabilities":{"general":{"positionEncodings":["utf-8","utf-16"]}}}})")
            .at(0);
    EXPECT_THAT(answer, testing::HasSubstr(R"("positionEncoding":"utf-8")"));
    server.handle(
        R"({"method":"textDocument/didOpen","params":{"textDocument":{"uri":"untitled:a","version":1,"text":"/* é */ float f() { return x; }"}}})");
    const std::vector<std::string> published = server.publish();
    ASSERT_EQ(published.size(), 1U);
    EXPECT_THAT(published[0], testing::HasSubstr(R"("start":{"line":0,"character":28})"));
}

}  // namespace
}  // namespace openfab::server

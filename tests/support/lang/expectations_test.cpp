// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/lang/expectations.h"

#include <gtest/gtest.h>

#include "compiler/frontend/frontend.h"

namespace openfab::testing {
namespace {

std::string check(const std::string& text) {
    source::SourceManager sources;
    diag::Sink sink;
    const uint32_t file = sources.add("test.fl", text);
    (void)frontend::compile_to_ir(sources, file, sink);
    return difference(expected_diagnostics(text), actual_diagnostics(sink, sources));
}

std::string program(const std::string& expectations) {
    return "fablet A { @Volume() {\n"
           "    MaterialComposition mc;\n"
           "    float wide = thick;\n" +
           expectations + "    return mc; } }\n";
}

TEST(Expectations, TheRightOnePasses) {
    EXPECT_EQ(check(program(
                  "//               ^~~~~ error: `thick` is not declared here [unknown-name]\n")),
              "");
}

TEST(Expectations, AMissingMessageIsAFault) {
    EXPECT_NE(check("fablet A { @Volume() { MaterialComposition mc; return mc; } }\n"
                    "//   ^ error: `x` is not declared here [unknown-name]\n"),
              "");
}

TEST(Expectations, AnExtraMessageIsAFault) {
    EXPECT_NE(check(program("")), "");
}

TEST(Expectations, AWrongColumnIsAFault) {
    EXPECT_NE(check(program(
                  "//              ^~~~~ error: `thick` is not declared here [unknown-name]\n")),
              "");
}

TEST(Expectations, AWrongWidthIsAFault) {
    EXPECT_NE(check(program(
                  "//               ^~~~ error: `thick` is not declared here [unknown-name]\n")),
              "");
}

TEST(Expectations, AWrongSeverityIdOrTextIsAFault) {
    EXPECT_NE(check(program(
                  "//               ^~~~~ warning: `thick` is not declared here [unknown-name]\n")),
              "");
    EXPECT_NE(check(program(
                  "//               ^~~~~ error: `thick` is not declared here [unknown-type]\n")),
              "");
    EXPECT_NE(check(program(
                  "//               ^~~~~ error: `thin` is not declared here [unknown-name]\n")),
              "");
}

TEST(Expectations, AHelpThatIsNotGivenIsAFault) {
    EXPECT_NE(
        check(program("//               ^~~~~ error: `thick` is not declared here [unknown-name]\n"
                      "// help: did you mean `thin`?\n")),
        "");
}

TEST(Expectations, UpdatingGivesAFileThatPasses) {
    std::string text = program("");
    for (int i = 0; i < 2; ++i) {
        source::SourceManager sources;
        diag::Sink sink;
        const uint32_t file = sources.add("test.fl", text);
        (void)frontend::compile_to_ir(sources, file, sink);
        text = with_expectations(text, sink, sources);
    }
    EXPECT_EQ(check(text), "");
}

}  // namespace
}  // namespace openfab::testing

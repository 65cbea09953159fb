// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The postcard of the paper after each step of the front end, as openflc dumps it.
// OPENFAB_UPDATE=1 in the environment rewrites the files; review what changed.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

#include "base/messages.h"
#include "tests/support/places/places.h"

namespace {

struct Output {
    std::string text;
    int exit_code = -1;
};

Output run(const std::string& arguments) {
    Output out;
    FILE* pipe =
        popen((openfab::testing::program("openflc").string() + " " + arguments).c_str(), "r");
    if (pipe == nullptr) return out;
    std::array<char, 4096> buffer{};
    size_t count = 0;
    while ((count = fread(buffer.data(), 1, buffer.size(), pipe)) > 0)
        out.text.append(buffer.data(), count);
    const int status = pclose(pipe);
    out.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return out;
}

const std::string kRoot = openfab::testing::source_dir();
const std::string kPostcard = kRoot + "/gallery/magic_postcard/magic_postcard.fl";

std::string read(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void check(const std::string& arguments, const std::string& name) {
    const Output out = run(arguments + " " + kPostcard);
    EXPECT_EQ(out.exit_code, 0);
    const std::string path = kRoot + "/tests/golden/frontend/" + name;
    if (std::getenv("OPENFAB_UPDATE") != nullptr) std::ofstream(path, std::ios::binary) << out.text;
    EXPECT_FALSE(out.text.empty());
    EXPECT_EQ(out.text, read(path)) << name;
}

TEST(FrontendGolden, Tokens) {
    check("emit --as tokens", "magic_postcard.tokens");
}
TEST(FrontendGolden, Ast) {
    check("emit --as ast", "magic_postcard.ast");
}
TEST(FrontendGolden, Ir) {
    check("emit --as ir", "magic_postcard.ir");
}
TEST(FrontendGolden, SurfaceIr) {
    check("emit --as ir --stage surface", "magic_postcard.surface.ir");
}
TEST(FrontendGolden, Describe) {
    check("describe", "magic_postcard.json");
}

TEST(Openflc, ChecksThePostcard) {
    const Output out = run("check " + kPostcard + " 2>&1");
    EXPECT_EQ(out.exit_code, 0);
    EXPECT_EQ(out.text, "");
}

TEST(Openflc, ExitCodesSayWhatIsWrong) {
    EXPECT_EQ(run("check " + kRoot + "/tests/lang/fail/unknown_name.fl 2>/dev/null").exit_code, 1);
    EXPECT_EQ(run("check " + kRoot + "/tests/lang/warn/narrowing.fl 2>/dev/null").exit_code, 0);
    EXPECT_EQ(run("2>/dev/null").exit_code, 0);  // lists the commands
    EXPECT_EQ(run("emit --as nonsense " + kPostcard + " 2>/dev/null").exit_code, 2);
    EXPECT_EQ(run("check no/such/file.fl 2>/dev/null").exit_code, 3);
    EXPECT_EQ(run("check " + kRoot + "/tests 2>/dev/null").exit_code, 1);
}

TEST(Openflc, DataGoesToStdoutAndDiagnosticsToStderr) {
    const std::string file = kRoot + "/tests/lang/fail/unknown_name.fl";
    EXPECT_EQ(run("check " + file + " 2>/dev/null").text, "");
    const std::string json = run("--diagnostics=json check " + file + " 2>&1 >/dev/null").text;
    EXPECT_NE(json.find(R"("id":"unknown-name","severity":"error")"), std::string::npos) << json;
    EXPECT_THAT(json,
                ::testing::HasSubstr(fmt::format(
                    R"("help":["{}"])", fmt::format(openfab::messages::kDidYouMean, "thickness"))));
}

TEST(Openflc, AScheduleThatIsWrongIsADiagnosticOnItsLine) {
    const std::string path = ::testing::TempDir() + "/slab.sched";
    std::ofstream(path, std::ios::binary) << "# a comment\nwhatever this is\n";
    const Output out = run("build " + kPostcard + " --schedule " + path + " -o " +
                           ::testing::TempDir() + "/unused 2>&1");
    EXPECT_EQ(out.exit_code, 1);
    EXPECT_NE(out.text.find("slab.sched:2:"), std::string::npos) << out.text;
    EXPECT_NE(out.text.find(" [schedule-illegal]\n 2 | whatever this is\n"), std::string::npos)
        << out.text;
}

TEST(Openflc, MeasuresWhetherAShapeIsTheDistanceThatItClaims) {
    const std::string path = ::testing::TempDir() + "/claim.fl";
    const auto check = [&](const std::string& value) {
        std::ofstream(path, std::ios::binary)
            << "fablet A {\n    @Shape(@varying { ShapeAttributes attr }) [[ distance ]]\n    { "
               "return " +
                   value + "; }\n}\n";
        return run("check " + path + " 2>&1");
    };
    EXPECT_EQ(check("length(attr.p) - 5").text, "");
    const Output out = check("2 * (length(attr.p) - 5)");
    EXPECT_EQ(out.exit_code, 0);
    EXPECT_NE(out.text.find("claim.fl:2:50: warning: the shape of `A` is not a distance: at ("),
              std::string::npos)
        << out.text;
    EXPECT_NE(out.text.find(" [no-distance]\n"), std::string::npos) << out.text;
}

}  // namespace

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Messages and streams of programs: unread, on a full disk, or with names that try to control the
// terminal.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <rapidjson/document.h>

#include <cstring>

#include "backends/common/messages.h"
#include "base/messages.h"
#include "tests/programs/print/simple_world.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

class Streams : public ::testing::Test {
  protected:
    Streams() {
        scratch_.write("f.fl",
                       "fablet Tint {\n    @uniform { Material a; float w = 1; }\n"
                       "    @Volume(@varying { VolumeAttributes attr }) {\n"
                       "        MaterialComposition mc;\n        mc.Set(a, w);\n"
                       "        return mc;\n    }\n}\n");
        write_world("world.fab.json", "thing", "[12, 8, 6]");
    }
    void write_world(const std::string& name, const std::string& object, const std::string& box) {
        const std::string mesh = fmt::format(R"({{"box": {}}})", box);
        scratch_.write(name, SimpleWorld{"Tint", mesh, "generic", object}.text());
    }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    /// `command` has `{print}`, `{openfab}`, `{openflc}` and `{dir}` replaced.
    Outcome shell(std::string command) const {
        const std::pair<const char*, std::string> words[] = {
            {"{print}", test_program("openfab_test_print_4")},
            {"{openfab}", program("openfab")},
            {"{openflc}", program("openflc")},
            {"{dir}", scratch_.path().string()}};
        for (const auto& [word, text] : words) {
            for (size_t at = 0; (at = command.find(word)) != std::string::npos;)
                command.replace(at, std::strlen(word), text);
        }
        return run({"/bin/bash", "-c", "set -o pipefail; " + command});
    }

    ScratchFolder scratch_;
};

TEST_F(Streams, APrintDoesNotEndWithWhoeverReadsItsMessages) {
    ASSERT_EQ(shell("{print} {dir}/world.fab.json -o {dir}/whole.ofr").exit_code, 0);
    const std::string whole = read_file(path("whole.ofr"));
    ASSERT_GT(whole.size(), 1000u);
    for (const std::string progress : {"auto", "plain", "json", "none"}) {
        for (const std::string where :
             {"2> /dev/full", "2>&-", "> /dev/null 2>&-", ">&- 2>&-", "<&- >&- 2>&-",
              "2>&1 > /dev/null | head -c 1", "2>&1 > /dev/null | true"}) {
            fs::remove(path("a.ofr"));
            const Outcome outcome = shell(
                "{print} {dir}/world.fab.json -o {dir}/a.ofr --progress " + progress + " " + where);
            EXPECT_EQ(outcome.exit_code, 0) << progress << " " << where << ": " << outcome.err;
            EXPECT_TRUE(read_file(path("a.ofr")) == whole) << progress << " " << where;
        }
    }
    // The message of a failure is lost as well, its exit code is not.
    for (const std::string where : {"2> /dev/full", "2>&-"}) {
        EXPECT_EQ(shell("{print} {dir}/none.fab.json -o {dir}/b.ofr " + where).exit_code, 1);
        EXPECT_EQ(shell("{print} --nonsense " + where).exit_code, 2);
        EXPECT_EQ(shell("{openfab} info {dir}/none.ofr " + where).exit_code, 1);
        EXPECT_EQ(shell("{openfab} nonsense " + where).exit_code, 2);
        EXPECT_EQ(shell("{openflc} check {dir}/world.fab.json " + where).exit_code, 1);
        EXPECT_EQ(shell("{openflc} nonsense " + where).exit_code, 2);
    }
}

TEST_F(Streams, AResultThatCannotBeWrittenIsAFailureOfTheOutside) {
    ASSERT_EQ(shell("{print} {dir}/world.fab.json -o {dir}/a.ofr").exit_code, 0);
    for (const std::string command :
         {"{openfab} info {dir}/a.ofr", "{openfab} info {dir}/world.fab.json", "{openfab} --help",
          "{openfab} print --help", "{openfab} info --help", "{print} --help",
          "{print} {dir}/world.fab.json -o -", "{openflc} --help", "{openflc} describe {dir}/f.fl",
          "{openflc} describe --help", "{openflc} emit --stage slab {dir}/f.fl",
          "{openflc} emit --as tokens {dir}/f.fl", "{openflc} emit --as ast {dir}/f.fl"}) {
        for (const std::string where : {"> /dev/full", ">&-"}) {
            const Outcome outcome = shell(command + " " + where);
            EXPECT_EQ(outcome.exit_code, 3) << command << " " << where << ": " << outcome.err;
            EXPECT_THAT(outcome.err,
                        ::testing::AnyOf(testing::Says(backends::messages::kStandardOutput),
                                         testing::Says(messages::kCannotWriteOut)))
                << command;
        }
        EXPECT_EQ(shell(command + " > /dev/null").exit_code, 0) << command;
    }
    // A statistics file, too; the slices stay.
    const Outcome outcome =
        shell("{print} {dir}/world.fab.json -o {dir}/b.ofr --stats /dev/full --progress none");
    EXPECT_EQ(outcome.exit_code, 3) << outcome.err;
    EXPECT_TRUE(read_file(path("b.ofr")) == read_file(path("a.ofr")));
}

std::string without_line_ends(std::string text) {
    std::erase(text, '\n');
    return text;
}

/// No control character, ESC and C1 among them, and nothing that changes the text direction.
void expect_harmless(const Outcome& outcome) {
    for (const std::string& text : {outcome.out, outcome.err}) {
        for (const char c : without_line_ends(text)) {
            EXPECT_TRUE(static_cast<unsigned char>(c) >= 0x20 && c != 0x7f)
                << static_cast<int>(c) << " in " << text;
        }
        EXPECT_THAT(text, Not(HasSubstr("\u202e")));
        EXPECT_THAT(text, Not(HasSubstr("\u009b")));
        EXPECT_THAT(text, Not(HasSubstr("\xff")));
    }
}

TEST_F(Streams, NamesCommandNoTerminal) {
    // Both JSON escapes and raw bytes; a warning names a thin part.
    write_world("evil.fab.json", R"(a\u001b]0;pwn\u0007\u202eb\u009b2J\nc \u00fc)", "[4, 4, 0.01]");
    const std::string file = path("w\x1b[2J\xff\u202e.fab.json");
    fs::rename(path("evil.fab.json"), file);
    const std::string quoted = "$'" + path("w") + "\\x1b[2J\\xff\\u202e.fab.json'";

    const Outcome printed = shell("{print} " + quoted + " -o {dir}/a.ofr --stats {dir}/s.json");
    EXPECT_EQ(printed.exit_code, 0) << printed.err;
    expect_harmless(printed);
    EXPECT_THAT(printed.err, HasSubstr("a\\x1b]0;pwn\\x07\\u{202e}b\\u{9b}2J\\nc ü"));
    rapidjson::Document stats;
    stats.Parse<rapidjson::kParseValidateEncodingFlag>(read_file(path("s.json")).c_str());
    ASSERT_FALSE(stats.HasParseError());
    EXPECT_THAT(stats["title"].GetString(), HasSubstr("\uFFFD"));

    for (const std::string& command :
         {"{openfab} info " + quoted, std::string("{openfab} info {dir}/a.ofr"),
          "{print} " + quoted + " -o {dir}/x.ofr --set $'\\x1b[1m.a=1'",
          std::string("{print} $'{dir}/\\x1b[1mnone.fab.json' -o {dir}/x.ofr"),
          std::string("{openfab} info $'{dir}/\\x1b[1mnone'"),
          std::string("{openfab} $'\\x1b[1mnone'"), std::string("{openflc} $'\\x1b[1mnone'"),
          std::string("{print} $'--\\x1b[1mnone'"),
          std::string("{openflc} check $'{dir}/\\x1b[1mnone.fl'"), "{openfab} verify " + quoted}) {
        const Outcome outcome = shell(command);
        expect_harmless(outcome);
        EXPECT_FALSE((outcome.err + outcome.out).empty()) << command;
    }
    ASSERT_EQ(shell("{print} " + quoted + " -o {dir}/slices --format png").exit_code, 0);
    expect_harmless({0, read_file(path("slices/HANDOFF.txt")), ""});
    rapidjson::Document manifest;
    manifest.Parse<rapidjson::kParseValidateEncodingFlag>(
        read_file(path("slices/manifest.json")).c_str());
    EXPECT_FALSE(manifest.HasParseError());
    const Outcome folder = shell("{openfab} info {dir}/slices");
    EXPECT_EQ(folder.exit_code, 0) << folder.err;
    expect_harmless(folder);
}

TEST_F(Streams, SourcesCommandNoTerminalAndJsonStaysJson) {
    scratch_.write(
        "evil.fl",
        "fablet Evil { // \x1b[31m \u202e \u009b\n    @uniform { Material a; float w = 1 "
        "[[ string help = \"x\u202ey\u009b\" ]]; }\n"
        "    @Volume(@varying { VolumeAttributes attr }) {\n"
        "        MaterialComposition mc;\n        mc.Set(a, w); /* \u202e */ wrong;\n"
        "        return mc;\n    }\n}\n");
    const Outcome checked = shell("{openflc} check {dir}/evil.fl");
    EXPECT_EQ(checked.exit_code, 1);
    expect_harmless(checked);
    const Outcome json = shell("{openflc} --diagnostics json check {dir}/evil.fl");
    expect_harmless(json);
    rapidjson::Document document;
    document.Parse<rapidjson::kParseValidateEncodingFlag>(json.err.c_str());
    EXPECT_FALSE(document.HasParseError()) << json.err;

    std::string text = read_file(path("evil.fl"));
    text.erase(text.find("wrong;"), 6);
    scratch_.write("evil.fl", text);
    const Outcome described = shell("{openflc} describe {dir}/evil.fl");
    EXPECT_EQ(described.exit_code, 0) << described.err;
    expect_harmless(described);
    document.Parse<rapidjson::kParseValidateEncodingFlag>(described.out.c_str());
    ASSERT_FALSE(document.HasParseError()) << described.out;
    EXPECT_STREQ(document["fablets"][0]["uniforms"][1]["annotations"]["help"].GetString(),
                 "x\u202ey\u009b");
    expect_harmless(shell("{openflc} emit --as tokens {dir}/evil.fl"));
    expect_harmless(shell("{openflc} emit --as ast {dir}/evil.fl"));
    expect_harmless(shell("{openflc} emit {dir}/evil.fl"));
}

TEST_F(Streams, DescribeListsTheNamesOfValues) {
    scratch_.write(
        "names.fl",
        "enum Look { PLAIN, SPOTS = 4 [[ string label = \"with \u00a7 spots\" ]] };\n"
        "fablet F {\n    @uniform { Material a; Look look = SPOTS; Look two[2];\n"
        "        bool hollow = false [[ string on = \"hollow\" ]]; bool plain; int number; }\n"
        "    @Volume() { MaterialComposition mc; mc.Set(a, look); return mc; }\n}\n");
    const Outcome described = shell("{openflc} describe {dir}/names.fl");
    EXPECT_EQ(described.exit_code, 0) << described.err;
    const std::string look =
        R"("annotations":{},"enum":"Look","choices":[{"name":"PLAIN","label":"PLAIN","value":0},{"name":"SPOTS","label":"with § spots","value":4}]})";
    EXPECT_NE(
        described.out.find(
            R"({"name":"look","type":"int","kind":"value","components":1,"array_length":1,"default":[4],)" +
            look),
        std::string::npos)
        << described.out;
    EXPECT_NE(described.out.find(R"("array_length":2,"default":null,)" + look), std::string::npos)
        << described.out;
    EXPECT_NE(
        described.out.find(
            R"("annotations":{"on":"hollow"},"choices":[{"name":"false","label":"off","value":0},{"name":"true","label":"hollow","value":1}]})"),
        std::string::npos)
        << described.out;
    EXPECT_NE(
        described.out.find(
            R"({"name":"plain","type":"bool","kind":"value","components":1,"array_length":1,"default":null,"annotations":{}})"),
        std::string::npos)
        << described.out;
    EXPECT_NE(
        described.out.find(
            R"({"name":"number","type":"int","kind":"value","components":1,"array_length":1,"default":null,"annotations":{}})"),
        std::string::npos)
        << described.out;
}

TEST_F(Streams, MisspeltCommandsAndOptionsAreNamed) {
    const std::pair<std::string, std::string> cases[] = {
        {"{openfab} prnt {dir}/world.fab.json -o a",
         fmt::format(messages::kNoSuchArgument, "command", "prnt") + "; " +
             fmt::format(messages::kDidYouMean, "print")},
        {"{openfab} inof {dir}/a.ofr", fmt::format(messages::kDidYouMean, "info")},
        {"{openfab} frobnicate", fmt::format(messages::kNoSuchArgument, "command", "frobnicate")},
        {"{openfab} print {dir}/world.fab.json --prevew a.png",
         fmt::format(messages::kDidYouMean, "--preview")},
        {"{openfab} export {dir}/a.ofr --ouput a", fmt::format(messages::kDidYouMean, "--output")},
        {"{openflc} descirbe {dir}/f.fl", fmt::format(messages::kDidYouMean, "describe")},
        {"{print} {dir}/world.fab.json more", "`more`"}};
    for (const auto& [command, says] : cases) {
        const Outcome outcome = shell(command);
        EXPECT_EQ(outcome.exit_code, 2) << command;
        EXPECT_THAT(outcome.err, HasSubstr(says)) << command;
    }
}

}  // namespace
}  // namespace openfab::testing

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "client/print_words.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "program/progress.h"

namespace openfab::client {
namespace {

/// Returns what a print with `--progress json` writes of an error.
std::string written(const Error& error, std::string_view setting) {
    std::FILE* file = std::tmpfile();
    program::Progress progress(program::ProgressMode::kJson, file);
    progress.warn("a warning");
    progress.fail(error, setting);
    std::string text(static_cast<size_t>(std::ftell(file)), ' ');
    std::rewind(file);
    EXPECT_EQ(std::fread(text.data(), 1, text.size(), file), text.size());
    std::fclose(file);
    return text;
}

TEST(PrintWords, AnErrorAboutASettingIsToldByItsNameNotItsWording) {
    const std::string setting = "cube.name=\"a: error: --set b\"";
    const Error error =
        error_at({"--set " + setting, 0, 0}, "this is `any` wording,\n of two lines", "\xff help");
    const PrintWords words = words_of(written(error, setting), false);
    EXPECT_EQ(words.text, "warning: a warning\n");
    ASSERT_EQ(words.settings.size(), 1u);
    EXPECT_EQ(words.settings[0].setting, setting);
    EXPECT_EQ(words.settings[0].text, "this is `any` wording,\n of two lines; \xef\xbf\xbd help");
    EXPECT_EQ(words.all().substr(0, words.text.size()), words.text);
    EXPECT_NE(words.all().find(setting), std::string::npos);
}

TEST(PrintWords, AnErrorIsTheOneOfThePrintWithItsLocation) {
    const PrintWords words =
        words_of("openfab print: something\n" +
                     written(error_at({"none.fab.json", 7, 9}, "unknown key", "drop it"), {}),
                 false);
    EXPECT_TRUE(words.settings.empty());
    EXPECT_EQ(words.text,
              "openfab print: something\nwarning: a warning\n"
              "none.fab.json:7:9: error: unknown key\nhelp: drop it\n");
    EXPECT_EQ(words.all(), words.text);
    const PrintWords plain = words_of(written(user_error("no such file", "look"), {}), false);
    EXPECT_EQ(plain.text, "warning: a warning\nerror: no such file; look\n");
}

TEST(PrintWords, OfAPrintThatWentWellWarningsAndNotes) {
    const PrintWords words = words_of(std::string("a line\nwarning: another\nnote: a line\n") +
                                          "{\"event\": \"note\", \"text\": \"39 % of `ball`\"}\n" +
                                          written(user_error("why"), {}),
                                      true);
    EXPECT_EQ(words.text,
              "warning: another\nnote: a line\nnote: 39 % of `ball`\nwarning: a warning\n");
    EXPECT_TRUE(words.settings.empty());
}

TEST(PrintWords, TheLastErrorOfAPrintIsWhyItFailed) {
    const std::string err =
        "{\"event\": \"error\", \"text\": \"first\"}\n"
        "{\"event\": \"error\", \"text\": \"last\", \"help\": \"do\", \"file\": \"w.json\", "
        "\"line\": 3, "
        "\"column\": 4}\n{\"event\": \"warning\", \"text\": \"behind\"}\n";
    const Error error = client::print_error(err, exit_code(ErrorCode::kUserInput));
    EXPECT_EQ(error.text(), "w.json:3:4: last; do");
    EXPECT_EQ(error.code, ErrorCode::kUserInput);
    EXPECT_EQ(client::print_error(err, exit_code(ErrorCode::kOutside)).code, ErrorCode::kOutside);
    // As a print writes it now.
    const Error own = client::print_error(
        "compiling ...\n" + written(error_at({"w.json", 3, 4}, "open", "close it"), {}),
        exit_code(ErrorCode::kUserInput));
    EXPECT_EQ(own.text(), "w.json:3:4: open; close it");
    // Words without events are relayed, and the error keeps the code.
    EXPECT_EQ(client::print_error("", exit_code(ErrorCode::kUsage)).code, ErrorCode::kUsage);
    EXPECT_EQ(
        client::print_error("{\"event\": \"error\", ", exit_code(ErrorCode::kUserInput)).message,
        "");
}

}  // namespace
}  // namespace openfab::client

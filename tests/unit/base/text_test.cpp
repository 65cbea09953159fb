// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/text.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>

#include "base/caret.h"
#include "base/messages.h"
#include "base/plain_text.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"

namespace openfab {
namespace {

TEST(Text, ReadableTextOfAnyScriptStays) {
    for (const std::string text :
         {"plain ~", "größe µm · 材料 · مادة · 🧵", "a\\b \"c\" 'd'",
          "\xF4\x8F\xBF\xBD" /* almost the last code point */, "क्‍ष" /* a joiner */}) {
        EXPECT_EQ(printable(text), text);
        EXPECT_EQ(printable_lines(text), text);
        EXPECT_EQ(valid_utf8(text), text);
    }
}

TEST(PlainText, HasLineFeedsAndNoMark) {
    const auto plain = [](std::string_view text) { return std::string(PlainText(text).text()); };
    EXPECT_EQ(plain("\xEF\xBB\xBF"
                    "a\r\nb\n"),
              "a\r\nb\n");
    EXPECT_EQ(plain("a\rb\r"), "a\nb\r");
    EXPECT_EQ(plain("a\r\rb\r\r\nc"), "a\n\nb\r\r\nc");
    EXPECT_EQ(plain("\xEF\xBB\xBF"), "");
    EXPECT_EQ(PlainText("a\r\nb").copied_bytes(), 0);
    EXPECT_EQ(PlainText("a\rb").copied_bytes(), 3);
}

TEST(PlainText, NamesWideEncodings) {
    using namespace std::string_view_literals;
    EXPECT_EQ(wide_encoding("\xFF\xFE"
                            "a\0"sv),
              "UTF-16");
    EXPECT_EQ(wide_encoding("\xFE\xFF\0a"sv), "UTF-16");
    EXPECT_EQ(wide_encoding("\xFF\xFE\0\0a\0\0\0"sv), "UTF-32");
    EXPECT_EQ(wide_encoding("s\0o\0l\0i\0"sv), "UTF-16");
    EXPECT_EQ(wide_encoding("\0s\0o\0l\0i"sv), "UTF-16");
    for (const std::string_view text :
         {""sv, "a"sv, "solid abc"sv, "größe"sv, "\0\0\0\0\0\0\0\0"sv})
        EXPECT_EQ(wide_encoding(text), "");
    EXPECT_EQ(not_utf8("\xFF\xFE"
                       "a\0"sv)
                  .what,
              fmt::format(messages::kWideText, "UTF-16"));
}

TEST(Text, TakesOtherBytesAsLatin1) {
    EXPECT_EQ(utf8_or_latin1("größe"), "größe");
    EXPECT_EQ(utf8_or_latin1("gr\xF6\xDF"
                             "e"),
              "größe");
}

TEST(Text, WhatCommandsATerminalIsEscaped) {
    EXPECT_EQ(printable("a\x1b[31mb"), "a\\x1b[31mb");
    EXPECT_EQ(printable(std::string("\0\a\b\r\x7f", 5)), "\\x00\\x07\\x08\\x0d\\x7f");
    EXPECT_EQ(printable("one\ntwo\tthree"), "one\\ntwo\\tthree");
    EXPECT_EQ(printable_lines("one\ntwo\tthree\r"), "one\ntwo\tthree\\x0d");
    EXPECT_EQ(printable("\u009b31m"), "\\u{9b}31m");  // the one-character form of ESC [
    EXPECT_EQ(printable("ab\u202egnp.exe"), "ab\\u{202e}gnp.exe");
    EXPECT_EQ(printable("\u2066x\u2069\u2028\ufeff\u200f"),
              "\\u{2066}x\\u{2069}\\u{2028}\\u{feff}\\u{200f}");
    EXPECT_EQ(printable("\U000E0041"), "\\u{e0041}");
}

TEST(Text, BytesThatAreNotUtf8AreShownAsBytes) {
    EXPECT_EQ(printable("\x9b\x31m"), "\\x9b1m");
    EXPECT_EQ(printable("a\xffz"), "a\\xffz");
    EXPECT_EQ(printable("\xC3"), "\\xc3");                             // cut short
    EXPECT_EQ(printable("\xC0\x9b"), "\\xc0\\x9b");                    // overlong
    EXPECT_EQ(printable("\xE0\x82\x9B"), "\\xe0\\x82\\x9b");           // overlong C1
    EXPECT_EQ(printable("\xED\xA0\x80"), "\\xed\\xa0\\x80");           // a surrogate
    EXPECT_EQ(printable("\xF4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");  // beyond the last
    EXPECT_EQ(valid_utf8("a\xffz\xC3"), "a\uFFFDz\uFFFD");
}

// Composed messages may contain text that is already escaped.
TEST(Text, EscapingTwiceIsEscapingOnce) {
    std::string all;
    for (int byte = 0; byte < 256; ++byte)
        all += static_cast<char>(byte);
    all += "\u0085\u202d\U000E0020";
    const std::string once = printable(all);
    EXPECT_EQ(printable(once), once);
    EXPECT_EQ(printable_lines(once), once);
    for (const char c : once)
        EXPECT_TRUE(static_cast<unsigned char>(c) >= 0x20 && c != 0x7f);
}

TEST(Text, JsonStaysTheSameJson) {
    EXPECT_EQ(printable_json("{\"a\": \"x\u202ey\u009b\"}\n"), "{\"a\": \"x\\u202ey\\u009b\"}\n");
    EXPECT_EQ(printable_json("[\"\U000E0041\x7f\"]"), "[\"\\udb40\\udc41\\u007f\"]");
    EXPECT_EQ(printable_json("\"\xff\""), "\"\\ufffd\"");
    EXPECT_EQ(printable_json("{\n\t\"größe\": \"\\u001b\"}"), "{\n\t\"größe\": \"\\u001b\"}");
}

TEST(Text, AnErrorIsOneLineWhateverNamesHold) {
    EXPECT_EQ(render_error(user_error("cannot open `a\nerror: b\x1b[2J`")),
              "error: cannot open `a\\nerror: b\\x1b[2J`\n");
}

TEST(Text, TheCaretStandsBelowItsTokenBehindEscapes) {
    const testing::ScratchFolder scratch;
    scratch.write("w.json", "{\"\x1b[31m\": \"b\x9b\", \"c\": 1}\n");
    const std::string file = (scratch / "w.json").string();
    // Stray continuation bytes take no column of their own.
    EXPECT_EQ(render_error(error_at({file, 1, 11}, "what", "help\x1b")),
              file + ":1:11: error: what\n" +
                  " 1 | {\"\\x1b[31m\": \"b\\x9b\", \"c\": 1}\n"
                  "   |              ^~~~~~~\n"
                  "help: help\\x1b\n");
}

// The location may be forged by the name of a file.
TEST(Text, APlaceInAPipeOrFarOutIsNotLookedUp) {
    EXPECT_EQ(render_error(error_at({"/dev/zero", 1, 1}, "oh")), "/dev/zero:1:1: error: oh\n");
    const testing::ScratchFolder scratch;
    scratch.write("short", "ab\n");
    const std::string file = (scratch / "short").string();
    const std::string text = render_error(error_at({file, 1, 99999999}, "oh"));
    EXPECT_LT(text.size(), 2 * file.size() + 200);
}

TEST(ShellWord, IsQuotedWhereAShellWouldTakeItApart) {
    EXPECT_EQ(shell_word("made/part-1.ofr"), "made/part-1.ofr");
    EXPECT_EQ(shell_word("my part (1).ofr"), "'my part (1).ofr'");
    EXPECT_EQ(shell_word("Ada's.ofr"), "'Ada'\\''s.ofr'");
    EXPECT_EQ(shell_word(""), "''");
}

// Only one file writes messages, so that only one has to keep terminals safe.
TEST(Text, ProgramsWriteByOneDoor) {
    const std::string root = testing::source_dir();
    // say.cpp itself; the progress bar, which shows no names; assertions; build tools.
    const std::set<std::string> exempt = {
        "base/say.cpp", "program/progress.cpp", "compiler/schedule/schedule.cpp",
        "compiler/stages/stage_gen.cpp", "runtime/dither/blue_noise_gen.cpp"};
    const std::regex writes(
        R"(fmt::print\(|std::(cout|cerr|puts|fputs|printf)\b|fprintf\(|perror\()");
    int files = 0;
    for (const char* folder :
         {"runtime", "backends", "compiler", "tools/openfab", "tools/texture"}) {
        for (const auto& entry :
             std::filesystem::recursive_directory_iterator(root + "/" + folder)) {
            const std::string extension = entry.path().extension().string();
            const std::string name = entry.path().lexically_relative(root).string();
            if ((extension != ".cpp" && extension != ".h") || exempt.contains(name)) continue;
            ++files;
            const std::string text = testing::read_file(entry.path());
            std::smatch found;
            EXPECT_FALSE(std::regex_search(text, found, writes))
                << name << " writes by " << found.str() << "; base/say.h does";
        }
    }
    EXPECT_GT(files, 300);
}

}  // namespace
}  // namespace openfab

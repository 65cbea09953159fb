// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/json.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>

#include "base/caret.h"
#include "base/messages.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/says/says.h"

namespace openfab::testing {
namespace {

std::string error_of(std::string_view text) {
    const Result<JsonValue> parsed = parse_json(text, "f.json");
    return parsed ? "no error" : parsed.error().text();
}

TEST(Json, KnowsWhereEveryTokenStands) {
    const Result<JsonValue> root = parse_json(
        "{\n  \"a\" : [1, -2.5e1 , \"x\"],\n\t\"\xC3\xA4\":{\"b\":true},\"c\":null}\n", "f");
    ASSERT_TRUE(root) << root.error().text();
    ASSERT_EQ(root->members.size(), 3u);
    const JsonMember& a = root->members[0];
    EXPECT_EQ(a.line, 2);
    EXPECT_EQ(a.column, 3);
    EXPECT_EQ(a.value.column, 9);
    EXPECT_EQ(a.value.items[0].column, 10);
    EXPECT_EQ(a.value.items[1].column, 13);
    EXPECT_EQ(a.value.items[1].number, -25);
    EXPECT_EQ(a.value.items[2].column, 22);
    const JsonMember& umlaut = root->members[1];
    EXPECT_EQ(umlaut.line, 3);
    EXPECT_EQ(umlaut.column, 2);
    // Columns count code points: the key has three, quotes included.
    EXPECT_EQ(umlaut.value.column, 6);
    EXPECT_EQ(umlaut.value.members[0].column, 7);
    EXPECT_EQ(umlaut.value.members[0].value.column, 11);
    EXPECT_EQ(root->members[2].column, 17);
    EXPECT_EQ(root->members[2].value.column, 21);
}

/// The error at a place of f.json, with what is wrong there.
std::string not_json(std::string_view at, std::string_view why) {
    return fmt::format("f.json:{}: {}; {}", at, messages::kNotJson, why);
}

std::string other_expected(std::string_view found, std::string_view expected) {
    return fmt::format(messages::kOtherExpected, found, expected);
}

TEST(Json, RefusesWhatIsNotStrict) {
    EXPECT_EQ(error_of("{\"a\": 1,\n \"b\": 2,\n \"a\": 3}"),
              "f.json:3:2: " + fmt::format(messages::kDuplicateKey, "a") + "; " +
                  fmt::format(messages::kDuplicateKeyHelp, 1));
    EXPECT_EQ(error_of("{\"a\": 1} x"),
              not_json("1:10", other_expected("x", messages::kExpectedFileEnd)));
    EXPECT_EQ(error_of("[NaN]"), not_json("1:2", other_expected("NaN", messages::kExpectedValue)));
    EXPECT_EQ(error_of("[+1]"), not_json("1:2", other_expected("+1", messages::kExpectedValue)));
    EXPECT_EQ(error_of("[-01]"), not_json("1:2", messages::kLeadingZero));
    EXPECT_EQ(error_of("[1-2]"), not_json("1:2", fmt::format(messages::kNotANumber, "1-2")));
    EXPECT_EQ(error_of("[1.]"), not_json("1:2", fmt::format(messages::kNotANumber, "1.")));
    EXPECT_EQ(error_of("[-.5]"), not_json("1:2", fmt::format(messages::kNotANumber, "-.5")));
    EXPECT_EQ(error_of("[2e]"), not_json("1:2", fmt::format(messages::kNotANumber, "2e")));
    EXPECT_EQ(error_of("\"\xFF\""),
              not_json("1:2", fmt::format(messages::kInString, messages::kNotUtf8InString)));
    EXPECT_EQ(error_of("\"ab\tc\""),
              not_json("1:4", fmt::format(messages::kInString,
                                          fmt::format(messages::kControlInString, 9))));
    for (const char* escape :
         {"\\x41", "\\u12", "\\u12G4", "\\uD800", "\\uD800\\u0041", "\\uDC00"}) {
        EXPECT_EQ(error_of(fmt::format("[\"a{}\"]", escape)),
                  not_json("1:4", fmt::format(messages::kInString, messages::kEscapeInString)))
            << escape;
    }
    EXPECT_EQ(error_of("[1, \"ab"), not_json("1:5", messages::kNoClosingQuote));
    EXPECT_EQ(error_of(std::string_view("{\n\0}", 4)),
              fmt::format("f.json:2:1: {}; {}", messages::kZeroByte, messages::kZeroByteHelp));
    EXPECT_EQ(error_of(std::string_view("\xFF\xFE{\0}\0", 6)),
              "f.json:1:1: " + fmt::format(messages::kWideText, "UTF-16") + "; " +
                  messages::kWideTextHelp);
    EXPECT_EQ(error_of(""),
              not_json("1:1", fmt::format(messages::kFileEndsBefore, messages::kExpectedValue)));
}

TEST(Json, SaysWhatPeopleWriteThatItHasNot) {
    EXPECT_EQ(error_of("{\"a\": 1,\n}"), not_json("1:8", fmt::format(messages::kCommaAtEnd, '}')));
    EXPECT_EQ(error_of("{\"a\": [1, [2] ,] }"),
              not_json("1:15", fmt::format(messages::kCommaAtEnd, ']')));
    const std::string comment =
        fmt::format("{}; {}", messages::kNotJsonComments, messages::kNotJsonCommentsHelp);
    EXPECT_EQ(error_of("{\"a\": 1, // no\n}"), "f.json:1:10: " + comment);
    EXPECT_EQ(error_of("/* no */ {}"), "f.json:1:1: " + comment);
    EXPECT_EQ(error_of("{\"a\": 1 # no\n}"), "f.json:1:9: " + comment);
    EXPECT_EQ(error_of("{'a': 1}"), not_json("1:2", messages::kDoubleQuotes));
    EXPECT_EQ(error_of("{a: 1}"), not_json("1:2", other_expected("a", messages::kExpectedKey)));
    EXPECT_EQ(error_of("{\"a\": 1 \"b\": 2}"),
              not_json("1:9", other_expected("\"", messages::kExpectedMemberEnd)));
    EXPECT_EQ(error_of("{\"a\" 1}"), not_json("1:6", other_expected("1", "`:`")));
    EXPECT_EQ(error_of("[[1], [2] [3]]"),
              not_json("1:11", other_expected("[", messages::kExpectedItemEnd)));
}

TEST(Json, SaysWhatNumberIsTooLarge) {
    const auto too_large = [](const std::string& number, const char* cut) {
        return fmt::format(messages::kNumberTooLarge, number, cut) + "; " +
               messages::kLargestNumber;
    };
    EXPECT_EQ(error_of("[1, -1e999]"), "f.json:1:5: " + too_large("-1e999", ""));
    EXPECT_EQ(error_of("[1" + std::string(400, '0') + "]"),
              "f.json:1:2: " + too_large("1" + std::string(39, '0'), "…"));
}

uint64_t bits_of(double value) {
    return std::bit_cast<uint64_t>(value);
}

/// Literals of all shapes: many zeros, many digits, exponents, the smallest and the largest
/// doubles, and midpoints between two.
std::vector<std::string> literals() {
    std::mt19937_64 random(20);
    const auto below = [&](size_t n) { return static_cast<size_t>(random() % n); };
    const auto digits = [&](size_t n) {
        std::string out;
        for (size_t i = 0; i < n; ++i)
            out += static_cast<char>('0' + below(10));
        return out;
    };
    std::vector<std::string> all = {
        "0",      "-0",      "0.0",      "-0.0e5",   "0e999999999999",
        "1e-999", "-1e-400", "2.5e-324", "4.9e-324", "2.4703282292062327e-324"};
    while (all.size() < 40'000) {
        std::string text = below(4) == 0 ? "-" : "";
        switch (below(5)) {
            case 0:  // zeros, then random digits
                text += "0." + std::string(below(40) + 1, '0') + digits(below(4));
                break;
            case 1:
                text += fmt::format("{}.{}", 1 + below(9), digits(1 + below(800)));
                break;
            case 2:
                text += fmt::format("{}{}", 1 + below(9), digits(below(300)));
                break;
            case 3: {  // the midpoint of two doubles, all digits
                const double at = std::bit_cast<double>(random() % bits_of(1e300));
                const double next = std::nextafter(at, HUGE_VAL);
                std::array<char, 1200> buffer;
                const long double middle = (static_cast<long double>(at) + next) / 2;
                std::snprintf(buffer.data(), buffer.size(), "%.*Lf", below(2) == 0 ? 1100 : 30,
                              middle);
                text += buffer.data();
                break;
            }
            default:
                text += fmt::format("{:.17g}", std::bit_cast<double>(random() % bits_of(1e300)));
        }
        // The parser's own size limit is tested separately.
        if (text.find('e') == std::string::npos && below(2) == 0)
            text += fmt::format("e{}{}", below(2) == 0 ? "-" : "", below(340));
        if (std::isfinite(std::strtod(text.c_str(), nullptr))) all.push_back(std::move(text));
    }
    return all;
}

TEST(Json, ReadsNumbersToTheBit) {
    const std::vector<std::string> texts = literals();
    std::string list;
    for (const std::string& text : texts)
        list += (list.empty() ? "[" : ",") + text;
    const Result<JsonValue> root = parse_json(list + "]", "f");
    ASSERT_TRUE(root) << root.error().text();
    ASSERT_EQ(root->items.size(), texts.size());
    for (size_t i = 0; i < texts.size(); ++i) {
        const double wanted = std::strtod(texts[i].c_str(), nullptr);
        ASSERT_EQ(bits_of(root->items[i].number), bits_of(wanted)) << texts[i];
    }
}

// Digit by digit of a number so far they would take an hour.
TEST(Json, ReadsLongNumbersAtOnce) {
    for (const std::string& text :
         {"0." + std::string(1'000'000, '0') + "1e1000000",
          "1" + std::string(1'000'000, '0') + "e-1000000", "0." + std::string(1'000'000, '3'),
          std::string(1'000'000, '7') + "e-999999"}) {
        const Result<JsonValue> root = parse_json(text, "f");
        ASSERT_TRUE(root) << root.error().text();
        EXPECT_EQ(bits_of(root->number), bits_of(std::strtod(text.c_str(), nullptr)));
    }
}

TEST(Json, FindsTwoEqualKeysAmongMany) {
    std::string text = "{\"k\": 0";
    for (int i = 0; i < 200'000; ++i)
        text += fmt::format(",\n\"k{}\": 0", i);
    EXPECT_EQ(error_of(text + "}"), "no error");  // pairwise comparison would take a minute
    EXPECT_EQ(error_of(text + ",\"k77\":1}"),
              "f.json:200001:14: " + fmt::format(messages::kDuplicateKey, "k77") + "; " +
                  fmt::format(messages::kDuplicateKeyHelp, 79));
}

TEST(Json, KeepsToItsMemory) {
    std::string text = "[0";
    for (int i = 0; i < 100'000; ++i)
        text += ",0";
    text += "]";
    EXPECT_TRUE(parse_json(text, "f", 100'000'000));
    const Result<JsonValue> refused = parse_json(text, "f", 10'000'000);
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().text(), testing::Says(messages::kValuesTakeTooMuch));
}

TEST(Json, LimitsDepth) {
    EXPECT_EQ(error_of(std::string(32, '[') + std::string(32, ']')), "no error");
    EXPECT_EQ(error_of(std::string(33, '[') + std::string(33, ']')),
              "f.json:1:33: " + fmt::format(messages::kNestedTooDeep, 32));
    EXPECT_EQ(error_of(std::string(10'000'000, '[')),
              "f.json:1:33: " + fmt::format(messages::kNestedTooDeep, 32));
}

TEST(Json, SurvivesEveryTruncation) {
    const std::string text =
        R"({"a": [1, 2.5, "x\u00e4y", {"b": [true, null]}], "c": {"d": -1e-3}})";
    ASSERT_EQ(error_of(text), "no error");
    for (size_t n = 0; n < text.size(); ++n) {
        EXPECT_TRUE(error_of(text.substr(0, n)).starts_with("f.json:1:")) << n;
        std::string damaged = text;
        for (char c : {'\x01', '{', ']', '"', '\xC3'}) {
            damaged[n] = c;
            (void)error_of(damaged);  // any result but a crash
        }
    }
}

TEST(Caret, PointsAtTheToken) {
    const testing::TempFolder folder;
    const std::string file = folder.write("w.json", "{\n\t\"\xC3\xA4\": \"b c\"\n}\n").string();
    EXPECT_EQ(render_error(error_at({file, 2, 7}, "what is wrong", "do this; and that")),
              file +
                  ":2:7: error: what is wrong\n 2 |  \"\xC3\xA4\": \"b c\"\n   |       "
                  "^~~~~\nhelp: do this; and that\n");
    EXPECT_EQ(render_error(user_error("no place: 3:4: here; or there")),
              "error: no place: 3:4: here; or there\n");
    EXPECT_EQ(render_error(error_at({"/nowhere/x", 1, 2}, "oh")), "/nowhere/x:1:2: error: oh\n");
}

}  // namespace
}  // namespace openfab::testing

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/json.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>

#include "base/caret.h"
#include "tests/support/meshes/temp_folder.h"

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

TEST(Json, RefusesWhatIsNotStrict) {
    EXPECT_EQ(error_of("{\"a\": 1,\n \"b\": 2,\n \"a\": 3}"),
              "f.json:3:2: duplicate key `a`; it is first given at line 1");
    EXPECT_EQ(error_of("{\"a\": 1} x"),
              "f.json:1:10: not valid JSON; `x` where the end of the file should be");
    EXPECT_EQ(error_of("[NaN]"), "f.json:1:2: not valid JSON; `NaN` where a value should be");
    EXPECT_EQ(error_of("[+1]"), "f.json:1:2: not valid JSON; `+1` where a value should be");
    EXPECT_EQ(error_of("[-01]"), "f.json:1:2: not valid JSON; a number with a leading zero");
    EXPECT_EQ(error_of("[1-2]"), "f.json:1:2: not valid JSON; `1-2` is not a number");
    EXPECT_EQ(error_of("[1.]"), "f.json:1:2: not valid JSON; `1.` where a value should be");
    EXPECT_EQ(error_of("\"\xFF\""),
              "f.json:1:2: not valid JSON; in a string: ill-formed UTF-8 byte");
    EXPECT_EQ(error_of("[1, \"ab"), "f.json:1:5: not valid JSON; the string has no closing quote");
    EXPECT_EQ(error_of(std::string_view("{\n\0}", 4)),
              "f.json:2:1: a zero byte; the file is not text");
    EXPECT_EQ(error_of(std::string_view("\xFF\xFE{\0}\0", 6)),
              "f.json:1:1: the file is text in UTF-16; save it as UTF-8");
    EXPECT_EQ(error_of(""), "f.json:1:1: not valid JSON; the file ends where a value should be");
}

TEST(Json, SaysWhatPeopleWriteThatItHasNot) {
    const std::string comma = "which must not follow the last element; delete it";
    EXPECT_EQ(error_of("{\"a\": 1,\n}"),
              "f.json:1:8: not valid JSON; a comma before `}`, " + comma);
    EXPECT_EQ(error_of("{\"a\": [1, [2] ,] }"),
              "f.json:1:15: not valid JSON; a comma before `]`, " + comma);
    const std::string comment = "not valid JSON, which has no comments; delete this one";
    EXPECT_EQ(error_of("{\"a\": 1, // no\n}"), "f.json:1:10: " + comment);
    EXPECT_EQ(error_of("/* no */ {}"), "f.json:1:1: " + comment);
    EXPECT_EQ(error_of("{\"a\": 1 # no\n}"), "f.json:1:9: " + comment);
    EXPECT_EQ(error_of("{'a': 1}"),
              "f.json:1:2: not valid JSON; strings are written in double quotes");
    EXPECT_EQ(error_of("{a: 1}"),
              "f.json:1:2: not valid JSON; `a` where a key in double quotes should be");
    EXPECT_EQ(error_of("{\"a\": 1 \"b\": 2}"),
              "f.json:1:9: not valid JSON; `\"` where `,` or `}` should be");
    EXPECT_EQ(error_of("{\"a\" 1}"), "f.json:1:6: not valid JSON; `1` where `:` should be");
    EXPECT_EQ(error_of("[[1], [2] [3]]"),
              "f.json:1:11: not valid JSON; `[` where `,` or `]` should be");
}

TEST(Json, SaysWhatNumberIsTooLarge) {
    const std::string most = " is too large; at most 1.8e308 is possible";
    EXPECT_EQ(error_of("[1, -1e999]"), "f.json:1:5: the number `-1e999`" + most);
    EXPECT_EQ(error_of("[1" + std::string(400, '0') + "]"),
              "f.json:1:2: the number `1" + std::string(39, '0') + "…`" + most);
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
              "f.json:200001:14: duplicate key `k77`; it is first given at line 79");
}

TEST(Json, KeepsToItsMemory) {
    std::string text = "[0";
    for (int i = 0; i < 100'000; ++i)
        text += ",0";
    text += "]";
    EXPECT_TRUE(parse_json(text, "f", 100'000'000));
    const Result<JsonValue> refused = parse_json(text, "f", 10'000'000);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().text().find("values, which take more memory than is allowed"),
              std::string::npos);
}

TEST(Json, LimitsDepth) {
    EXPECT_EQ(error_of(std::string(32, '[') + std::string(32, ']')), "no error");
    EXPECT_EQ(error_of(std::string(33, '[') + std::string(33, ']')),
              "f.json:1:33: nested more than 32 levels deep");
    EXPECT_EQ(error_of(std::string(10'000'000, '[')),
              "f.json:1:33: nested more than 32 levels deep");
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

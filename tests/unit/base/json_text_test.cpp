// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/json_text.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidjson/prettywriter.h>
#include <rapidjson/stringbuffer.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <random>

namespace openfab {
namespace {

using Layout = JsonText::Layout;

/// Writes the same with either writer.
template <typename Writer>
void write_rapidjson(Writer& w) {
    w.StartObject();
    w.Key("text");
    w.String("a \"b\" \\ / \n\t\r\b\f \x01\x1f \x7f ä");
    w.Key("empty");
    w.StartObject();
    w.EndObject();
    w.Key("none");
    w.StartArray();
    w.EndArray();
    w.Key("list");
    w.StartArray();
    w.Int64(-3);
    w.StartObject();
    w.Key("deep");
    w.Null();
    w.Key("true");
    w.Bool(true);
    w.EndObject();
    w.StartArray();
    w.Bool(false);
    w.EndArray();
    w.EndArray();
    w.EndObject();
}

std::string ours(Layout layout) {
    JsonText w(layout);
    w.begin_object().member("text", "a \"b\" \\ / \n\t\r\b\f \x01\x1f \x7f ä");
    w.key("empty").begin_object().end_object().key("none").begin_array().end_array();
    w.key("list").begin_array().value(-3);
    w.begin_object().key("deep").null().member("true", true).end_object();
    w.begin_array().value(false).end_array().end_array().end_object();
    return w.take();
}

TEST(JsonText, LooksAsAnotherWriterHasIt) {
    rapidjson::StringBuffer compact, indented, lists;
    rapidjson::Writer<rapidjson::StringBuffer> w(compact);
    write_rapidjson(w);
    EXPECT_EQ(ours(Layout::kCompact), compact.GetString());
    rapidjson::PrettyWriter<rapidjson::StringBuffer> pretty(indented);
    pretty.SetIndent(' ', 2);
    write_rapidjson(pretty);
    EXPECT_EQ(ours(Layout::kIndented), indented.GetString());
    rapidjson::PrettyWriter<rapidjson::StringBuffer> one_line(lists);
    one_line.SetIndent(' ', 2);
    one_line.SetFormatOptions(rapidjson::kFormatSingleLineArray);
    write_rapidjson(one_line);
    EXPECT_EQ(ours(Layout::kIndentedLists), lists.GetString());
}

TEST(JsonText, AListIsOnOneLineOfAnIndentedText) {
    JsonText w(Layout::kIndented);
    w.begin_object().key("a").begin_list().value(1).fraction(2).end_array();
    w.key("b").begin_array().value(1).end_array().end_object();
    EXPECT_EQ(w.text(), "{\n  \"a\": [1, 2.0],\n  \"b\": [\n    1\n  ]\n}");
}

std::string fraction(double number, int decimals) {
    return JsonText().fraction(number, decimals).take();
}

TEST(JsonText, FractionsAreDecimalWhereThatIsShort) {
    constexpr int kAll = 400;
    const std::pair<double, const char*> cases[] = {{0, "0.0"},
                                                    {-0.0, "-0.0"},
                                                    {3, "3.0"},
                                                    {-1234567.5, "-1234567.5"},
                                                    {1e20, "100000000000000000000.0"},
                                                    {1e21, "1e21"},
                                                    {-2.5e300, "-2.5e300"},
                                                    {0.1, "0.1"},
                                                    {0.001234, "0.001234"},
                                                    {1e-6, "0.000001"},
                                                    {1.5e-7, "1.5e-7"},
                                                    {5e-324, "5e-324"}};
    for (const auto& [number, text] : cases)
        EXPECT_EQ(fraction(number, kAll), text);
    // Cut, not rounded, with a digit left.
    EXPECT_EQ(fraction(1.9999999, 6), "1.999999");
    EXPECT_EQ(fraction(1.0000009, 6), "1.0");
    EXPECT_EQ(fraction(0.0120009, 6), "0.012");
    EXPECT_EQ(fraction(-1e-9, 6), "-0.0");
    EXPECT_EQ(JsonText().fraction(std::nan("")).take(), "null");
    EXPECT_EQ(JsonText().value(3.0).take(), "3");
    EXPECT_EQ(JsonText().value(2.5).take(), "2.5");
}

/// A number's text reads back alike, and none with a digit less does.
TEST(JsonText, FractionsHaveTheFewestDigitsThatReadBackAlike) {
    std::mt19937_64 random(17);
    for (int i = 0; i < 20'000; ++i) {
        const uint64_t bits = random();
        double number = 0;
        std::memcpy(&number, &bits, sizeof number);
        if (!std::isfinite(number) || number == 0) continue;
        const std::string text = JsonText().fraction(number).take();
        EXPECT_EQ(std::strtod(text.c_str(), nullptr), number) << text;
        const auto digits = std::count_if(
            text.begin(),
            text.begin() + static_cast<ptrdiff_t>(std::min(text.find('e'), text.size())),
            [](char c) { return c >= '0' && c <= '9'; });
        if (digits < 3 || text.find('e') == std::string::npos) continue;
        const std::string shorter = fmt::format("{:.{}e}", number, digits - 2);
        EXPECT_NE(std::strtod(shorter.c_str(), nullptr), number) << text;
    }
}

TEST(JsonText, WhatWasReadIsWrittenAlike) {
    const std::string text =
        R"({"a":[1,2.0,-7,0.25,1e-9,100000000000000000000.0],"b":{"c":null,"d":"ä\n"},"e":true})";
    const Result<JsonValue> read = parse_json(text, "t");
    ASSERT_TRUE(read);
    EXPECT_EQ(JsonText().value(*read).take(), text);
    EXPECT_EQ(read->find("a")->value.items[0].whole(), 1);
    EXPECT_FALSE(read->find("a")->value.items[1].whole());
    EXPECT_FALSE(read->find("e")->value.whole());
}

}  // namespace
}  // namespace openfab

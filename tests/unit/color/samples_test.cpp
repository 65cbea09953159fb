// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Tables of patches: CGATS, CSV, and what is wrong with them.

#include "tools/color/samples.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/messages.h"
#include "tests/support/says/says.h"
#include "tools/color/chart.h"
#include "tools/color/messages.h"

namespace openfab::color {
namespace {

TEST(Samples, ReadsCgatsAsInstrumentsWriteIt) {
    const Result<SampleTable> table = parse_samples(
        "CTI3\r\n\r\nDESCRIPTOR \"a chart\"\r\nCOLOR_REP \"CMYK_XYZ\"\r\n\r\n"
        "NUMBER_OF_FIELDS 8\r\nBEGIN_DATA_FORMAT\r\nSAMPLE_ID CMYK_C CMYK_M CMYK_Y CMYK_K XYZ_X "
        "XYZ_Y XYZ_Z\r\nEND_DATA_FORMAT\r\n\r\nNUMBER_OF_SETS 2\r\nBEGIN_DATA\r\n"
        "1 0 0 0 0 96.42 100 82.49\r\n\"A 2\" 50 0.5 0 10 20 18.418651851 15\r\nEND_DATA\r\n"
        "CAL\r\nBEGIN_DATA\r\n1 2 3\r\nEND_DATA\r\n");
    ASSERT_TRUE(table) << table.error().text();
    EXPECT_TRUE(table->has_inks);
    EXPECT_TRUE(table->has_lab);
    ASSERT_EQ(table->samples.size(), 2);
    EXPECT_NEAR(table->samples[0].lab.l, 100, 1e-9);
    EXPECT_NEAR(table->samples[0].lab.b, 0, 1e-9);
    EXPECT_EQ(table->samples[1].id, "A 2");
    EXPECT_EQ(table->samples[1].inks, (Inks{0.5, 0.005, 0, 0.1}));
    EXPECT_NEAR(table->samples[1].lab.l, 50, 1e-6);  // 18.4187 is the Y of L* 50
}

TEST(Samples, ReadsTextOfAnyProgram) {
    const std::string table =
        "CMYK_C,CMYK_M,CMYK_Y,CMYK_K,RGB_R,RGB_G,RGB_B\r0,0,0,0,255,255,255\r";
    const Result<SampleTable> marked = parse_samples("\xEF\xBB\xBF" + table);
    ASSERT_TRUE(marked) << marked.error().text();
    EXPECT_EQ(marked->samples.size(), 1);
    EXPECT_EQ(parse_samples(std::string_view("\xFF\xFE"
                                             "C\0,\0",
                                             6))
                  .error()
                  .text(),
              fmt::format(openfab::messages::kWideText, "UTF-16") + "; " +
                  openfab::messages::kWideTextHelp);
}

TEST(Samples, ReadsCsvAndCameras) {
    const Result<SampleTable> table = parse_samples(
        "# by eye\nCMYK_C,CMYK_M,CMYK_Y,CMYK_K,RGB_R,RGB_G,RGB_B\n0,0,0,0,255,255,255\n"
        "100, 0, 0, 0, 0, 128, 255\n");
    ASSERT_TRUE(table) << table.error().text();
    EXPECT_TRUE(table->has_lab);
    EXPECT_NEAR(table->samples[0].lab.l, 100, 0.01);
    EXPECT_EQ(table->samples[1].id, "2");
    EXPECT_LT(table->samples[1].lab.b, -40);
}

TEST(Samples, CgatsIsKnownByItsKeywordWhateverItsHeadSays) {
    const std::string data =
        "BEGIN_DATA_FORMAT \r\nSAMPLE_ID CMYK_C CMYK_M CMYK_Y CMYK_K LAB_L LAB_A LAB_B\n"
        "END_DATA_FORMAT\nNUMBER_OF_SETS 1\nBEGIN_DATA\n1 0 0 0 100 20 0 -1\nEND_DATA\n";
    for (const char* head :
         {"CTI3\n\nORIGINATOR \"A, B\"\nINSTRUMENTATION \"D50, 2 degree; 45/0\"\n",
          "IT8.7/3\nORIGINATOR\t\"A;B\"\nKEYWORD \"BEGIN_DATA_FORMAT, in words\"\n", "a, b, c\n",
          "# made by, hand\nCGATS.17, 1\n"}) {
        const Result<SampleTable> table = parse_samples(head + data);
        ASSERT_TRUE(table) << head << table.error().text();
        ASSERT_EQ(table->samples.size(), 1U) << head;
        EXPECT_EQ(table->samples[0].inks, (Inks{0, 0, 0, 1}));
        EXPECT_EQ(table->samples[0].lab.b, -1);
    }
    // What only speaks of the keyword is none; other separators are those of spreadsheets.
    for (const char* csv : {"CMYK_C,CMYK_M,CMYK_Y,CMYK_K,LAB_L,LAB_A,LAB_B,NO_BEGIN_DATA_FORMAT\n"
                            "0,0,0,100,20,0,-1,BEGIN_DATA_FORMAT\n",
                            "CMYK_C;CMYK_M;CMYK_Y;CMYK_K;LAB_L;LAB_A;LAB_B\n0;0;0;100;20;0;-1\n",
                            "CMYK_C\tCMYK_M\tCMYK_Y\tCMYK_K\tLAB_L\tLAB_A\tLAB_B\n"
                            "0\t0\t0\t100\t20\t0\t-1\n"}) {
        const Result<SampleTable> table = parse_samples(csv);
        ASSERT_TRUE(table) << csv << table.error().text();
        EXPECT_EQ(table->samples[0].inks[3], 1) << csv;
    }
}

const std::string kHead =
    "BEGIN_DATA_FORMAT\nSAMPLE_ID CMYK_C CMYK_M CMYK_Y CMYK_K XYZ_X XYZ_Y XYZ_Z\nEND_DATA_FORMAT\n";

std::string refusal(const std::string& text) {
    const Result<SampleTable> table = parse_samples(text);
    return table ? "" : table.error().text();
}

TEST(Samples, ReadsValuesWhereverCgatsHasThem) {
    const std::string plain =
        kHead + "BEGIN_DATA\n\"\" 0 0 0 0 96.42 100 82.49\nb 0 0 100 0 60 70 8\nEND_DATA\n";
    const std::string others[] = {
        // Over two lines, with comments, more blanks, and a sum of 8 bits.
        kHead +
            "NUMBER_OF_SETS 2\nBEGIN_DATA\n\"\" 0 0 0 0\n 96.42 100 82.49 # white\n# all\n"
            "b 0\n0 100 0 60 70\n8\nEND_DATA\n",
        kHead +
            "BEGIN_DATA\n\"#1\" 0 0 0 0 96.42 100 82.49#bare\n\"\"\t0 0 100 0 60 70 8\nEND_DATA\n"};
    const Result<SampleTable> right = parse_samples(plain);
    ASSERT_TRUE(right) << right.error().text();
    ASSERT_EQ(right->samples.size(), 2u);
    EXPECT_NEAR(right->samples[0].lab.l, 100, 1e-9);
    for (const std::string& text : others) {
        const Result<SampleTable> table = parse_samples(text);
        ASSERT_TRUE(table) << text << table.error().text();
        ASSERT_EQ(table->samples.size(), 2u) << text;
        for (size_t i = 0; i < 2; ++i) {
            EXPECT_EQ(table->samples[i].inks, right->samples[i].inks) << text;
            EXPECT_EQ(table->samples[i].lab.l, right->samples[i].lab.l) << text;
        }
    }
}

/// Twenty patches as CGATS text whose values end lines after so many of them; 0: never.
std::string folded(size_t after, bool with_count) {
    std::string text = kHead + (with_count ? "NUMBER_OF_SETS 20\n" : "") + "BEGIN_DATA\n";
    size_t count = 0;
    for (int k = 0; k < 20; ++k) {
        for (const int value : {k + 1, k, 2 * k, 5, 0, 20 + k, 21 + k, 8 + k}) {
            text += std::to_string(value);
            text += after > 0 && ++count % after == 0 ? '\n' : ' ';
        }
    }
    return text + "END_DATA\n";
}

TEST(Samples, SetsAreCountedWhereverLinesEnd) {
    const Result<SampleTable> right = parse_samples(folded(8, true));
    ASSERT_TRUE(right) << right.error().text();
    for (const size_t after : {0, 1, 3, 5, 7, 10, 13, 16, 24}) {
        const Result<SampleTable> table = parse_samples(folded(after, true));
        ASSERT_TRUE(table) << after << table.error().text();
        ASSERT_EQ(table->samples.size(), 20u) << after;
        for (size_t k = 0; k < 20; ++k) {
            EXPECT_EQ(table->samples[k].id, std::to_string(k + 1));
            EXPECT_EQ(table->samples[k].inks, right->samples[k].inks) << after;
            EXPECT_EQ(table->samples[k].lab.b, right->samples[k].lab.b) << after;
        }
    }
    // A line that has a value too few or too many is the fault, wherever it shows.
    for (const char* wrong : {"7 6 12 5 0 26 27", "7 6 12 5 0 26 27 14 1"}) {
        std::string text = folded(8, true);
        const std::string row = "7 6 12 5 0 26 27 14\n";
        text.replace(text.find(row), row.size(), std::string(wrong) + "\n");
        EXPECT_THAT(refusal(text), testing::Says(messages::kLineOf, "12", "*"));
        EXPECT_THAT(refusal(text), testing::Says(messages::kValuesForColumns, "*", "8"));
    }
    // Without a count of sets, each begins a line.
    EXPECT_NE(refusal(folded(5, false)), "");
    EXPECT_EQ(refusal(folded(4, false)), "");
    // Keywords share lines with names and values.
    std::string one = folded(8, true);
    std::replace(one.begin(), one.end(), '\n', ' ');
    one.replace(one.find(" NUMBER_OF_SETS"), 1, "\n");
    one.replace(one.find(" BEGIN_DATA "), 1, "\n");
    const Result<SampleTable> table = parse_samples(one);
    ASSERT_TRUE(table) << table.error().text();
    EXPECT_EQ(table->samples.size(), 20u);
}

TEST(Samples, NumbersAndNamesAreThoseOfAllCountries) {
    const std::string names[] = {"SAMPLE_ID", "cmyk_c", "Cmyk_M", "CMYK_Y",
                                 "CMYK_K",    "LAB_L",  "LAB_A",  "lab_b"};
    const std::string values[] = {"7", "12.5", "0", "0.25", "0", "60.5", "-1.25", "2"};
    const auto row = [](const std::string(&cells)[8], const std::string& between, bool comma) {
        std::string out;
        for (std::string cell : cells) {
            if (comma) std::replace(cell.begin(), cell.end(), '.', ',');
            out += (out.empty() ? "" : between) + cell;
        }
        return out + "\n";
    };
    const std::string texts[] = {
        row(names, ",", false) + row(values, ",", false),
        row(names, ";", false) + row(values, ";", true),
        row(names, "\t", false) + row(values, "\t", true),
        "sep=;\n" + row(names, ";", false) + row(values, ";", true),
        "My chart, of Monday\n\n" + row(names, ",", false) + row(values, ",", false),
        "BEGIN_DATA_FORMAT\n" + row(names, " ", false) + "END_DATA_FORMAT\nBEGIN_DATA\n" +
            row(values, " ", true) + "END_DATA\n",
    };
    for (const std::string& text : texts) {
        const Result<SampleTable> table = parse_samples(text);
        ASSERT_TRUE(table) << text << table.error().text();
        ASSERT_EQ(table->samples.size(), 1u) << text;
        const Sample& sample = table->samples[0];
        EXPECT_EQ(sample.id, "7");
        EXPECT_EQ(sample.inks, (Inks{0.125, 0, 0.0025, 0})) << text;
        EXPECT_EQ(sample.lab.l, 60.5);
        EXPECT_EQ(sample.lab.a, -1.25);
        EXPECT_EQ(sample.lab.b, 2);
    }
    EXPECT_THAT(refusal("CMYK_C,CMYK_M,CMYK_Y,CMYK_K,LAB_L,LAB_A,LAB_B,LAB_L\n50,0,0,0,9,8,7,6\n"),
                testing::Says(messages::kColumnTwice, "LAB_L"));
    EXPECT_THAT(refusal("CMYK_C,CMYK_M,CMYK_Y,CMYK_K,LAB_L,LAB_A,LAB_B\n1,0,0,0,9,8,7\n"),
                testing::Says(messages::kInksBelowOnePercent, "1"));
    EXPECT_THAT(refusal("CMYK_C,CMYK_M,CMYK_Y,CMYK_K,LAB_L,LAB_A,LAB_B\n99,0,0,0,-1,-1,-1\n"),
                testing::Says(messages::kValueOutside, "-1", "LAB_L", "*", "*"));
    const Result<SampleTable> rounded = parse_samples(
        "CMYK_C,CMYK_M,CMYK_Y,CMYK_K,LAB_L,LAB_A,LAB_B\n100.004,-0.003,0,0,-0.02,8,7\n");
    ASSERT_TRUE(rounded) << rounded.error().text();
    EXPECT_EQ(rounded->samples[0].inks, (Inks{1, 0, 0, 0}));
    EXPECT_EQ(rounded->samples[0].lab.l, 0);
}

TEST(Samples, CellsInQuotesHoldSeparatorsQuotesAndLines) {
    const Result<SampleTable> table = parse_samples(
        "Note,SAMPLE_ID,CMYK_C,CMYK_M,CMYK_Y,CMYK_K,LAB_L,LAB_A,LAB_B\n"
        "\"say \"\"hi\"\", he\nsaid\",a,50,0,0,0,9,8,7\n5\" wide,b,\"0,5\",0,0,0,9,8,7\n");
    ASSERT_TRUE(table) << table.error().text();
    ASSERT_EQ(table->samples.size(), 2u);
    EXPECT_EQ(table->samples[0].id, "a");
    EXPECT_EQ(table->samples[1].inks[0], 0.005);
    EXPECT_THAT(refusal("Note,CMYK_C,CMYK_M,CMYK_Y,CMYK_K,LAB_L,LAB_A,LAB_B\n\"a\nb\",50,0,0,0,9,8,"
                        "7\nc,x,0,0,0,9,8,7\n"),
                testing::Says(messages::kLineOf, "4", "*"));
}

TEST(Samples, AmountsOfEightBitsAndNumbersBelowZeroAreRead) {
    const Result<SampleTable> table =
        parse_samples(kHead +
                      "BEGIN_DATA\n1 33.3333 33.3333 33.7255 0 20 21 -0.0018\n2 25.098 25.098 "
                      "25.098 25.098 3 4 0\nEND_DATA\n");
    ASSERT_TRUE(table) << table.error().text();
    for (const Sample& s : table->samples)
        EXPECT_NEAR(s.inks[0] + s.inks[1] + s.inks[2] + s.inks[3], 1, 1e-12);
    EXPECT_EQ(table->samples[0].lab.b,
              parse_samples(kHead + "BEGIN_DATA\n1 0 0 0 0 20 21 0\nEND_DATA\n")->samples[0].lab.b);
    EXPECT_THAT(refusal(kHead + "BEGIN_DATA\n1 34 34 34 0 20 21 0\nEND_DATA\n"),
                testing::Says(messages::kInksAddUp));
    EXPECT_THAT(refusal(kHead + "BEGIN_DATA\n1 0 0 0 0 20 21 -3\nEND_DATA\n"),
                testing::Says(messages::kValueOutside));
}

TEST(Samples, TablesAreWholeOrRefused) {
    const std::string row = "1 0 0 0 0 96.42 100 82.49\n";
    EXPECT_THAT(refusal(kHead + "NUMBER_OF_SETS 3\nBEGIN_DATA\n" + row + row),
                testing::Says(messages::kRowsMissing, "3", "2"));
    EXPECT_THAT(refusal(kHead + "NUMBER_OF_SETS 1\nBEGIN_DATA\n" + row + row + "END_DATA\n"),
                testing::Says(messages::kRowsMissing, "1", "2"));
    EXPECT_THAT(refusal(kHead + "BEGIN_DATA\n" + row), testing::Says(messages::kNoEndOfData));
    // All rows are there, and the last may have lost digits.
    EXPECT_THAT(refusal(kHead + "NUMBER_OF_SETS 1\nBEGIN_DATA\n" + row),
                testing::Says(messages::kNoEndOfData));
    EXPECT_THAT(refusal(kHead + "BEGIN_DATA\n" + row + "1 0 0 0\nEND_DATA\n"),
                testing::Says(messages::kValuesForColumns, "4", "8"));
    EXPECT_THAT(refusal(kHead + "BEGIN_DATA\n1 0 0 0\n" + row + "END_DATA\n"),
                testing::Says(messages::kValuesForColumns, "4", "8"));
}

TEST(Samples, AnotherLightIsRefused) {
    const std::string rows = kHead + "BEGIN_DATA\n1 0 0 0 0 96.42 100 82.49\nEND_DATA\n";
    for (const char* head :
         {"ILLUMINATION_NAME \"D65\"\n", "WEIGHTING_FUNCTION \"ILLUMINANT, D65\"\n",
          "WEIGHTING_FUNCTION \"OBSERVER, 10 degree\"\n", "OBSERVER \"10\"\n",
          "MEASUREMENT_SOURCE \"Illumination=D65\tObserverAngle=2\"\n",
          "MEASUREMENT_SOURCE \"Illumination=D50 ObserverAngle=10 Filter=U\"\n",
          "MEASUREMENT_SOURCE \"illumination = D65, observer = 2\"\n", "illumination_name d65\n",
          "WEIGHTING_FUNCTION \"Illuminant, D65\"\n", "ILLUMINATION_NAME \"D50/10\"\n",
          "OBSERVER_ANGLE \"10\"\n", "ILLUMINATION_NAME \"F11\"\n", "ILLUMINATION_NAME 6500 K\n",
          "ILLUMINANT_WHITE_POINT_XYZ \"95.1 100 108.8\"\n", "OBSERVER \"CIE 1964\"\n"})
        EXPECT_THAT(refusal(head + rows), testing::Says(messages::kOtherLight)) << head;
    for (const char* head :
         {"ILLUMINATION_NAME \"D50\"\n", "WEIGHTING_FUNCTION \"ILLUMINANT, D50\"\n",
          "WEIGHTING_FUNCTION \"OBSERVER, 2 degree\"\n", "INSTRUMENTATION \"D65, 10\"\n",
          "MEASUREMENT_SOURCE \"Illumination=D50\tObserverAngle=2\tWhiteBase=Absolute\"\n",
          "WEIGHTING_FUNCTION \"OBSERVER, CIE 1931, 2 degree, 10 nm\"\n",
          "ILLUMINANT_WHITE_POINT_XYZ \"96.42 100 82.49\"\n", "ILLUMINATION_NAME \"D50/2\"\n"})
        EXPECT_EQ(refusal(head + rows), "") << head;
}

TEST(Samples, AChartIsNotMeasured) {
    const Result<SampleTable> chart =
        parse_samples("CTI1\n" + kHead + "BEGIN_DATA\n1 0 0 0 0 96.42 100 82.49\nEND_DATA\n");
    ASSERT_TRUE(chart);
    EXPECT_TRUE(chart->is_chart);
}

TEST(Samples, CellsOfACsvMayBeEmpty) {
    const std::string head = "Note,CMYK_C,CMYK_M,CMYK_Y,CMYK_K,LAB_L,LAB_A,LAB_B\n";
    const Result<SampleTable> table = parse_samples(
        head + ",0,0,0,0,90,0,0\n\"a, b\",0,0,0,100,20,0,-1,,\n,,,,,,,\n#3,0,0,100,0,80,0,90\n");
    ASSERT_TRUE(table) << table.error().text();
    ASSERT_EQ(table->samples.size(), 3u);
    EXPECT_EQ(table->samples[0].lab.l, 90);
    EXPECT_EQ(table->samples[1].lab.b, -1);
    EXPECT_EQ(table->samples[2].inks[2], 1);
    EXPECT_THAT(refusal(head + "a,0,0,0,,90,0,0\n"), testing::Says(messages::kValueNotANumber));
}

TEST(Samples, WhatIsMeasuredIsATableOfArgyll) {
    SampleTable table = ink_chart();
    EXPECT_TRUE(format_samples(table, "a").starts_with("CGATS.17\n"));
    table.has_lab = true;
    const std::string text = format_samples(table, "a");
    EXPECT_TRUE(text.starts_with("CTI3\n"));
    EXPECT_NE(text.find("\nDEVICE_CLASS \"OUTPUT\"\nCOLOR_REP \"CMYK_LAB\"\n"), std::string::npos);
}

TEST(Samples, FormattedTablesAreReadBack) {
    SampleTable chart = ink_chart();
    chart.has_lab = true;
    chart.samples[7].lab = {12.345, -6.789, 0.001};
    chart.samples[8].id = "patch 9, #2";
    chart.samples[9].id = "";
    const Result<SampleTable> back = parse_samples(format_samples(chart, "round"));
    ASSERT_TRUE(back) << back.error().text();
    EXPECT_EQ(back->columns, chart.columns);
    ASSERT_EQ(back->samples.size(), chart.samples.size());
    for (size_t k = 0; k < chart.samples.size(); ++k) {
        for (size_t i = 0; i < 4; ++i)
            EXPECT_NEAR(back->samples[k].inks[i], chart.samples[k].inks[i], 1e-12) << k;
    }
    EXPECT_EQ(back->samples[7].lab.a, -6.789);
    EXPECT_EQ(back->samples[8].id, "patch 9, #2");
    EXPECT_EQ(back->samples[9].id, "");
    // Names of files and of patches may hold anything.
    chart.samples[9].id = "5\" x\n2";
    const Result<SampleTable> odd =
        parse_samples(format_samples(chart, "simulated from a \"b\"\nNUMBER_OF_SETS 7"));
    ASSERT_TRUE(odd) << odd.error().text();
    EXPECT_EQ(odd->samples[9].id, "5' x 2");
    const Result<SampleTable> colours = parse_samples(format_samples(color_chart(), "colours"));
    ASSERT_TRUE(colours);
    EXPECT_FALSE(colours->has_lab);
    EXPECT_NEAR(colours->samples[1].rgb[2], 0.2, 1e-4);
}

struct Wrong {
    const char* text;
    std::string message;
};

TEST(Samples, SaysWhatIsWrongAndWhere) {
    const std::string head = "CMYK_C,CMYK_M,CMYK_Y,CMYK_K,LAB_L,LAB_A,LAB_B\n";
    const Wrong kWrong[] = {
        {"", messages::kNotATable},
        {"hello\nworld\n", messages::kNotATable},
        {"CMYK_C,CMYK_M,CMYK_Y,CMYK_K,LAB_L,LAB_A,LAB_B\n", messages::kNoPatches},
        {"CMYK_C,CMYK_M,CMYK_Y\n1,2,3\n",
         fmt::format(messages::kLineOf, 1, fmt::format(messages::kColumnMissing, "CMYK_K"))},
        {"LAB_L,LAB_A,LAB_B\n1,2,3\n",
         fmt::format(messages::kLineOf, 1, messages::kNeitherInksNorColours)},
    };
    for (const Wrong& wrong : kWrong) {
        const Result<SampleTable> table = parse_samples(wrong.text);
        ASSERT_FALSE(table) << wrong.text;
        EXPECT_THAT(table.error().text(), testing::Says(wrong.message));
    }
    const Wrong kRows[] = {
        {"1,2,3,4,5,6\n",
         fmt::format(messages::kLineOf, 2, fmt::format(messages::kValuesForColumns, 6, 7))},
        {"1,2,3,4,5,6,7,8\n",
         fmt::format(messages::kLineOf, 2, fmt::format(messages::kTooManyValues, 7, "{}"))},
        {"1,2,3,x,5,6,7\n",
         fmt::format(messages::kLineOf, 2, fmt::format(messages::kValueNotANumber, "x", "CMYK_K"))},
        {"1,2,3,4,nan,6,7\n", fmt::format(messages::kLineOf, 2,
                                          fmt::format(messages::kValueNotANumber, "nan", "LAB_L"))},
        {"1,2,3,400,5,6,7\n",
         fmt::format(messages::kLineOf, 2,
                     fmt::format(messages::kValueOutside, 400, "CMYK_K", "{}", "{}"))},
        {"50,50,50,0,5,6,7\n",
         fmt::format(messages::kLineOf, 2, fmt::format(messages::kInksAddUp, 150.0))},
        {"0,0,0,0,1e300,6,7\n", fmt::format(messages::kLineOf, 2, "{}")},
    };
    for (const Wrong& wrong : kRows) {
        const Result<SampleTable> table = parse_samples(head + wrong.text);
        ASSERT_FALSE(table) << wrong.text;
        EXPECT_THAT(table.error().text(), testing::Says(wrong.message));
    }
    std::string many = head;
    for (int i = 0; i < 4001; ++i)
        many += "0,0,0,0,1,2,3\n";
    EXPECT_THAT(parse_samples(many).error().text(),
                testing::Says(messages::kTooManyPatches, "4000"));
}

TEST(Charts, InksAddUpToOneAndColoursCoverTheCube) {
    const SampleTable inks = ink_chart();
    EXPECT_EQ(inks.samples.size(), 360);
    for (const Sample& s : inks.samples) {
        const double sum = s.inks[0] + s.inks[1] + s.inks[2] + s.inks[3];
        EXPECT_LE(sum, 1 + 5e-5) << s.id;  // of rounded amounts
    }
    EXPECT_EQ(color_chart().samples.size(), 240);
}

}  // namespace
}  // namespace openfab::color

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

TEST(Samples, FormattedTablesAreReadBack) {
    SampleTable chart = ink_chart();
    chart.has_lab = true;
    chart.samples[7].lab = {12.345, -6.789, 0.001};
    const Result<SampleTable> back = parse_samples(format_samples(chart, "round"));
    ASSERT_TRUE(back) << back.error().text();
    EXPECT_EQ(back->columns, chart.columns);
    ASSERT_EQ(back->samples.size(), chart.samples.size());
    for (size_t k = 0; k < chart.samples.size(); ++k) {
        for (size_t i = 0; i < 4; ++i)
            EXPECT_NEAR(back->samples[k].inks[i], chart.samples[k].inks[i], 1e-12) << k;
    }
    EXPECT_EQ(back->samples[7].lab.a, -6.789);
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

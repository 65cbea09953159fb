// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The loop: a chart of a known printer to a profile, colours through the profile to inks, inks
// through the printer to colours.

#include "tools/color/profile.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/color.h"
#include "tests/support/says/says.h"
#include "tests/unit/color/saved_profile.h"
#include "tests/unit/color/synthetic_printer.h"
#include "tools/color/messages.h"

namespace openfab::color {
namespace {

using openfab::testing::random_inks;
using openfab::testing::SyntheticPrinter;

#ifdef OPENFAB_SANITIZED
constexpr int kInkNodes = 9, kColorNodes = 9;
#else
constexpr int kInkNodes = 17, kColorNodes = 33;
#endif

std::vector<uint8_t> bytes_of(const std::string& text) {
    return {text.begin(), text.end()};
}

/// The profile of a printer with 20 % of dot gain.
class Profile : public ::testing::Test {
  protected:
    static void SetUpTestSuite() {
        printer_ = new SyntheticPrinter(0.2);
        const Result<PrinterModel> model = PrinterModel::fit(printer_->measured(0));
        ASSERT_TRUE(model) << model.error().text();
        white_ = model->white();
        ProfileOptions options;
        options.ink_nodes = kInkNodes;
        options.color_nodes = kColorNodes;
        options.description = "a known printer";
        options.measurements = "CGATS.17\n";
        const Result<std::string> made = make_profile(*model, options);
        ASSERT_TRUE(made) << made.error().text();
        made_ = new std::string(*made);
    }
    static void TearDownTestSuite() {
        delete printer_;
        delete made_;
    }
    static PrinterProfile parsed() {
        Result<PrinterProfile> profile = PrinterProfile::parse(bytes_of(*made_));
        EXPECT_TRUE(profile) << profile.error().text();
        return std::move(*profile);
    }
    /// What the printer makes, relative to its white.
    static Lab printed(const Inks& inks) {
        return to_lab(to_xyz(printer_->print(inks)), to_xyz(white_));
    }

    static SyntheticPrinter* printer_;
    static std::string* made_;
    static Lab white_;
};
SyntheticPrinter* Profile::printer_ = nullptr;
std::string* Profile::made_ = nullptr;
Lab Profile::white_;

TEST_F(Profile, SaysWhatItIs) {
    EXPECT_EQ(parsed().description(), "a known printer");
}

TEST_F(Profile, PredictsThePrinter) {
    const PrinterProfile profile = parsed();
    std::mt19937 random(3);
    std::vector<Inks> inks;
    for (int i = 0; i < 300; ++i)
        inks.push_back(random_inks(&random));
    const Result<std::vector<Lab>> relative = profile.to_lab(inks, false);
    const Result<std::vector<Lab>> absolute = profile.to_lab(inks, true);
    ASSERT_TRUE(relative && absolute);
    double sum = 0, sum_absolute = 0;
    for (size_t i = 0; i < inks.size(); ++i) {
        sum += ciede2000((*relative)[i], printed(inks[i]));
        sum_absolute += ciede2000((*absolute)[i], printer_->print(inks[i]));
    }
    const double most = kInkNodes < 17 ? 3 : 0.8;
    EXPECT_LT(sum / 300, most);
    EXPECT_LT(sum_absolute / 300, most);
}

TEST_F(Profile, ColoursThatTheInksReachComeBack) {
    const PrinterProfile profile = parsed();
    // Colours of random inks are within reach by nature; sRGB must have them, too.
    std::mt19937 random(4);
    std::vector<Rgb> colours;
    std::vector<Lab> wanted;
    while (colours.size() < 300) {
        const Lab lab = printed(random_inks(&random));
        Rgb rgb = linear_of_xyz(to_xyz(lab));
        const auto [least, most] = std::minmax_element(rgb.begin(), rgb.end());
        if (*least < 0 || *most > 1) continue;
        for (double& channel : rgb)
            channel = linear_to_srgb(channel);
        colours.push_back(rgb);
        wanted.push_back(lab);
    }
    const Result<std::vector<Inks>> inks = profile.to_inks(colours, Intent::kRelative, false);
    ASSERT_TRUE(inks) << inks.error().text();
    double sum = 0, worst = 0;
    for (size_t i = 0; i < wanted.size(); ++i) {
        const double total = (*inks)[i][0] + (*inks)[i][1] + (*inks)[i][2] + (*inks)[i][3];
        EXPECT_LT(total, 1.03);  // between nodes of the square curves
        const double difference = ciede2000(wanted[i], printed(limited((*inks)[i], 1)));
        sum += difference;
        worst = std::max(worst, difference);
    }
    std::printf("round trip: CIEDE2000 %.2f in the mean, %.2f at worst\n",
                sum / static_cast<double>(wanted.size()), worst);
    EXPECT_LT(sum / static_cast<double>(wanted.size()), kInkNodes < 17 ? 5 : 1.3);
    EXPECT_LT(worst, kInkNodes < 17 ? 20 : 7);
}

TEST_F(Profile, IntentsDifferAsTheySay) {
    const PrinterProfile profile = parsed();
    const std::vector<Rgb> colours = {{1, 1, 1}, {0, 0, 0}, {0.2, 0.2, 0.2}};
    const auto through = [&](Intent intent) {
        const Result<std::vector<Inks>> inks = profile.to_inks(colours, intent, false);
        EXPECT_TRUE(inks);
        const Result<std::vector<Lab>> labs = profile.to_lab(*inks, false);
        EXPECT_TRUE(labs);
        return *labs;
    };
    const std::vector<Lab> perceptual = through(Intent::kPerceptual);
    const std::vector<Lab> relative = through(Intent::kRelative);
    EXPECT_NEAR(relative[0].l, 100, 1);
    EXPECT_NEAR(perceptual[0].l, 100, 1);
    // The relative intent clips to the darkest that there is, grey or not; the perceptual one ends at
    // the darkest grey, and what lies above it keeps its distance.
    EXPECT_GT(perceptual[1].l, relative[1].l - 1);
    EXPECT_NEAR(perceptual[1].l, relative[1].l, 1);  // black is the print's, and no lighter
    EXPECT_GT(perceptual[2].l, perceptual[1].l + 8);
    EXPECT_LT(relative[2].l, relative[1].l + 8);
}

TEST_F(Profile, LimitAndBlackAreKept) {
    const Result<PrinterModel> model = PrinterModel::fit(printer_->measured(0));
    ASSERT_TRUE(model);
    const InkGrid grid(*model, 9);
    const Separation little(grid, {0, 1}), much(grid, {1, 1}), limited_to(grid, {0.5, 0.6});
    const Lab grey{45, 0, 0};
    EXPECT_LT(little.find(grey)[3] + 0.1, much.find(grey)[3]);
    EXPECT_LT(ciede2000(grid.at(little.find(grey)), grid.at(much.find(grey))), 1.5);
    for (const Lab& lab : {Lab{10, 0, 0}, Lab{50, 80, 60}, Lab{90, -10, 90}, Lab{30, 20, -60}}) {
        const Inks inks = limited_to.find(lab);
        EXPECT_LE(inks[0] + inks[1] + inks[2] + inks[3], 0.6 + 1e-9);
        for (const double ink : inks)
            EXPECT_GE(ink, 0);
    }
    // Hue is kept rather than chroma: a red beyond reach stays one.
    const Lab red{50, 90, 60}, near = grid.at(much.find(red));
    EXPECT_NEAR(std::atan2(near.b, near.a), std::atan2(red.b, red.a), 0.2);
}

TEST_F(Profile, OfVersionTwoSaysTheSame) {
    const Result<PrinterModel> model = PrinterModel::fit(printer_->measured(0));
    ASSERT_TRUE(model);
    ProfileOptions options;
    options.ink_nodes = kInkNodes;
    options.color_nodes = 9;
    std::array<std::string, 2> made;
    for (const bool two : {false, true}) {
        options.version_two = two;
        const Result<std::string> bytes = make_profile(*model, options);
        ASSERT_TRUE(bytes) << bytes.error().text();
        EXPECT_EQ((*bytes)[8], two ? 2 : 4);
        EXPECT_EQ(bytes->find("mft2") != std::string::npos, two);
        made[two ? 1 : 0] = *bytes;
    }
    const Result<PrinterProfile> four = PrinterProfile::parse(bytes_of(made[0])),
                                 two = PrinterProfile::parse(bytes_of(made[1]));
    ASSERT_TRUE(four && two);
    std::mt19937 random(6);
    std::vector<Inks> inks = {{}, {1, 0, 0, 0}, {0, 0, 0, 1}};
    for (int i = 0; i < 200; ++i)
        inks.push_back(random_inks(&random));
    for (const bool absolute : {false, true}) {
        const Result<std::vector<Lab>> a = four->to_lab(inks, absolute),
                                       b = two->to_lab(inks, absolute);
        ASSERT_TRUE(a && b);
        double sum = 0;
        for (size_t i = 0; i < inks.size(); ++i)
            sum += ciede2000((*a)[i], (*b)[i]);
        // Roots of less than a 4096th are a table's.
        EXPECT_LT(sum / static_cast<double>(inks.size()), 0.05);
    }
    // White is bare, though 100 is not at the end of that version's encoding.
    const Result<std::vector<Inks>> white = two->to_inks({{1, 1, 1}}, Intent::kRelative, false);
    ASSERT_TRUE(white);
    for (const double ink : (*white)[0])
        EXPECT_LT(ink, 2e-3);
}

TEST_F(Profile, DarkGreysAreAsNearAsTheInksGet) {
    const Result<PrinterModel> model = PrinterModel::fit(SyntheticPrinter(0).measured(0));
    ASSERT_TRUE(model);
    const InkGrid grid(*model, 17);
    // All mixtures in steps of 5 %.
    std::vector<Lab> reached;
    for (int c = 0; c <= 20; ++c) {
        for (int m = 0; m <= 20 - c; ++m) {
            for (int y = 0; y <= 20 - c - m; ++y) {
                for (int k = 0; k <= 20 - c - m - y; ++k)
                    reached.push_back(grid.at({c / 20.0, m / 20.0, y / 20.0, k / 20.0}));
            }
        }
    }
    const auto off = [](const Lab& a, const Lab& b) {
        return std::hypot(a.l - b.l, a.a - b.a, a.b - b.b);
    };
    for (const double black : {0.0, 0.5, 1.0}) {
        const Separation separation(grid, {black, 1});
        double before = 0;
        for (double l = 3; l < 60; l += 0.5) {
            const Lab grey{l, 0, 0}, is = grid.at(separation.find(grey));
            double nearest = off(grey, grid.at({0, 0, 0, 1}));
            for (const Lab& lab : reached)
                nearest = std::min(nearest, off(grey, lab));
            EXPECT_LT(off(grey, is), nearest + 0.5) << black << ", " << l;
            EXPECT_GT(is.l, before - 0.3) << black << ", " << l;
            before = is.l;
        }
    }
}

TEST_F(Profile, MixturesWithoutWhiteAreWhatTheModelSays) {
    const Result<PrinterModel> model = PrinterModel::fit(SyntheticPrinter(0).measured(0));
    ASSERT_TRUE(model);
    const InkGrid grid(*model, 17);
    std::mt19937 random(7);
    double sum = 0, lighter = 0;
    constexpr int kMixtures = 2000;
    for (int i = 0; i < kMixtures; ++i) {
        Inks inks = random_inks(&random);
        const double total = inks[0] + inks[1] + inks[2] + inks[3];
        for (double& ink : inks)
            ink /= total;
        const Lab wanted = to_lab(to_xyz(model->predict(inks)), to_xyz(model->white()));
        sum += ciede2000(wanted, grid.at(inks));
        lighter += grid.at(inks).l - wanted.l;
    }
    // Cells that reach beyond these mixtures once showed white in them: 0.98, and 1.1 lighter.
    EXPECT_LT(sum / kMixtures, 0.2);
    EXPECT_NEAR(lighter / kMixtures, 0, 0.15);
}

/// Colours of one hue from dark to light, relative to white.
std::vector<Lab> ramp(double chroma, double degrees, double step) {
    const double radians = degrees * std::acos(-1.0) / 180;
    std::vector<Lab> out;
    for (int i = 0; i * step <= 100; ++i)
        out.push_back({i * step, chroma * std::cos(radians), chroma * std::sin(radians)});
    return out;
}

/// How much darker a colour prints at most than a darker one.
double reversal(const std::vector<double>& lightness) {
    double before = 0, most = 0;
    for (const double l : lightness) {
        most = std::max(most, before - l);
        before = std::max(before, l);
    }
    return most;
}

double distance(const Lab& a, const Lab& b) {
    return std::hypot(a.l - b.l, a.a - b.a, a.b - b.b);
}

TEST_F(Profile, RampsDoNotTurnBackAndAreAsNearAsBlack) {
    constexpr double kStep = 0.39;  // of a lightness of 8 bits
    constexpr std::array<std::array<double, 2>, 4> kOptions = {
        {{0, 1}, {0.5, 1}, {1, 1}, {0.5, 0.8}}};
    for (const auto& [gain, noise] : {std::pair(0.0, 0.0), std::pair(0.2, 0.3)}) {
        const Result<PrinterModel> model =
            PrinterModel::fit(SyntheticPrinter(gain).measured(noise));
        ASSERT_TRUE(model);
        const InkGrid grid(*model, 17);
        for (const auto& [black, limit] : kOptions) {
            const Separation separation(grid, {black, limit});
            const Lab darkest = grid.at({0, 0, 0, limit});
            int turned = 0, ramps = 0;
            for (const double chroma : {0, 20, 60}) {
                for (double hue = 0; hue < (chroma > 0 ? 360 : 1); hue += 60) {
                    SCOPED_TRACE(fmt::format("gain {}, black {}, limit {}, chroma {}, hue {}", gain,
                                             black, limit, chroma, hue));
                    std::vector<double> lightness;
                    for (const Lab& wanted : ramp(chroma, hue, chroma > 0 ? 1 : 0.1)) {
                        const Lab is = grid.at(separation.find(wanted));
                        lightness.push_back(is.l);
                        if (chroma > 0) continue;
                        EXPECT_LT(distance(is, wanted), distance(darkest, wanted) + 1e-3);
                    }
                    const double back = reversal(lightness);
                    turned += back > kStep ? 1 : 0;
                    EXPECT_TRUE(chroma > 0 || turned == 0) << back;
                    ++ramps;
                }
            }
            // What inks reach has dents: a hue beyond them may have two nearest colours.
            EXPECT_LE(turned, ramps / 5) << "gain " << gain << ", black " << black;
        }
    }
}

TEST_F(Profile, GreysBetweenNodesDoNotTurnBackAndAreAsNearAsBlack) {
    const PrinterProfile profile = parsed();
    for (const Intent intent : {Intent::kPerceptual, Intent::kRelative}) {
        std::vector<Rgb> greys;
        constexpr int kSteps = 2000;
        for (int i = 0; i <= kSteps; ++i)
            greys.push_back({i / double{kSteps}, i / double{kSteps}, i / double{kSteps}});
        Result<std::vector<Inks>> inks = profile.to_inks(greys, intent, false);
        ASSERT_TRUE(inks);
        for (Inks& mixture : *inks)
            mixture = limited(mixture, 1);
        inks->push_back({0, 0, 0, 1});
        const Result<std::vector<Lab>> is = profile.to_lab(*inks, false);
        ASSERT_TRUE(is);
        std::vector<double> lightness;
        for (size_t i = 0; i < greys.size(); ++i) {
            const double light = srgb_to_linear(greys[i][0]);
            const Lab wanted = to_lab(xyz_of_linear({light, light, light}));
            lightness.push_back((*is)[i].l);
            if (intent != Intent::kRelative) continue;
            EXPECT_LT(distance((*is)[i], wanted), distance(is->back(), wanted) + 0.05)
                << "grey " << i;
        }
        EXPECT_LT(reversal(lightness), kColorNodes < 33 ? 1 : 0.1);
    }
}

}  // namespace
}  // namespace openfab::color

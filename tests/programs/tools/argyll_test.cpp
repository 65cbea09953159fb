// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Argyll (Debian's package argyll), which people measure charts with, takes our measurements and our profiles
// of ICC version 2, and looks colours up in them as we do.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <sstream>

#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/unit/color/synthetic_printer.h"
#include "tools/color/profile.h"

namespace openfab::testing {
namespace {

Outcome run_in(const ScratchFolder& folder, const std::vector<std::string>& arguments) {
    RunOptions options;
    options.folder = folder.path();
    return run(arguments, options);
}

Outcome shell(const ScratchFolder& folder, const std::string& command) {
    return run_in(folder, {"/bin/sh", "-c", command});
}

double number_behind(const std::string& text, const std::string& words) {
    const size_t at = text.find(words);
    EXPECT_NE(at, std::string::npos) << text;
    return at == std::string::npos ? 1e9 : std::stod(text.substr(at + words.size()));
}

/// The numbers that xicclu prints behind `->`.
std::vector<std::vector<double>> looked_up(const std::string& text) {
    std::vector<std::vector<double>> out;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        const size_t at = line.rfind("-> ");
        if (at == std::string::npos) continue;
        std::istringstream words(line.substr(at + 3));
        out.emplace_back();
        for (double value; words >> value;)
            out.back().push_back(value);
    }
    return out;
}

TEST(Argyll, ReadsMeasurementsAndProfilesOfVersionTwo) {
    if (std::system("command -v xicclu > /dev/null 2>&1") != 0)
        GTEST_SKIP() << "there is no xicclu; the package argyll has it";
    const ScratchFolder folder;
    const std::string color = program("openfab-color");
    const std::string inks = source_dir() / "gallery/ink_profile/vero.csv";
    ASSERT_EQ(run_in(folder, {color, "chart", "-o", "chart"}).exit_code, 0);
    ASSERT_EQ(run_in(folder, {color, "simulate", inks, "chart/chart.txt", "-o", "measured.ti3"})
                  .exit_code,
              0);
    const Outcome made =
        run_in(folder, {color, "profile", "measured.ti3", "-o", "printer.icc", "--icc", "2"});
    ASSERT_EQ(made.exit_code, 0) << made.err;

    // It makes a profile of its own of our measurements.
    const Outcome colprof = shell(folder, "colprof -ql -nc -D test measured");
    EXPECT_EQ(colprof.exit_code, 0) << colprof.out << colprof.err;

    const Outcome dumped = shell(folder, "iccdump printer.icc");
    EXPECT_EQ(dumped.exit_code, 0) << dumped.err;
    EXPECT_NE(dumped.out.find("2.4"), std::string::npos) << dumped.out;
    const Outcome checked = shell(folder, "profcheck -k measured.ti3 printer.icc");
    ASSERT_EQ(checked.exit_code, 0) << checked.out << checked.err;
    EXPECT_LT(number_behind(checked.out, "avg. = "), 1) << checked.out;

    // Inks to colours.
    const Result<color::PrinterProfile> profile =
        color::PrinterProfile::read(folder / "printer.icc");
    ASSERT_TRUE(profile) << profile.error().text();
    std::mt19937 random(11);
    std::vector<color::Inks> mixtures;
    std::string lines;
    for (int i = 0; i < 200; ++i) {
        mixtures.push_back(random_inks(&random));
        const color::Inks& m = mixtures.back();
        lines += fmt::format("{:.9f} {:.9f} {:.9f} {:.9f}\n", m[0], m[1], m[2], m[3]);
    }
    folder.write("inks.txt", lines);
    for (const bool absolute : {false, true}) {
        const Result<std::vector<color::Lab>> ours = profile->to_lab(mixtures, absolute);
        ASSERT_TRUE(ours);
        const Outcome theirs =
            shell(folder,
                  fmt::format("xicclu -ff -i{} -pl printer.icc < inks.txt", absolute ? 'a' : 'r'));
        const std::vector<std::vector<double>> labs = looked_up(theirs.out);
        ASSERT_EQ(labs.size(), mixtures.size()) << theirs.out << theirs.err;
        double sum = 0;
        for (size_t k = 0; k < labs.size(); ++k) {
            ASSERT_GE(labs[k].size(), 3u);
            const double off = color::ciede2000((*ours)[k], {labs[k][0], labs[k][1], labs[k][2]});
            // It takes other tetrahedra of four dimensions between the nodes.
            EXPECT_LT(off, 4) << k;
            sum += off;
        }
        EXPECT_LT(sum / static_cast<double>(labs.size()), 0.5);
    }

    // Colours that the inks reach, to inks and back; white is bare.
    const Result<std::vector<color::Lab>> wanted = profile->to_lab(mixtures, false);
    ASSERT_TRUE(wanted);
    lines = "100 0 0\n";
    for (const color::Lab& lab : *wanted)
        lines += fmt::format("{:.6f} {:.6f} {:.6f}\n", lab.l, lab.a, lab.b);
    folder.write("colours.txt", lines);
    const Outcome back = shell(folder, "xicclu -fb -ir -pl printer.icc < colours.txt");
    const std::vector<std::vector<double>> separated = looked_up(back.out);
    ASSERT_EQ(separated.size(), mixtures.size() + 1) << back.out << back.err;
    std::vector<color::Inks> again;
    for (const std::vector<double>& one : separated) {
        ASSERT_GE(one.size(), 4u);
        again.push_back(color::limited({one[0], one[1], one[2], one[3]}, 1));
    }
    for (const double ink : again[0])
        EXPECT_LT(ink, 1e-3);
    const Result<std::vector<color::Lab>> is = profile->to_lab(again, false);
    ASSERT_TRUE(is);
    double sum = 0;
    for (size_t k = 0; k < wanted->size(); ++k)
        sum += color::ciede2000((*wanted)[k], (*is)[k + 1]);
    EXPECT_LT(sum / static_cast<double>(wanted->size()), 1.3);
}

}  // namespace
}  // namespace openfab::testing

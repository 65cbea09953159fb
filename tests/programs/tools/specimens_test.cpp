// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab specimens`: pieces have their standard's outline, labels read right, and curves give the properties that made
// them.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tools/openfab/messages.h"
#include "tools/specimens/messages.h"

namespace openfab::testing {
namespace {

namespace fs = std::filesystem;
namespace messages = specimens::messages;
using ::testing::HasSubstr;
using ::testing::Not;

/// The voxels of a print, x by y by z.
struct Voxels {
    std::string text;
    size_t begin = 0;
    int x = 0, y = 0, z = 0;
    int at(int i, int k, int n) const {
        return static_cast<uint8_t>(
            text[begin +
                 (static_cast<size_t>(n) * static_cast<size_t>(y) + static_cast<size_t>(k)) *
                     static_cast<size_t>(x) +
                 static_cast<size_t>(i)]);
    }
    int sum_along_y(int i, int n) const {
        int out = 0;
        for (int k = 0; k < y; ++k)
            out += at(i, k, n) != 0;
        return out;
    }
};

class Specimens : public ::testing::Test {
  protected:
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    Outcome openfab(std::vector<std::string> words) const {
        words.insert(words.begin(), program("openfab"));
        return run(words, {{{"OPENFAB_CACHE", path("cache")}}, {}, {}});
    }
    Outcome make(const std::string& folder, const std::vector<std::string>& more) const {
        std::vector<std::string> words{"specimens", "make", "-o", path(folder)};
        words.insert(words.end(), more.begin(), more.end());
        return openfab(words);
    }
    Outcome read(const std::string& folder, const std::vector<std::string>& more = {}) const {
        std::vector<std::string> words{"specimens",    "read",     path(folder), "--curves",
                                       path("curves"), "--source", "this test"};
        words.insert(words.end(), more.begin(), more.end());
        return openfab(words);
    }
    Voxels print(const std::string& world, const std::string& voxel) const {
        const std::string file = path("voxels.npy");
        const Outcome printed =
            openfab({"print", world, "-o", file, "--voxel", voxel, "--progress", "none"});
        EXPECT_EQ(printed.exit_code, 0) << printed.err;
        Voxels out;
        out.text = read_file(file);
        const size_t shape = out.text.find("'shape': (");
        std::istringstream numbers(out.text.substr(shape + 10, 60));
        char comma = 0;
        numbers >> out.z >> comma >> out.y >> comma >> out.x;
        out.begin = out.text.find('\n') + 1;
        return out;
    }

    ScratchFolder scratch_;
};

constexpr std::array<std::array<std::string_view, 5>, 10> kDigits{
    {{"###", "#.#", "#.#", "#.#", "###"},
     {".#.", "##.", ".#.", ".#.", "###"},
     {"###", "..#", "###", "#..", "###"},
     {"###", "..#", "###", "..#", "###"},
     {"#.#", "#.#", "###", "..#", "..#"},
     {"###", "#..", "###", "..#", "###"},
     {"###", "#..", "###", "#.#", "###"},
     {"###", "..#", "..#", "..#", "..#"},
     {"###", "#.#", "###", "#.#", "###"},
     {"###", "#.#", "###", "..#", "###"}}};

/// Whether a number stands at the middle of an area, in cells: `ink` is of cells to the right and up from its middle.
bool is_number(const std::string& number, const std::function<bool(double, double)>& ink) {
    const double wide = 4 * static_cast<double>(number.size()) - 1;
    for (size_t d = 0; d < number.size(); ++d) {
        for (int row = 0; row < 5; ++row) {
            for (int column = 0; column < 3; ++column) {
                const bool wanted =
                    kDigits[static_cast<size_t>(number[d] - '0')][static_cast<size_t>(row)]
                           [static_cast<size_t>(column)] == '#';
                const double right = 4 * static_cast<double>(d) + column + 0.5 - wide / 2;
                if (ink(right, 6.5 - row - 3.5) != wanted) return false;
            }
        }
    }
    return ink(0, -3) && !ink(0, -2);
}

TEST_F(Specimens, BarsHaveTheirOutline) {
    struct Bar {
        const char* name;
        double parallel, narrow, ends, overall, fillet, shoulder;
    };
    for (const Bar& bar : {Bar{"d638-v", 9.53, 3.18, 9.53, 63.5, 12.7, 0},
                           Bar{"iso527-5a", 25, 4, 12.5, 75, 8, 12.5}}) {
        SCOPED_TRACE(bar.name);
        ASSERT_EQ(make(bar.name, {"--printer", "generic", "--material", "a", "--piece", bar.name,
                                  "--copies", "1"})
                      .exit_code,
                  0);
        const Voxels voxels = print(path(bar.name) + "/specimens.fab.json", "0.1mm");
        const double rise = (bar.ends - bar.narrow) / 2, reach = bar.fillet + bar.shoulder;
        const double turn = std::acos(1 - rise / reach),
                     bend = bar.parallel / 2 + bar.fillet * std::sin(turn);
        const double wide = bar.parallel / 2 + reach * std::sin(turn);
        for (int i = 0; i < static_cast<int>(bar.overall / 0.1); ++i) {
            const double x = std::abs((i + 0.5) * 0.1 - bar.overall / 2);
            double half = bar.ends / 2;
            if (x < bar.parallel / 2)
                half = bar.narrow / 2;
            else if (x < bend)
                half = bar.narrow / 2 + bar.fillet -
                       std::sqrt(bar.fillet * bar.fillet - std::pow(x - bar.parallel / 2, 2));
            else if (x < wide)
                half = bar.ends / 2 - bar.shoulder +
                       std::sqrt(bar.shoulder * bar.shoulder - std::pow(wide - x, 2));
            EXPECT_NEAR(voxels.sum_along_y(i, 5) * 0.1, 2 * half, 0.11) << x;
        }
    }
}

TEST_F(Specimens, LabelsReadRightAlongEveryAxis) {
    // Cells of d638-v's digits are 0.85 x 3.2 / 7 mm; two digits are 7 cells wide.
    const double cell = 0.85 * 3.2 / 7 / 0.1;
    for (const std::string along : {"x", "y", "z"}) {
        SCOPED_TRACE(along);
        ASSERT_EQ(make(along, {"--printer", "generic", "--material", "a", "--piece", "d638-v",
                               "--copies", "12", "--along", along})
                      .exit_code,
                  0);
        const Voxels voxels = print(path(along) + "/specimens.fab.json", "0.1mm");
        // The middle of the highest label is that of the piece's end, in voxels from the print's corner; the twelfth piece
        // comes last.
        const double wide = 9.53 / 0.1, high = 3.2 / 0.1;
        std::function<bool(double, double)> ink;
        if (along == "x") {
            ink = [&](double right, double up) {
                return voxels.at(voxels.x - 2, static_cast<int>(voxels.y - wide / 2 + right * cell),
                                 static_cast<int>(high / 2 + up * cell)) != 0;
            };
        } else if (along == "y") {
            ink = [&](double right, double up) {
                return voxels.at(static_cast<int>(voxels.x - wide / 2 - right * cell), voxels.y - 2,
                                 static_cast<int>(high / 2 + up * cell)) != 0;
            };
        } else {
            ink = [&](double right, double up) {
                return voxels.at(static_cast<int>(voxels.x - high / 2 - up * cell),
                                 static_cast<int>(voxels.y - wide / 2 + right * cell),
                                 voxels.z - 2) != 0;
            };
        }
        EXPECT_TRUE(is_number("12", ink));
        EXPECT_FALSE(is_number("12", [&](double right, double up) { return ink(-right, up); }));
    }
}

TEST_F(Specimens, DiscsAndThinBarsAreLabelled) {
    ASSERT_EQ(make("disc", {"--printer", "generic", "--material", "a", "--piece", "d395-2",
                            "--copies", "1"})
                  .exit_code,
              0);
    const Voxels disc = print(path("disc") + "/specimens.fab.json", "0.1mm");
    const double cell = 6;  // 0.6 mm
    EXPECT_TRUE(is_number("1", [&](double right, double up) {
        return disc.at(disc.x - 3, static_cast<int>(disc.y / 2.0 + right * cell),
                       static_cast<int>(30 + up * cell)) != 0;
    }));
    EXPECT_NEAR(disc.sum_along_y(65, 30), 130, 1);
    ASSERT_EQ(make("thin", {"--printer", "generic", "--material", "a", "--piece", "iso527-5b",
                            "--copies", "1"})
                  .exit_code,
              0);
    const Voxels thin = print(path("thin") + "/specimens.fab.json", "0.1mm");
    const double flat = 6.0 / 2 / 7 / 0.1;  // half a width has the seven cells of a label
    EXPECT_EQ(thin.z, 12);
    EXPECT_TRUE(is_number("1", [&](double right, double up) {
        return thin.at(static_cast<int>(350 - 4.5 * flat + up * flat),
                       static_cast<int>(30 - right * flat), 11) != 0;
    }));
}

TEST_F(Specimens, MixturesAndTraysAreListed) {
    const Outcome made =
        make("bars", {"--printer", "j750", "--material", "VeroClear", "--material", "Agilus30Clr",
                      "--piece", "iso527-1a", "--steps", "3", "--copies", "20"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
    const std::string list = read_file(path("bars") + "/specimens.csv");
    EXPECT_THAT(list,
                HasSubstr("label,tray,piece,width_mm,thickness_mm,share of VeroClear,share of "
                          "Agilus30Clr\n1,1,iso527-1a,10,4,1,0\n2,1,iso527-1a,10,4,0.5,0.5\n3,1,"
                          "iso527-1a,10,4,0,1\n4,1,"));
    // Two in a row and 15 rows fit a tray of 490 x 390 mm.
    EXPECT_THAT(list, HasSubstr("\n30,1,"));
    EXPECT_THAT(list, HasSubstr("\n31,2,"));
    const Outcome estimate =
        openfab({"print", path("bars") + "/specimens-2.fab.json", "--estimate"});
    EXPECT_EQ(estimate.exit_code, 0) << estimate.err;
    EXPECT_THAT(estimate.err, Not(HasSubstr("overlap")));
}

TEST_F(Specimens, FabletsAreSwept) {
    scratch_.write("wall.fl", "const float WALL = 0.4;\n");
    scratch_.write("foam.fl",
                   "import wall;\n\nfablet Foam {\n    @uniform { Material stuff; float pitch = 1; "
                   "}\n\n    @Volume(@varying { VolumeAttributes attr })\n    {\n"
                   "        MaterialComposition mc;\n        if (frac(attr.voxelCenter.x / pitch) "
                   "< WALL) mc.Set(stuff, 1);\n        return mc;\n    }\n}\n");
    const Outcome made = make("foam", {"--printer", "generic", "--material", "rubber", "--piece",
                                       "d638-v", "--copies", "1", "--fablet", path("foam.fl"),
                                       "--set", "stuff=rubber", "--sweep", "pitch=1,2"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
    EXPECT_THAT(read_file(path("foam") + "/specimens.csv"),
                HasSubstr("thickness_mm,pitch\n1,1,d638-v,3.18,3.2,1\n2,1,d638-v,3.18,3.2,2\n"));
    const Outcome printed = openfab(
        {"print", path("foam") + "/specimens.fab.json", "-o", path("foam.ofr"), "--draft", "4"});
    EXPECT_EQ(printed.exit_code, 0) << printed.err;
}

/// A straight line up to a strain of 0.02, then a break.
std::string curve(double modulus, const std::string& header, const std::string& between,
                  double per_strain, double per_stress, bool comma) {
    std::string out = header;
    for (int i = 0; i <= 200; ++i) {
        const double strain = i * 1e-4;
        std::string row = fmt::format("{:.9g}{}{:.9g}\n", strain * per_strain, between,
                                      strain * modulus * per_stress);
        if (comma)
            for (char& c : row)
                c = c == '.' ? ',' : c;
        out += row;
    }
    return out + (comma ? "2,01" + between + "0\n" : "");
}

TEST_F(Specimens, CurvesBecomeTables) {
    ASSERT_EQ(make("bars", {"--printer", "j750", "--material", "stiff", "--material", "soft",
                            "--piece", "d638-iv", "--steps", "3", "--copies", "2"})
                  .exit_code,
              0);
    EXPECT_EQ(read("bars").exit_code, 1);  // no such folder
    fs::create_directory(path("curves"));
    // 6 x 3.2 mm, 65 mm between the grips; specimens 1 and 4 are stiff, 3 and 6 soft.
    scratch_.write("curves/001.csv", curve(2000, "Strain (%),Stress (MPa)\n", ",", 100, 1, false));
    scratch_.write("curves/4.csv",
                   curve(2100, "machine x\n\"Tensile strain (mm/mm)\",\"Force (kN)\"\n", ",", 1,
                         19.2 / 1000, false));
    scratch_.write("curves/2.txt", curve(500, "Dehnung\tKraft\n%\tN\n", "\t", 100, 19.2, true));
    scratch_.write("curves/3.csv", curve(10, "strain;stress_kPa\n", ";", 1, 1000, true));
    scratch_.write("curves/6.csv", curve(-12, "strain,stress_MPa\n", ",", -1, 1, false));
    scratch_.write("curves/99.csv", "1,2\n");
    scratch_.write("curves/5.tsv",
                   "time\tExtension [mm]\tLoad "
                   "[N]\n0\t0\t0\n1\t0.065\t10.368\n2\t0.13\t20.736\n3\t0.1625\t25.92\n");
    const Outcome out = read("bars", {"--nu", "stiff=0.35", "--nu", "soft=0.48"});
    ASSERT_EQ(out.exit_code, 0) << out.err;
    EXPECT_THAT(out.err, Says(tools::messages::kCurvesUnmatched, "99.csv"));
    EXPECT_THAT(out.err, HasSubstr(tools::messages::kStrainOfGrips));
    const std::string measured = read_file(path("bars") + "/measured.csv");
    for (const char* row :
         {"1,1,0,2000,40,0.02\n", "4,1,0,2100,42,0.02\n", "2,0.5,0.5,500,10,0.02\n",
          "3,0,1,10,0.2,0.02\n", "6,0,1,12,0.24,0.02\n", "5,0.5,0.5,540,"})
        EXPECT_THAT(measured, HasSubstr(row));
    const std::string table = read_file(path("bars") + "/modulus.json");
    EXPECT_THAT(table, HasSubstr("\"deviation\": 28.28427124"));
    EXPECT_THAT(table, HasSubstr("\"count\": 2"));
    const Outcome module = openfab({"property", path("bars") + "/modulus.json"});
    EXPECT_EQ(module.exit_code, 0) << module.err;
    EXPECT_THAT(module.out, HasSubstr("MODULUS_LOWEST = 11, MODULUS_HIGHEST = 2050"));
    EXPECT_THAT(read_file(path("bars") + "/mechanics.json"), HasSubstr("\"law\": \"table\""));
    EXPECT_EQ(read("bars", {"--temperature", "23C"}).exit_code, 2);
    ASSERT_EQ(read("bars", {"--temperature", "23C", "--rate", "0.01/s"}).exit_code, 0);
    const Outcome same = openfab({"property", path("bars") + "/modulus.json"});
    EXPECT_EQ(same.out, module.out);
    EXPECT_EQ(
        openfab({"property", path("bars") + "/modulus.json", "--temperature", "37C"}).exit_code, 1);
    const Outcome there = openfab(
        {"property", path("bars") + "/modulus.json", "--temperature", "23C", "--rate", "100s"});
    EXPECT_THAT(there.out, HasSubstr("At 23 C. At a rate of 0.01/s."));
}

TEST_F(Specimens, WrongRequestsAreRefused) {
    const std::vector<std::string> good{"--printer", "generic", "--material", "a"};
    const auto refused = [&](std::vector<std::string> more, const std::string& text) {
        more.insert(more.begin(), good.begin(), good.end());
        const Outcome out = make("none", more);
        EXPECT_NE(out.exit_code, 0);
        EXPECT_THAT(out.err, HasSubstr(text));
        EXPECT_FALSE(fs::exists(path("none")));
    };
    refused({"--piece", "d638"}, "unknown test piece");
    refused({"--copies", "0"}, fmt::format(tools::messages::kSpecimenNumbers, 100, 100));
    refused({"--material", "a"}, tools::messages::kSpecimenMaterialTwice);
    refused({"--material", "b", "--mixture", "0.5,0.4"},
            fmt::format(tools::messages::kMixtureShares, "0.5,0.4", 2));
    refused({"--material", "b", "--mixture", "1.5,-0.5"},
            fmt::format(tools::messages::kShareOutside, "1.5"));
    refused({"--material", "b", "--material", "c"},
            fmt::format(tools::messages::kMixturesWanted, 3));
    refused({"--sweep", "pitch=1,2"}, tools::messages::kSweepOfMixture);
    refused({"--thickness", "90mm"},
            fmt::format(tools::messages::kSpecimenThickness, 90.0, 0.2, 50.0));
    refused({"--material", "b", "--steps", "100", "--copies", "100"},
            fmt::format(tools::messages::kSpecimenCount, 100, 100, 1000));
    EXPECT_THAT(make("none", {"--printer", "generic"}).err,
                HasSubstr("specimens of which materials"));
    EXPECT_THAT(
        make("none", {"--printer", "j55", "--material", "a", "--piece", "d638-iii", "--along", "z"})
            .err,
        HasSubstr(messages::kPieceTooLargeHelp));
}

TEST_F(Specimens, WrongCurvesAreRefused) {
    ASSERT_EQ(make("bars", {"--printer", "generic", "--material", "a", "--copies", "2"}).exit_code,
              0);
    fs::create_directory(path("curves"));
    EXPECT_THAT(read("bars").err, HasSubstr(messages::kNoCurvesHelp));
    const auto refused = [&](const std::string& text, const std::string& message) {
        scratch_.write("curves/1.csv", text);
        const Outcome out = read("bars");
        EXPECT_EQ(out.exit_code, 1);
        EXPECT_THAT(out.err, HasSubstr(message));
    };
    const std::string file = path("curves") + "/1.csv";
    refused("", fmt::format(messages::kCurveEmpty, file));
    refused("a,b\n0,0\n1,1\n2,2\n",
            fmt::format(messages::kColumnNotFound, file, "strain", "extension", "a, b"));
    refused("strain,strain 2,stress\n0,0,0\n1,1,1\n2,2,2\n",
            fmt::format(messages::kColumnsAlike, file, "strain", "strain 2", "strain", "--strain"));
    refused("strain,stress (bar)\n0,0\n1,1\n2,2\n", "no unit of stress");
    refused("strain,stress\n0,0\n1,1\n2,2\n", messages::kTooFewInRangeHelp);
    refused("strain,stress\n0,0\n1,0\n2,0\n", fmt::format(messages::kCurveFlat, file));
    refused("strain,stress\n0,0\n1,1\n2,2\nend,of it\n", messages::kCurveCellHelp);
    scratch_.write("curves/01.txt", "");
    refused("strain,stress\n0,0\n1,1\n2,2\n",
            fmt::format(messages::kTwoCurves, 1, "01.txt", "1.csv"));
    EXPECT_EQ(read("bars", {"--range", "2:1"}).exit_code, 2);
}

}  // namespace
}  // namespace openfab::testing

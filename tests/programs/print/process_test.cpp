// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The machine's process, as seen in the outputs: dead nozzles, scale, cost.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <rapidjson/document.h>

#include <algorithm>
#include <fstream>
#include <thread>

#include "base/messages.h"
#include "program/messages.h"
#include "runtime/process/bleed/messages.h"
#include "runtime/process/nozzles/messages.h"
#include "tests/programs/print/process_fixture.h"
#include "tests/support/says/says.h"
#include "world/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr uint8_t kWhite = 1, kBlack = 2, kGrey = 3;

TEST_F(ProcessOption, DeadRowsHoldNoDropOfTheirInk) {
    scratch_.write("dead.json", R"({"dead": [
        {"material": "K", "nozzles": [1, [3, 4]], "head": 8, "passes": 2, "pass": 1, "jog": 1,
         "substitute": "grey"},
        {"material": "white", "nozzles": [0], "head": 16, "substitute": "black"}]})");
    const Voxels alive = print_voxels({});
    const Voxels dead = print_voxels({"--process", path("dead.json")});
    ASSERT_EQ(alive.codes.size(), dead.codes.size());
    const auto mod = [](int32_t a, int32_t b) { return ((a % b) + b) % b; };
    const auto origin = static_cast<int32_t>(std::lround(dead.info.origin_mm.y / 0.1));
    const auto bottom = static_cast<int32_t>(std::lround(dead.info.origin_mm.z / 0.1));
    int64_t without_black = 0, without_white = 0, grey = 0, same = 0;
    for (int32_t z = 0; z < dead.info.size.z; ++z) {
        for (int32_t y = 0; y < dead.info.size.y; ++y) {
            const int32_t row = origin + y, shifted = row + bottom + z;
            const int32_t nozzle = mod((shifted - mod(shifted, 2)) / 2, 8);
            const bool no_black =
                mod(shifted, 2) == 1 && (nozzle == 1 || nozzle == 3 || nozzle == 4);
            const bool no_white = mod(row, 16) == 0;
            for (int32_t x = 0; x < dead.info.size.x; ++x) {
                const uint8_t before = alive.at(x, y, z), after = dead.at(x, y, z);
                ASSERT_EQ(before == 0, after == 0);
                if (no_black) {
                    ASSERT_NE(after, kBlack) << row;
                }
                if (no_white) {
                    ASSERT_NE(after, kWhite) << row;
                }
                if (!no_black) {
                    ASSERT_NE(after, kGrey) << row;
                }
                without_black += no_black && before == kBlack ? 1 : 0;
                without_white += no_white && before == kWhite ? 1 : 0;
                grey += after == kGrey ? 1 : 0;
                // Pure voxels of a material that can be printed stay.
                same += before == after ? 1 : 0;
            }
        }
    }
    EXPECT_GT(without_black, 1000);
    EXPECT_GT(without_white, 1000);
    EXPECT_GT(grey, without_black / 2);
    EXPECT_GT(same, static_cast<int64_t>(dead.codes.size()) * 7 / 10);
}

TEST_F(ProcessOption, DeadRowsAreTheSameForAllWaysToPrint) {
    scratch_.write("dead.json", R"({"dead": [{"material": "black", "nozzles": [[0, 2]], "head": 7,
        "jog": 3, "substitute": "grey"}]})");
    const std::vector<std::string> options{"--process", path("dead.json"), "--support", "white"};
    const Voxels whole = print_voxels(options);
    for (const std::vector<std::string>& more : std::vector<std::vector<std::string>>{
             {"--threads", "1"}, {"--threads", "5", "--no-cull"}, {"--groups-in-flight", "3"}}) {
        std::vector<std::string> all = options;
        all.insert(all.end(), more.begin(), more.end());
        EXPECT_TRUE(print_voxels(all).codes == whole.codes) << more.front();
    }
    std::vector<std::string> some = options;
    some.insert(some.end(), {"--slices", "13:30"});
    const Voxels part = print_voxels(some);
    const size_t slice = static_cast<size_t>(whole.info.size.x) * whole.info.size.y;
    EXPECT_TRUE(std::equal(part.codes.begin(), part.codes.end(),
                           whole.codes.begin() + static_cast<std::ptrdiff_t>(13 * slice)));
}

TEST_F(ProcessOption, DeadRowsHaveTheirShareInDrafts) {
    write_world("big.fab.json", R"(, "translate_mm": [20, 20, 0])", "", 16);
    for (const char* rows : {R"("head": 8)", R"("head": 4, "passes": 2, "pass": 1, "jog": 3)"}) {
        std::string dead;
        for (const char* material : {"white", "K"})
            dead +=
                fmt::format(R"({}{{"material": "{}", "nozzles": [3], {}, "substitute": "grey"}})",
                            dead.empty() ? "" : ", ", material, rows);
        scratch_.write("dead.json", fmt::format(R"({{"dead": [{}]}})", dead));
        for (const std::vector<std::string>& pitch :
             std::vector<std::vector<std::string>>{{"--draft", "2"},
                                                   {"--draft", "3"},
                                                   {"--draft", "4"},
                                                   {"--voxel", "0.25mm"},
                                                   {"--draft", "8"},
                                                   {"--draft", "16"}}) {
            std::vector<std::string> words{"--process", path("dead.json"), "--support", "off"};
            words.insert(words.end(), pitch.begin(), pitch.end());
            const Voxels found = print_voxels(words, "big.fab.json");
            const auto all = std::ranges::count_if(found.codes, [](uint8_t c) { return c != 0; });
            const auto grey = std::ranges::count(found.codes, kGrey);
            // A slice and a half of voxels of a ball, whose rows end anywhere, is what may be unlike.
            const double slack = std::min(0.02, 0.004 + 5.0 / static_cast<double>(all));
            EXPECT_NEAR(static_cast<double>(grey) / static_cast<double>(all), 0.125, slack)
                << rows << " " << pitch[1] << " of " << all;
        }
    }
}

TEST_F(ProcessOption, SupportGoesToTheSubstituteToo) {
    write_world("high.fab.json", R"(, "translate_mm": [0, 0, 2])", R"("support": "white",)");
    scratch_.write("dead.json", R"({"dead": [{"material": "white", "nozzles": [0], "head": 2,
        "substitute": "grey"}]})");
    const Voxels dead = print_voxels({"--process", path("dead.json")}, "high.fab.json");
    const auto origin = static_cast<int32_t>(std::lround(dead.info.origin_mm.y / 0.1));
    int64_t support = 0;
    for (int32_t z = 0; z < dead.info.size.z; ++z) {
        for (int32_t y = 0; y < dead.info.size.y; ++y) {
            for (int32_t x = 0; x < dead.info.size.x; ++x) {
                if ((origin + y) % 2 == 0) {
                    ASSERT_NE(dead.at(x, y, z), kWhite);
                }
                support += z < 20 && dead.at(x, y, z) == kGrey ? 1 : 0;
            }
        }
    }
    EXPECT_GT(support, 1000);
}

TEST_F(ProcessOption, NozzlesMayFailWhileAPrintStreams) {
    write_world("w.fab.json", "", "", 24);
    scratch_.write("n.json", "[]");
    const Outcome first = print({"--nozzles", path("n.json"), "-o", path("a.npy")});
    ASSERT_EQ(first.exit_code, 0) << first.err;
    EXPECT_THAT(read_file(path("a.npy.json")), Not(HasSubstr("dead")));
    // A pipe that nobody empties holds the print until the file has changed.
    scratch_.write("go.sh",
                   fmt::format(R"(
{0} {1} --nozzles {2} --groups-in-flight 1 --threads 1 --progress plain -o - --format ofr 2> {3} |
    (head -c 20000; sleep 0.2
     echo '[{{"material": "black", "nozzles": [[0, 99]], "head": 100, "substitute": "grey"}}]' > {2}
     cat) > {4})",
                               test_program("openfab_test_print_4").string(), path("w.fab.json"),
                               path("n.json"), path("err.txt"), path("s.ofr")));
    const Outcome streamed = run({"/bin/sh", path("go.sh")});
    ASSERT_EQ(streamed.exit_code, 0) << streamed.err << read_file(path("err.txt"));
    scratch_.write("n.json", "[]");
    const Voxels before = print_voxels({"--nozzles", path("n.json")});
    const Voxels after = read("s.ofr");
    const size_t slice = static_cast<size_t>(after.info.size.x) * after.info.size.y;
    EXPECT_TRUE(std::equal(after.codes.begin(),
                           after.codes.begin() + static_cast<std::ptrdiff_t>(slice),
                           before.codes.begin()));
    EXPECT_EQ(std::count(before.codes.begin(), before.codes.end(), kGrey), 0);
    const auto late = static_cast<std::ptrdiff_t>(slice) * (after.info.size.z - 30);
    EXPECT_GT(std::count(after.codes.begin() + late, after.codes.end(), kGrey), 1000);
    EXPECT_EQ(std::count(after.codes.begin() + late, after.codes.end(), kBlack), 0);
}

TEST_F(ProcessOption, ScaleIsThatOfThePlacement) {
    write_world("scaled.fab.json", R"(, "scale": 1.05)");
    scratch_.write("s.json", R"({"scale": 1.05})");
    const Voxels placed = print_voxels({}, "scaled.fab.json");
    const Voxels process = print_voxels({"--process", path("s.json")});
    EXPECT_EQ(placed.info.size, process.info.size);
    EXPECT_TRUE(placed.codes == process.codes);
    // Along each axis, about a point of build space.
    write_world("axes.fab.json", R"(, "scale": [1.1, 0.9, 1], "translate_mm": [-1, 1, 0])");
    write_world("there.fab.json", "");
    scratch_.write("s.json", R"({"scale": [1.1, 0.9, 1], "about_mm": [10, 10, 0]})");
    const Voxels axes = print_voxels({}, "axes.fab.json");
    const Voxels about = print_voxels({"--process", path("s.json")});
    EXPECT_TRUE(axes.codes == about.codes);
    EXPECT_NEAR(axes.info.origin_mm.x, about.info.origin_mm.x, 1e-9);
}

TEST_F(ProcessOption, CostIsToldInMoneyAndTime) {
    scratch_.write("c.json", R"({"cost": {"currency": "CHF", "price_ml": {"white": 2, "K": 3},
        "waste_ml_swath": {"*": 0.5}, "swath_mm": 2.5, "passes": 2, "seconds_pass": 3,
        "seconds_layer": 4}})");
    const Outcome done =
        print({"--process", path("c.json"), "--stats", path("s.json"), "-o", path("a.ofr")});
    ASSERT_EQ(done.exit_code, 0) << done.err;
    rapidjson::Document s;
    s.Parse(read_file(path("s.json")).c_str());
    ASSERT_TRUE(s.IsObject() && s.HasMember("cost"));
    const auto& cost = s["cost"];
    // A ball of 6 mm takes three swaths of 2.5 mm.
    const int64_t layers = s["slices"].GetInt64(), passes = 6 * layers;
    EXPECT_EQ(cost["passes"].GetInt64(), passes);
    EXPECT_DOUBLE_EQ(cost["seconds"].GetDouble(), static_cast<double>(layers * 4 + passes * 3));
    EXPECT_DOUBLE_EQ(s["print_seconds"].GetDouble(), cost["seconds"].GetDouble());
    double sum = 0;
    for (const auto& [name, price] : {std::pair("white", 2.0), std::pair("black", 3.0)}) {
        const auto& line = cost["by_material"][name];
        EXPECT_NEAR(line["ml"].GetDouble(), s["ml_by_material"][name].GetDouble(), 1e-5);
        EXPECT_DOUBLE_EQ(line["waste_ml"].GetDouble(), static_cast<double>(passes) * 0.5);
        const double money = price * (line["ml"].GetDouble() + line["waste_ml"].GetDouble());
        EXPECT_NEAR(line["money"].GetDouble(), money, 1e-4);
        sum += money;
    }
    EXPECT_FALSE(cost["by_material"]["grey"].HasMember("money"));
    EXPECT_DOUBLE_EQ(cost["by_material"]["grey"]["waste_ml"].GetDouble(), 0);
    EXPECT_NEAR(cost["money"].GetDouble(), sum, 1e-3);
    const Outcome estimate = print({"--process", path("c.json"), "--estimate"});
    EXPECT_EQ(estimate.exit_code, 0);
    EXPECT_THAT(estimate.err, HasSubstr("CHF; "));
}

TEST_F(ProcessOption, TroubleIsTold) {
    const auto error_of = [&](const std::string& text) {
        scratch_.write("p.json", text);
        const Outcome outcome = print({"--process", path("p.json"), "-o", path("a.ofr")});
        EXPECT_NE(outcome.exit_code, 0) << text;
        return outcome.err;
    };
    EXPECT_THAT(error_of(R"({"ded": []})"), testing::Says(messages::kDidYouMean, "dead"));
    EXPECT_THAT(
        error_of(R"({"dead": [{"material": "white", "substitute": "red", "nozzles": [1]}]})"),
        Says(process::messages::kSubstituteIs, "*", "red", process::messages::kNoMaterialOfPrint));
    EXPECT_THAT(error_of(R"({"dead": [{"material": "K", "substitute": "black", "nozzles": [1]}]})"),
                Says(process::messages::kDeadNozzlesTwice));
    EXPECT_THAT(error_of(R"({"dead": [
        {"material": "white", "substitute": "black", "nozzles": [[0, 3]], "head": 4},
        {"material": "black", "substitute": "white", "nozzles": [2], "head": 4}]})"),
                Says(process::messages::kSubstitutesInCircle));
    EXPECT_THAT(error_of(R"({"dead": [{"material": "K", "substitute": "grey", "nozzles": [9],
                             "head": 8}]})"),
                Says(process::messages::kNoSuchNozzle, 9, 8));
    EXPECT_THAT(error_of(R"({"scale": 3})"), HasSubstr("between 0.5 and 2"));
    scratch_.write("p.json",
                   R"({"dead": [{"material": "cyan", "substitute": "x", "nozzles": [1]}]})");
    // Names that no material has change nothing, which is told whatever else is said.
    const auto told = [&](const std::string& text) {
        scratch_.write("p.json", text);
        const Outcome outcome = print({"--process", path("p.json"), "-o", path("a.ofr"), "--voxel",
                                       "1mm", "--progress", "none"});
        EXPECT_EQ(outcome.exit_code, 0);
        return outcome.err;
    };
    EXPECT_THAT(told(R"({"dead": [{"material": "blakc", "substitute": "white", "nozzles": [1]}]})"),
                Says(process::messages::kDeadNozzlesIdle, "blakc", "did you mean `black`?"));
    EXPECT_THAT(told(R"({"bleed": {"pairs": [{"materials": ["wihte", "K"], "sigma_um": 60}]}})"),
                Says(process::messages::kBleedIdle, "wihte", "did you mean `white`?"));
    EXPECT_THAT(
        told(R"({"dead": [{"material": "black", "substitute": "white", "nozzles": [100000]}]})"),
        HasSubstr("dead nozzle 100000 of `black` changes nothing"));
    EXPECT_THAT(told(R"({"about_mm": [1, 2, 3]})"), Says(program::messages::kAboutWithoutScale));
    EXPECT_THAT(told(R"({"bleed": {"pairs": [{"materials": ["white", "black"], "sigma_um": 60},
                                             {"materials": ["black", "white"], "sigma_um": 30}]}})"),
                Says(process::messages::kBleedTwice, "black", "white"));
    EXPECT_THAT(told(R"({"bleed": {"pairs": [{"materials": ["white", "*"], "sigma_um": 60},
                                             {"materials": ["black", "*"], "sigma_um": 30}]}})"),
                Not(HasSubstr("twice")));
    const std::string both =
        told(R"({"bleed": {"pairs": [{"materials": ["cyan", "red"], "sigma_um": 60}]}})");
    EXPECT_THAT(both, Says(process::messages::kBleedIdle, "cyan", "*"));
    EXPECT_THAT(both, Says(process::messages::kBleedIdle, "red", "*"));
    EXPECT_THAT(told(R"({"cost": {"price_ml": {"wihte": 1, "black": 2, "grey": 3}}})"),
                Says(program::messages::kCostIdle, "price_ml", "`wihte`", "`white`"));
    EXPECT_THAT(told(R"({"cost": {"price_ml": {"cyan": 1, "*": 2}}})"), ::testing::IsEmpty());
    scratch_.write("p.json",
                   R"({"dead": [{"material": "cyan", "substitute": "x", "nozzles": [1]}]})");
    // Neither file is overwritten.
    EXPECT_NE(print({"--process", path("p.json"), "--stats", path("p.json")}).exit_code, 0);
}

}  // namespace
}  // namespace openfab::testing

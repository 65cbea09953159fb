// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab coupon`: prints for every printer, reads right, and its finest details are single voxels.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <sstream>

#include "backends/formats/formats.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tests/unit/backends/sample_print.h"
#include "tools/openfab/messages.h"
#include "world/printer.h"

namespace openfab::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;
using Codes = std::function<int(int x, int y, int z)>;

constexpr double kX = 44, kY = 26, kZ = 4.2;

/// Whether at the places of an F's ink, and there alone, there is some; `at` is of mm to the right and up.
bool is_letter_f(double across, double up, double height,
                 const std::function<bool(double, double)>& at) {
    constexpr std::array<std::string_view, 7> kRows{"#####", "#....", "#....", "####.",
                                                    "#....", "#....", "#...."};
    const double cell = height / 7;
    for (int row = 0; row < 7; ++row) {
        for (int column = 0; column < 5; ++column) {
            const bool ink = kRows[static_cast<size_t>(row)][static_cast<size_t>(column)] == '#';
            if (at(across + (column - 2) * cell, up + (3 - row) * cell) != ink) return false;
        }
    }
    return true;
}

/// Runs of `code` along a row, their lengths in order.
std::vector<int> runs(int from, int to, const std::function<bool(int)>& is) {
    std::vector<int> out;
    for (int i = from, length = 0; i <= to; ++i) {
        if (i < to && is(i)) {
            ++length;
        } else if (length > 0) {
            out.push_back(length);
            length = 0;
        }
    }
    return out;
}

class Coupon : public ::testing::Test {
  protected:
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    Outcome openfab(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), program("openfab"));
        return run(arguments, {{{"OPENFAB_CACHE", path("cache")}}, {}, {}});
    }
    Outcome coupon(const std::string& printer, const std::string& folder,
                   std::vector<std::string> more = {}) const {
        more.insert(more.begin(), {"coupon", "--printer", printer, "-o", path(folder)});
        return openfab(more);
    }
    /// Voxels of an array, by their place.
    Codes codes_of(const std::string& file, int* across, int* along, int* high) {
        const std::string text = read_file(file);
        const size_t shape = text.find("'shape': (");
        std::istringstream numbers(text.substr(shape + 10, 60));
        char comma = 0;
        numbers >> *high >> comma >> *along >> comma >> *across;
        const size_t begin = text.find('\n') + 1;
        EXPECT_EQ(text.size() - begin, static_cast<size_t>(*high) * *along * *across);
        return [text, begin, x = *across, y = *along](int i, int k, int n) {
            return static_cast<int>(
                static_cast<uint8_t>(text[begin + (static_cast<size_t>(n) * y + k) * x + i]));
        };
    }

    ScratchFolder scratch_;
};

TEST_F(Coupon, PrintsForEveryPrinterInItsFormat) {
    const std::map<std::string, std::vector<std::string>> unknown{
        {"j55", {"--dpi", "300x300"}},
        {"ember", {"--layer", "50um"}},
        {"inkjet_kit", {"--dpi", "360x720", "--layer", "30um"}}};
    for (const std::string& name : world::printer_names()) {
        SCOPED_TRACE(name);
        const world::Printer printer = *world::load_printer(name);
        std::vector<std::string> more{"--draft", "4"};
        if (const auto found = unknown.find(name); found != unknown.end()) {
            const Outcome refused = coupon(name, name);
            EXPECT_EQ(refused.exit_code, 2);
            EXPECT_THAT(refused.err, Says(tools::messages::kCouponNeedsPitch, name));
            EXPECT_FALSE(fs::exists(path(name)));
            more.insert(more.end(), found->second.begin(), found->second.end());
        }
        const Outcome made = coupon(name, name, more);
        ASSERT_EQ(made.exit_code, 0) << made.err;
        const bool inks_left = printer.inks.size() > static_cast<size_t>(printer.max_materials);
        EXPECT_EQ(made.err.find("--material") != std::string::npos,
                  inks_left || printer.inks.empty());
        const backends::Format* format = backends::find_format(printer.native_format);
        std::set<std::string> extensions;
        for (const auto& file : fs::recursive_directory_iterator(path(name)))
            extensions.insert(file.path().extension().string());
        EXPECT_TRUE(extensions.contains(std::string(format->extension)));
        EXPECT_EQ(openfab({"print", path(name) + "/coupon.fab.json", "--estimate", "--draft", "4",
                           "--dpi", "300x300", "--layer", "30um"})
                      .exit_code,
                  0);
        fs::remove_all(path(name));
    }
}

TEST_F(Coupon, ReadsRightInSlices) {
    const Outcome made = coupon("generic", "generic", {"--format", "png"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
    EXPECT_THAT(made.err, Not(HasSubstr("without material")));
    std::vector<ReadPng> slices;
    for (int z = 0; z < 42; ++z)
        slices.push_back(read_png(path("generic") + fmt::format("/slices/slice_{:04}.png", z + 1)));
    ASSERT_EQ(slices[0].width, 440);
    ASSERT_EQ(slices[0].height, 260);
    // As HANDOFF.txt and the coupon's page say: x to the right, y up, the first slice lowest.
    const auto is_void = [&](double x, double y, double z) {
        const ReadPng& slice = slices[static_cast<size_t>(z / 0.1)];
        return slice.at(static_cast<int>(x / 0.1), 259 - static_cast<int>(y / 0.1))[3] == 0;
    };
    EXPECT_TRUE(
        is_letter_f(6.7, 17.6, 5, [&](double x, double y) { return is_void(x, y, kZ - 0.15); }));
    EXPECT_TRUE(is_letter_f(4, 2.9, 2, [&](double x, double z) { return is_void(x, 0.15, z); }));
    EXPECT_TRUE(
        is_letter_f(4, 2.9, 2, [&](double y, double z) { return is_void(kX - 0.15, y, z); }));
    EXPECT_FALSE(is_letter_f(
        6.7, 17.6, 5, [&](double x, double y) { return is_void(2 * 6.7 - x, y, kZ - 0.15); }));
}

TEST_F(Coupon, ReadsRightInPictures) {
    ASSERT_EQ(coupon("generic", "generic").exit_code, 0);
    const std::string world = path("generic") + "/coupon.fab.json";
    ASSERT_EQ(openfab({"print", world, "-o", path("again.ofr"), "--preview",
                       path("preview.png") + ",view=top"})
                  .exit_code,
              0);
    const Outcome rendered =
        openfab({"render", path("generic") + "/coupon.ofr", "-o", path("render.png"), "--view",
                 "top", "--size", "330x195", "--samples", "4"});
    ASSERT_EQ(rendered.exit_code, 0) << rendered.err;
    for (const char* name : {"preview.png", "render.png"}) {
        SCOPED_TRACE(name);
        const ReadPng picture = read_png(path(name));
        // The plate fills the width of the one, and of the other all but a margin.
        const double margin = name == std::string("render.png") ? 0.041 : 0;
        const double side = picture.width * (1 - 2 * margin) / kX;
        const auto dark = [&](double x, double y) {
            const int column = static_cast<int>(picture.width / 2.0 + (x - kX / 2) * side);
            const int row = static_cast<int>(picture.height / 2.0 - (y - kY / 2) * side);
            int sum = 0;  // rendered pixels are noisy
            for (int i = -1; i <= 1; ++i)
                for (int k = -1; k <= 1; ++k)
                    sum += picture.at(column + i, row + k)[1];
            return sum < 9 * 92;
        };
        EXPECT_TRUE(is_letter_f(6.7, 17.6, 5, dark));
    }
}

TEST_F(Coupon, FinestDetailsAreOneVoxelOfEachResin) {
    const Outcome made = coupon("j750", "j750", {"--format", "npy"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
    int across = 0, along = 0, high = 0;
    const Codes code = codes_of(path("j750") + "/coupon.npy", &across, &along, &high);
    const double px = 25.4 / 600, py = 25.4 / 300;
    ASSERT_EQ(across, static_cast<int>(std::ceil(kX / px)));
    const auto x_of = [&](double mm) { return static_cast<int>(mm / px); };
    const auto y_of = [&](double mm) { return static_cast<int>(mm / py); };
    const int top = high - 2;
    const std::vector<int> widths{1, 2, 3};
    std::set<int> resins;
    for (int row = 0; row < 6; ++row) {
        SCOPED_TRACE(row);
        const int y = y_of(24.9 - row * 2.1 - 0.9);
        const int resin = code(x_of(18), y_of(24.9 - row * 2.1 - 0.3), top);
        resins.insert(resin);
        const auto is = [&](int x) { return code(x, y, top) == resin; };
        EXPECT_EQ(runs(x_of(19.5), x_of(22.3), is), widths);
        const std::vector<int> gaps = runs(x_of(22.7), x_of(25.4), [&](int x) { return !is(x); });
        EXPECT_EQ(std::vector<int>(gaps.begin(), gaps.begin() + 3), widths);
        const int x = x_of(27.5), low = y_of(23.15 - row * 2.1);
        const auto is_along = [&](int k) { return code(x, k, top) == resin; };
        EXPECT_EQ(runs(low, low + y_of(1.7), is_along), widths);
        const auto is_dot = [&](int i) {  // in any row of this height
            for (int k = y - 3; k <= y + 3; ++k)
                if (code(i, k, top) == resin) return true;
            return false;
        };
        EXPECT_EQ(runs(x_of(32.3), x_of(34.8), is_dot), widths);
    }
    EXPECT_EQ(resins.size(), 6U);
    // Gaps and walls of the plate.
    const auto is_void = [&](int x, double y) { return code(x, y_of(y), top) == 0; };
    const std::vector<int> all{1, 2, 3, 4, 6, 8};
    EXPECT_EQ(runs(x_of(36.5), x_of(42.9), [&](int x) { return is_void(x, 24); }), all);
    EXPECT_EQ(runs(x_of(36.5), x_of(42.9), [&](int x) { return !is_void(x, 20.5); }), all);
    // Below 5 ml, and every pair.
    size_t solid = 0;
    std::set<std::set<int>> pairs;
    for (int z = 0; z < high; ++z)
        for (int y = 0; y < along; ++y)
            for (int i = 0; i < across; ++i)
                solid += code(i, y, z) != 0 ? 1U : 0U;
    EXPECT_LT(static_cast<double>(solid) * px * py * 0.027, 5000);
    for (int row = 0; row < 6; ++row) {
        for (int column = 0; column < 6; ++column) {
            std::set<int> found;
            for (double dy = 0.2; dy < 1.4; dy += py)
                for (double dx = 0.2; dx < 1.4; dx += px)
                    found.insert(
                        code(x_of(9 + column * 1.6 + dx), y_of(10.8 - row * 1.6 - dy), top));
            pairs.insert(found);
        }
    }
    EXPECT_EQ(pairs.size(), 21U);  // six alone, fifteen pairs
}

TEST_F(Coupon, TakesAProfileOfAFile) {
    scratch_.write("lab.printer.json",
                   R"({"name": "lab", "dpi": [127, 254], "layer_um": 100, "max_materials": 2})");
    const Outcome made = coupon(path("lab.printer.json"), "lab");
    ASSERT_EQ(made.exit_code, 0) << made.err;
    EXPECT_TRUE(fs::exists(path("lab") + "/coupon.ofr"));
    EXPECT_EQ(openfab({"print", path("lab") + "/coupon.fab.json", "--draft", "4", "-o",
                       path("again.ofr")})
                  .exit_code,
              0);
}

TEST_F(Coupon, SaysWhatIsLeftOut) {
    const Outcome one = coupon("ember", "one", {"--layer", "100um", "--draft", "2"});
    EXPECT_THAT(one.err, Says(tools::messages::kCouponOneMaterial));
    const Outcome meshes =
        coupon("connex3_260", "meshes",
               {"--format", "stl", "--draft", "2", "--material", "A", "--material", "B"});
    EXPECT_EQ(meshes.exit_code, 0) << meshes.err;
    EXPECT_THAT(meshes.err, Says(tools::messages::kCouponNoPairs, "stl"));
    EXPECT_THAT(meshes.err, Says(tools::messages::kCouponMade, "*", "A, B"));
    EXPECT_THAT(coupon("connex3_260", "again", {"--draft", "4"}).err,
                Says(tools::messages::kCouponLeavesInks, "VeroCyan*", "3"));
}

TEST_F(Coupon, RefusesWhatItCannotPrint) {
    const Outcome many =
        coupon("connex500", "many", {"--material", "A", "--material", "B", "--material", "C"});
    EXPECT_EQ(many.exit_code, 2);
    EXPECT_THAT(many.err, Says(tools::messages::kCouponMaterials, "*", "connex500", "2", "3"));
    EXPECT_THAT(coupon("j750", "twice", {"--material", "A", "--material", "A"}).err,
                Says(tools::messages::kCouponMaterialTwice, "A"));
    EXPECT_THAT(coupon("generic", "coarse", {"--voxel", "0.3mm"}).err,
                Says(tools::messages::kCouponTooCoarse, "*", "*", "*", "*"));
    fs::create_directories(path("there"));
    EXPECT_THAT(coupon("generic", "there").err, Says(tools::messages::kNameExists, "*"));
    EXPECT_EQ(coupon("generic", "format", {"--format", "nothing"}).exit_code, 2);
    for (const char* name : {"many", "twice", "coarse", "format"})
        EXPECT_FALSE(fs::exists(path(name))) << name;
}

}  // namespace
}  // namespace openfab::testing

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `--fractions`: the mixtures that the dither gets, voxel by voxel, against what it made of them.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "base/vec.h"
#include "program/messages.h"
#include "tests/programs/print/simple_world.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;

constexpr size_t kHeaderBytes = 128;

class Fractions : public ::testing::Test {
  protected:
    Fractions() {
        scratch_.write("f.fl", "fablet Skin {}\n");
        scratch_.write("w.fab.json", SimpleWorld{"Skin", R"({"sphere": 6})"}.text());
        scratch_.write("p.printer.json", R"({"name": "p", "pitch_mm": [0.2, 0.2, 0.2]})");
    }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    Outcome print(const std::vector<std::string>& more, const RunOptions& options = {}) {
        std::vector<std::string> argv{test_program("openfab_test_print_4"), path("w.fab.json"),
                                      "--printer", path("p.printer.json")};
        argv.insert(argv.end(), more.begin(), more.end());
        return run(argv, options);
    }
    std::string fractions(const std::vector<std::string>& more) {
        std::vector<std::string> all{"--fractions", path("f.npy")};
        all.insert(all.end(), more.begin(), more.end());
        const Outcome outcome = print(all);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return read_file(path("f.npy"));
    }

    ScratchFolder scratch_;
};

TEST_F(Fractions, AreWhatTheDitherChoosesFrom) {
    const std::string file = fractions({"-o", path("codes.npy")});
    const std::string codes = read_file(path("codes.npy")).substr(kHeaderBytes);
    EXPECT_THAT(file.substr(0, kHeaderBytes), HasSubstr("{'descr': '<f4', 'fortran_order': False"));
    ASSERT_EQ(file.size(), kHeaderBytes + codes.size() * 2 * sizeof(float));
    std::vector<float> values(codes.size() * 2);
    std::memcpy(values.data(), file.data() + kHeaderBytes, values.size() * sizeof(float));
    int64_t mixed = 0, pure = 0, empty = 0;
    double asked = 0, printed = 0;
    for (size_t i = 0; i < codes.size(); ++i) {
        const float white = values[2 * i], black = values[2 * i + 1];
        ASSERT_TRUE(white >= 0 && black >= 0 && white + black <= 1.0001f) << white << ' ' << black;
        const auto code = static_cast<unsigned char>(codes[i]);
        if (code != 0) {
            ASSERT_GT(code == 1 ? white : black, 0) << i;
        }
        const bool is_mixed = white + black > 0 && white < 1 && black < 1;
        if (!is_mixed) {
            ASSERT_EQ(code, white == 1 ? 1 : black == 1 ? 2 : 0) << i;
        }
        (is_mixed ? mixed : code != 0 ? pure : empty)++;
        asked += white;
        printed += code == 1 ? 1 : 0;
    }
    EXPECT_GT(mixed, 1000);
    EXPECT_GT(pure + empty, 1000);
    EXPECT_NEAR(printed / asked, 1, 0.02);
    EXPECT_THAT(read_file(path("f.npy.json")), HasSubstr("\"complete\": true"));
}

TEST_F(Fractions, DependOnNothingButTheWorld) {
    const std::string expected = fractions({"--threads", "1"});
    EXPECT_TRUE(fractions({"--threads", "3", "--no-cull"}) == expected);
    EXPECT_TRUE(fractions({"--threads", "2", "--dither", "majority", "--isa", "sse41"}) ==
                expected);
    // A range of slices is that part of the whole.
    const std::string some = fractions({"--slices", "5:19"}).substr(kHeaderBytes);
    const size_t slice = some.size() / 14;
    EXPECT_TRUE(expected.substr(kHeaderBytes + 5 * slice, some.size()) == some);
}

/// The numbers that follow a text.
std::vector<double> numbers_after(const std::string& text, const std::string& before,
                                  size_t count) {
    std::vector<double> out;
    size_t at = text.find(before) + before.size();
    for (size_t i = 0; i < count; ++i) {
        at = text.find_first_of("-0123456789", at);
        char* end = nullptr;
        out.push_back(std::strtod(text.c_str() + at, &end));
        at = static_cast<size_t>(end - text.c_str());
    }
    return out;
}

TEST_F(Fractions, AProbeIsTheVoxelOfTheWholePrint) {
    const std::string file = fractions({});
    const std::string header = file.substr(0, kHeaderBytes);
    const std::vector<double> shape = numbers_after(header, "'shape': (", 3);
    const std::vector<double> origin =
        numbers_after(read_file(path("f.npy.json")), "\"origin_mm\"", 3);
    const auto at = [&](const Vec3i& voxel) {
        return static_cast<size_t>((voxel.z * shape[1] + voxel.y) * shape[2] + voxel.x);
    };
    std::vector<std::array<float, 2>> values((file.size() - kHeaderBytes) / (2 * sizeof(float)));
    std::memcpy(values.data(), file.data() + kHeaderBytes, file.size() - kHeaderBytes);
    // A corner, the middle, and mixtures from all over.
    std::vector<Vec3i> voxels{{0, 0, 0}, {15, 15, 15}};
    for (int32_t z = 2; z < 30; z += 7) {
        for (int32_t x = 0; x < 30; ++x) {
            const auto [white, black] = values[at({x, 15, z})];
            if (white == 0 || black == 0) continue;
            voxels.push_back({x, 15, z});
            break;
        }
    }
    ASSERT_GE(voxels.size(), 5u);
    for (const Vec3i& voxel : voxels) {
        const std::string point =
            fmt::format("{:.17g},{:.17g},{:.17g}", origin[0] + 0.2 * (voxel.x + 0.5),
                        origin[1] + 0.2 * (voxel.y + 0.5), origin[2] + 0.2 * (voxel.z + 0.5));
        const Outcome probed = print({"--probe", point});
        ASSERT_EQ(probed.exit_code, 0) << probed.err;
        const auto [white, black] = values[at(voxel)];
        EXPECT_EQ(numbers_after(probed.out, "\"white\":", 1)[0], double{white}) << probed.out;
        EXPECT_EQ(numbers_after(probed.out, "\"black\":", 1)[0], double{black}) << probed.out;
    }
    const Outcome wrong = print({"--probe", "1,2"});
    EXPECT_EQ(wrong.exit_code, 2);
    EXPECT_THAT(wrong.err, Says(program::messages::kNotThreeNumbers));
}

/// The fractions of a file: [z][y][x][material].
struct Array {
    std::array<int32_t, 3> shape{};  ///< z, y, x
    std::array<double, 3> origin_mm{};
    std::vector<std::array<float, 2>> values;

    Array(const std::string& file, const std::string& json) {
        const std::vector<double> sizes =
            numbers_after(file.substr(0, kHeaderBytes), "'shape': (", 3);
        const std::vector<double> origin = numbers_after(json, "\"origin_mm\"", 3);
        for (size_t a = 0; a < 3; ++a)
            shape[a] = static_cast<int32_t>(sizes[a]), origin_mm[a] = origin[a];
        values.resize((file.size() - kHeaderBytes) / sizeof(values[0]));
        std::memcpy(values.data(), file.data() + kHeaderBytes, file.size() - kHeaderBytes);
    }
    /// Void where there is no voxel.
    std::array<float, 2> at(int32_t z, int32_t y, int32_t x) const {
        const bool in = z >= 0 && z < shape[0] && y >= 0 && y < shape[1] && x >= 0 && x < shape[2];
        return in ? values[static_cast<size_t>((z * shape[1] + y) * shape[2] + x)]
                  : std::array<float, 2>{};
    }
};

TEST_F(Fractions, SupersampledAreTheMeansOfThoseOfAFinerPrint) {
    const std::string fine_file = fractions({});
    const Array fine(fine_file, read_file(path("f.npy.json")));
    for (const int32_t times : {2, 3, 8}) {
        // The pitch is 0.2 mm times the draft.
        const std::string n = std::to_string(times);
        const std::vector<std::string> options{"--draft", n, "--fractions-supersample", n};
        const std::string file = fractions(options);
        const std::string json = read_file(path("f.npy.json"));
        EXPECT_THAT(json, HasSubstr(fmt::format("\"supersampling\": \"{}\"", n)));
        EXPECT_THAT(json, HasSubstr("\"complete\": true"));
        const Array coarse(file, json);
        // The printer's own pitch is that of the fine print, which a coarser one averages by itself.
        EXPECT_TRUE(fractions({"--draft", n}) == file) << times;
        std::array<int32_t, 3> shift{};  // fine voxels, x, y, z
        for (size_t a = 0; a < 3; ++a) {
            shift[a] =
                static_cast<int32_t>(std::lround((coarse.origin_mm[a] - fine.origin_mm[a]) / 0.2));
        }
        int64_t partly = 0;
        for (int32_t z = 0; z < coarse.shape[0]; ++z) {
            for (int32_t y = 0; y < coarse.shape[1]; ++y) {
                for (int32_t x = 0; x < coarse.shape[2]; ++x) {
                    std::array<int64_t, 2> sums{};
                    for (int32_t k = 0; k < times * times * times; ++k) {
                        const auto of = fine.at(z * times + k / (times * times) + shift[2],
                                                y * times + k / times % times + shift[1],
                                                x * times + k % times + shift[0]);
                        for (size_t m = 0; m < 2; ++m)
                            sums[m] += std::lround(of[m] * 65535.0);
                    }
                    const double whole = 65535.0 * times * times * times;
                    for (size_t m = 0; m < 2; ++m) {
                        ASSERT_EQ(coarse.at(z, y, x)[m],
                                  static_cast<float>(static_cast<double>(sums[m]) / whole))
                            << times << " at " << x << ' ' << y << ' ' << z;
                        partly += sums[m] > 0 && sums[m] < static_cast<int64_t>(whole) ? 1 : 0;
                    }
                }
            }
        }
        EXPECT_GT(partly, 20);
        // Whatever the threads; and a range of slices is that part of the whole.
        std::vector<std::string> more = options;
        more.insert(more.end(), {"--threads", "3", "--no-cull", "-o", path("codes.ofr")});
        EXPECT_TRUE(fractions(more) == file);
        more = options;
        more.insert(more.end(), {"--slices", "1:3"});
        const std::string some = fractions(more).substr(kHeaderBytes);
        EXPECT_TRUE(file.substr(kHeaderBytes + some.size() / 2, some.size()) == some);
    }
}

/// What was not printed would be void in it.
TEST_F(Fractions, AreNotThereBeforeTheyAreWhole) {
    const std::string whole = fractions({"--voxel", "0.2mm"});
    const std::string note = read_file(path("f.npy.json"));
    for (const int signal : {SIGTERM, SIGKILL}) {
        RunOptions ended;
        ended.signal = signal;
        ended.interrupt_when = [](int, const Outcome& so_far) {
            return so_far.err.find("slices_done") != std::string::npos;
        };
        const Outcome outcome = print({"--fractions", path("cut.npy"), "--voxel", "0.03mm",
                                       "--progress", "json", "--threads", "1"},
                                      ended);
        EXPECT_NE(outcome.exit_code, 0);
        EXPECT_FALSE(std::filesystem::exists(path("cut.npy")));
        EXPECT_FALSE(std::filesystem::exists(path("cut.npy.json")));
        EXPECT_EQ(std::filesystem::exists(path("cut.npy.part")), signal == SIGKILL);
    }
    // One that is there stays.
    RunOptions full;
    full.largest_file_bytes = static_cast<int64_t>(whole.size()) / 2;
    EXPECT_EQ(print({"--fractions", path("f.npy"), "--voxel", "0.2mm"}, full).exit_code, 3);
    EXPECT_TRUE(read_file(path("f.npy")) == whole);
    EXPECT_EQ(read_file(path("f.npy.json")), note);
}

TEST_F(Fractions, AreVerified) {
    const std::string whole = fractions({"--voxel", "0.2mm", "-o", path("codes.npy")});
    for (const char* name : {"f.npy", "codes.npy"}) {
        const std::string bytes = read_file(path(name));
        const auto exit_code = [&] {
            return run({program("openfab"), "verify", path(name)}).exit_code;
        };
        EXPECT_EQ(exit_code(), 0);
        std::string damaged = bytes;
        char& middle = damaged[kHeaderBytes + (bytes.size() - kHeaderBytes) / 2 / 8 * 8];
        middle = static_cast<char>(middle ^ 1);
        scratch_.write(name, damaged);
        EXPECT_EQ(exit_code(), 1) << name;
        scratch_.write(name, bytes.substr(0, bytes.size() - 4));
        EXPECT_EQ(exit_code(), 1) << name;
        scratch_.write(name, bytes);
        EXPECT_EQ(exit_code(), 0);
        std::filesystem::remove(path(name) + ".json");
        EXPECT_EQ(exit_code(), 1) << name;
    }
}

TEST_F(Fractions, TroubleIsTold) {
    RunOptions small;
    small.largest_file_bytes = 100'000;
    const Outcome full = print({"--fractions", path("f.npy")}, small);
    EXPECT_EQ(full.exit_code, 3);
    EXPECT_THAT(full.err, HasSubstr("f.npy"));
    EXPECT_EQ(print({"--fractions", path("f.npy"), "-o", path("f.npy")}).exit_code, 1);
    EXPECT_EQ(print({"--fractions", path("f.npy"), "-o", path("a.ofr"), "--resume"}).exit_code, 2);
    const Outcome alone = print({"--fractions-supersample", "4", "-o", path("a.ofr")});
    EXPECT_EQ(alone.exit_code, 2);
    EXPECT_THAT(alone.err, Says(program::messages::kAboutFractions, "--fractions-supersample"));
    EXPECT_EQ(print({"--fractions", path("f.npy"), "--fractions-supersample", "33"}).exit_code, 2);
    const Outcome both = print(
        {"--fractions", path("f.npy"), "--fractions-supersample", "4", "--sampling", "centre"});
    EXPECT_EQ(both.exit_code, 2);
    EXPECT_THAT(both.err, Says(program::messages::kCentreAndSupersample));
    EXPECT_THAT(print({"--sampling", "volume", "-o", path("a.ofr")}).err,
                Says(program::messages::kAboutFractions, "--sampling"));
}

}  // namespace
}  // namespace openfab::testing

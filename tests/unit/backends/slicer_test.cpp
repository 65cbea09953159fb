// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What a slicer makes of the files for printers of filament.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "backends/boundary/mesh_sink.h"
#include "tests/support/process/process.h"
#include "tests/unit/backends/sample_print.h"

namespace openfab::testing {
namespace {

/// Two nozzles, layers as high as the voxels; tops and bottoms of several layers, as usual.
constexpr const char* kSettings =
    "nozzle_diameter = 0.4,0.4\nfilament_diameter = 1.75,1.75\nfilament_colour = #2040c0;#f0c020\n"
    "temperature = 210,210\nfirst_layer_temperature = 210,210\nlayer_height = 0.2\n"
    "first_layer_height = 0.2\nskirts = 0\nsingle_extruder_multi_material = 1\nwipe_tower = 0\n"
    "toolchange_gcode = T[next_extruder]\n";

/// Lengths that are printed in each layer by each filament, in mm, and the box of each.
struct Sliced {
    std::map<int, std::map<int, double>> mm;  ///< by layer from 0, by filament from 0
    double lowest_x = 1e9, highest_x = -1e9;
};

Sliced read_gcode(const std::filesystem::path& file) {
    Sliced out;
    std::ifstream in(file);
    double x = 0, y = 0, z = 0;
    int tool = 0;
    const auto number = [](const std::string& line, char of, double otherwise) {
        const size_t at = line.find(fmt::format(" {}", of));
        return at == std::string::npos ? otherwise : std::stod(line.substr(at + 2));
    };
    for (std::string line; std::getline(in, line);) {
        if (line.size() > 1 && line[0] == 'T' && line[1] >= '0' && line[1] <= '9')
            tool = line[1] - '0';
        if (line.rfind("G1 ", 0) != 0) continue;
        line = line.substr(0, line.find(';'));
        const double to_x = number(line, 'X', x), to_y = number(line, 'Y', y);
        z = number(line, 'Z', z);
        const bool moves = to_x != x || to_y != y;
        if (moves && number(line, 'E', 0) > 0) {
            out.mm[static_cast<int>(std::lround(z / 0.2)) - 1][tool] +=
                std::hypot(to_x - x, to_y - y);
            out.lowest_x = std::min({out.lowest_x, x, to_x});
            out.highest_x = std::max({out.highest_x, x, to_x});
        }
        x = to_x, y = to_y;
    }
    return out;
}

/// Writes a print for filaments, slices it, and expects each layer in the filament of its slice alone.
void expect_filaments(SamplePrint* print, int32_t (*filament_of)(int32_t),
                      const std::string& settings, bool newer) {
    const ScratchFolder scratch;
    boundary::MeshSink sink(boundary::make_filament_writer(scratch / "part.3mf"));
    ASSERT_TRUE(print->send(&sink));
    if (newer) {
        // Versions from 2.6 on take the paint of other slicers where there is none of their own.
        const std::string change =
            "cd '{}' && mkdir x && cd x && unzip -q ../part.3mf && sed -i "
            "'/mmu_segmentation/!s/paint_color/slic3rpe:mmu_segmentation/' 3D/3dmodel.model && rm "
            "../part.3mf && zip -qr ../part.3mf .";
        ASSERT_EQ(std::system(fmt::format(fmt::runtime(change), scratch.path().string()).c_str()),
                  0);
    }
    scratch.write("two.ini", kSettings + settings);
    const std::string command =
        fmt::format("cd '{}' && prusa-slicer --load two.ini -g -o part.gcode part.3mf > log 2>&1",
                    scratch.path().string());
    ASSERT_EQ(std::system(command.c_str()), 0) << read_file(scratch / "log");
    const Sliced sliced = read_gcode(scratch / "part.gcode");
    EXPECT_EQ(sliced.mm.size(), static_cast<size_t>(print->info.size.z));
    for (const auto& [layer, mm] : sliced.mm) {
        const double right = mm.count(filament_of(layer)) != 0 ? mm.at(filament_of(layer)) : 0;
        EXPECT_GT(right, 2) << layer;
        EXPECT_EQ(mm.size(), 1U) << "layer " << layer << " has threads of the other filament";
    }
    // They stand where the voxels are: the width less a thread's.
    int32_t first = print->info.size.x, last = 0;
    for (int32_t z = 0; z < print->info.size.z; ++z) {
        for (int32_t y = 0; y < print->info.size.y; ++y) {
            for (int32_t x = 0; x < print->info.size.x; ++x) {
                if (print->at(x, y, z) == 0) continue;
                first = std::min(first, x), last = std::max(last, x);
            }
        }
    }
    EXPECT_NEAR(sliced.highest_x - sliced.lowest_x, 0.2 * (last - first + 1) - 0.45, 0.1);
}

bool has_slicer() {
    return std::system("command -v prusa-slicer unzip zip > /dev/null 2>&1") == 0;
}

SamplePrint sample(int32_t height) {
    SamplePrint print = make_sample({60, 50, height}, 8);
    print.info.pitch_mm = {0.2, 0.2, 0.2};
    print.info.origin_mm = {-5, -4, -1};
    print.info.materials.resize(2);
    return print;
}

int32_t by_threes_and_fives(int32_t z) {
    return (z / 3 + z / 5) % 2;
}

int32_t halves(int32_t z) {
    return z < 12 ? 0 : 1;
}

/// Steps up, steps down (overhangs), a ball, and two that stand apart, of which one begins above the bed: each slice of
/// one filament. Treads are what slicers carry into layers below.
TEST(Slicer, PrintsEachLayerWithTheFilamentOfItsVoxels) {
    if (!has_slicer())
        GTEST_SKIP() << "there is no prusa-slicer, zip or unzip; packages of these names have them";
    using Within = bool (*)(int32_t x, int32_t y, int32_t z);
    const Within kShapes[] = {
        [](int32_t x, int32_t y, int32_t z) {
            return std::min({x, y, 59 - x, 49 - y}) >= z;
        },
        [](int32_t x, int32_t y, int32_t z) {
            return std::min({x, y, 59 - x, 49 - y}) >= 12 - z / 2;
        },
        [](int32_t x, int32_t y, int32_t z) {
            const int32_t dx = 2 * x - 59, dy = 2 * y - 49, dz = 2 * z - 23;
            return dx * dx + dy * dy + 3 * dz * dz < 46 * 46;
        },
        [](int32_t x, int32_t y, int32_t z) {
            const bool post = x < 20 && y < 20, bridge = z >= 12 && y < 20;
            return post || (x >= 40 && y < 20) || bridge;
        },
    };
    for (size_t shape = 0; shape < std::size(kShapes); ++shape) {
        const Within within = kShapes[shape];
        for (const bool newer : {false, true}) {
            SCOPED_TRACE(fmt::format("shape {}, {}", shape, newer ? "newer" : "as it is"));
            for (const auto filament_of : {by_threes_and_fives, halves}) {
                SamplePrint print = sample(24);
                for (int32_t z = 0; z < print.info.size.z; ++z) {
                    for (int32_t y = 0; y < print.info.size.y; ++y) {
                        for (int32_t x = 0; x < print.info.size.x; ++x)
                            print.at(x, y, z) =
                                static_cast<uint8_t>(within(x, y, z) ? 1 + filament_of(z) : 0);
                    }
                }
                expect_filaments(&print, filament_of, "", newer);
            }
        }
    }
}

}  // namespace
}  // namespace openfab::testing

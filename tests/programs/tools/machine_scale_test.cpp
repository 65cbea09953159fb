// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// A machine's scale of what grows and of what programs make: the voxels are those of beams that are the same
// solid, of which scales are known from elsewhere (print_field_test).

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

#include "backends/ofr/ofr_reader.h"
#include "runtime/part/messages.h"
#include "tests/programs/tools/openfab_print.h"
#include "tests/support/says/says.h"

namespace openfab::testing {
namespace {

constexpr const char* kGrown =
    R"(struct N { float3 end[2]; float radius; int children; float reach; };

fablet F {
    @uniform { Material skin, core; }
    @Grow(@varying { GrowAttributes attr, N parent })
    {
        N s;
        s.end[0] = attr.level == 0 ? float3(-3, 0, 0) : float3(0, -2, 1);
        s.end[1] = attr.level == 0 ? float3(3, 1, 2) : float3(0, 3, 1);
        s.radius = 1;
        s.children = attr.level == 0 ? 1 : 0;
        s.reach = 9;
        return s;
    }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        mc.Set(distance(attr.voxelCenter) < -0.45 && attr.voxelCenter.z < 1.6 ? core : skin, 1);
        return mc;
    }
}
)";

class MachineScale : public OpenfabPrint {
  protected:
    MachineScale() {
        scratch_.write("f.fl", kGrown);
        scratch_.write("t.txt",
                       "node -3 0 0 1\nnode 3 1 2 1\nnode 0 -2 1 1\nnode 0 3 1 1\n"
                       "strut 0 1\nstrut 2 3\n");
        scratch_.write(
            "p.sh",
            "while read line; do echo 'beam -3 0 0 3 1 2 1 1'; echo 'beam 0 -2 1 0 3 1 1 1'; "
            "echo done; done\n");
    }
    void write_worlds(const std::string& placement) {
        const std::string box = R"("box_mm": [[-9, -9, -9], [9, 9, 9]])";
        write("beams", R"({"beams": "t.txt"})", placement);
        write("grown", R"({"grow": "f", )" + box + "}", placement);
        write("program", R"({"program": ["sh", "p.sh"], )" + box + "}", placement);
    }
    /// Codes of the voxels that have a material, by their place in multiples of the pitch: grids are as large as
    /// what is known of the geometry beforehand.
    using Voxels = std::map<std::array<int64_t, 3>, uint8_t>;
    Voxels print_voxels(const std::string& world, const std::string& process) {
        scratch_.write("p.json", process);
        const Outcome outcome = print({path(world + ".fab.json"), "-o", path("a.ofr"), "--voxel",
                                       "0.2mm", "--process", path("p.json"), "--allow-programs"});
        EXPECT_EQ(outcome.exit_code, 0) << world << ": " << outcome.err;
        Voxels voxels;
        auto reader = ofr::OfrReader::open(path("a.ofr"));
        if (!reader) return voxels;
        const pipeline::PrintInfo info = (*reader)->info();
        const auto place = [&](int axis, int32_t i) {
            return std::llround(info.origin_mm[axis] / info.pitch_mm[axis]) + i;
        };
        int32_t z = 0;
        for (Result<bool> more = (*reader)->next(); more && *more; more = (*reader)->next(), ++z) {
            for (int32_t y = 0; y < info.size.y; ++y) {
                for (int32_t x = 0; x < info.size.x; ++x) {
                    const uint8_t code = (*reader)->slice().code(x, y, info.bits);
                    if (code != 0) voxels[{place(0, x), place(1, y), place(2, z)}] = code;
                }
            }
        }
        return voxels;
    }
    static int64_t differences(const Voxels& a, const Voxels& b) {
        EXPECT_GT(a.size(), 1000u);
        const auto lacks = [](const Voxels& from, const Voxels& to) {
            return std::ranges::count_if(from, [&](const auto& voxel) {
                const auto found = to.find(voxel.first);
                return found == to.end() || found->second != voxel.second;
            });
        };
        return std::max(lacks(a, b), lacks(b, a));
    }

  private:
    void write(const std::string& name, const std::string& mesh, const std::string& placement) {
        scratch_.write(name + ".fab.json", fmt::format(R"({{
  "openfab": 1, "printer": "generic",
  "fablets": {{"f": {{"source": "f.fl", "fablet": "F"}}}},
  "materials": {{"skin": {{"key": "#ffffff"}}, "core": {{"key": "#000000"}}}},
  "meshes": {{"m": {}}},
  "objects": {{"o": {{"mesh": "m", "fablet": "f", "uniforms": {{"skin": "skin", "core": "core"}}}}}},
  "build": [{{"object": "o"{}}}]
}})",
                                                       mesh, placement));
    }
};

TEST_F(MachineScale, WhatGrowsIsScaledAsItsBeamsAre) {
    for (const char* placement : {"", R"(, "rotate_deg": [20, 30, 40])",
                                  R"(, "scale": [-1, 1, 1], "rotate_deg": [0, 0, 90])"}) {
        write_worlds(placement);
        for (const char* process :
             {R"({"scale": 1.002})", R"({"scale": 1.6})", R"({"scale": [1.002, 1.002, 1.004]})",
              R"({"scale": [1.08, 1, 1.02]})"}) {
            const Voxels beams = print_voxels("beams", process);
            // Single voxels, whose middles lie on a surface but for the last bits. (By 1.5 it would be whole rows.)
            EXPECT_LE(differences(print_voxels("grown", process), beams), 3)
                << placement << process;
            EXPECT_LE(differences(print_voxels("program", process), beams), 3)
                << placement << process;
        }
    }
}

TEST_F(MachineScale, ScaleOfAPlacementIsThatOfTheMachine) {
    write_worlds(R"(, "scale": 1.25)");
    const Voxels placed = print_voxels("grown", "{}");
    write_worlds("");
    EXPECT_EQ(differences(placed, print_voxels("grown", R"({"scale": 1.25})")), 0);
}

TEST_F(MachineScale, FactorsThatDifferTooMuchAreRefusedByName) {
    write_worlds("");
    scratch_.write("p.json", R"({"scale": [1, 1, 1.5]})");
    for (const char* world : {"beams", "grown", "program"}) {
        const Outcome outcome =
            print({path(fmt::format("{}.fab.json", world)), "-o", path("a.ofr"), "--voxel", "0.2mm",
                   "--process", path("p.json"), "--allow-programs"});
        EXPECT_EQ(outcome.exit_code, 1) << world;
        EXPECT_THAT(outcome.err, Says(part::messages::kUnevenStretch, "1", "1.5"));
        EXPECT_THAT(outcome.err, ::testing::HasSubstr("`o`"));
    }
}

}  // namespace
}  // namespace openfab::testing

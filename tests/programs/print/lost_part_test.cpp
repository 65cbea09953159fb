// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What falls between the centres of coarse voxels beside something that does not is told, for every kind of
// geometry.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <string>
#include <utility>
#include <vector>

#include "runtime/pipeline/messages.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"

namespace openfab::testing {
namespace {

using pipeline::messages::kPartLost;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kFablets = R"(fablet Plain {
    @uniform { Material m; }
    @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; mc.Set(m, 1); return mc; }
}
fablet Rod {
    @uniform { Material m; }
    @Shape(@varying { ShapeAttributes attr }) { return max(length(attr.p.xy) - 0.2, abs(attr.p.z - 2.5) - 2); }
    @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; mc.Set(m, 1); return mc; }
}
struct Bar { float3 end[2]; float radius; int children; float reach; };
fablet Twig {
    @uniform { Material m; }
    @Grow(@varying { GrowAttributes attr, Bar parent })
    {
        Bar b;
        b.end[0] = float3(0, 0, 1);
        b.end[1] = float3(0, 0, 5);
        b.radius = 0.2;
        b.children = 0;
        b.reach = 8;
        return b;
    }
    @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; mc.Set(m, 1); return mc; }
}
)";

std::string printed(ScratchFolder& scratch, const std::string& build, const std::string& voxel,
                    const std::vector<std::string>& more = {}) {
    const std::string world = R"({"openfab": 1, "printer": "generic",
"fablets": {"plain": {"source": "f.fl", "fablet": "Plain"}, "rod": {"source": "f.fl", "fablet": "Rod"},
            "twig": {"source": "f.fl", "fablet": "Twig"}},
"materials": {"a": {"key": "#ff0000"}},
"meshes": {"block": {"box": [8, 8, 8]}, "wire": {"cylinder": [0.2, 5]}, "beam": {"beams": "beam.txt"},
           "rod": {"shape": "rod", "box_mm": [[-1, -1, 0], [1, 1, 5]]},
           "twig": {"grow": "twig", "box_mm": [[-2, -2, 0], [2, 2, 6]]}},
"objects": {"block": {"mesh": "block", "fablet": "plain", "uniforms": {"m": "a"}},
            "wire": {"mesh": "wire", "fablet": "plain", "uniforms": {"m": "a"}},
            "beam": {"mesh": "beam", "fablet": "plain", "uniforms": {"m": "a"}},
            "rod": {"mesh": "rod", "fablet": "rod", "uniforms": {"m": "a"}},
            "twig": {"mesh": "twig", "fablet": "twig", "uniforms": {"m": "a"}}},
"build": [)" + build + "]}";
    scratch.write("f.fl", kFablets);
    scratch.write("beam.txt", "node 0 0 0 0.2\nnode 0 0 5 0.2\nstrut 0 1\n");
    scratch.write("w.fab.json", world);
    std::vector<std::string> argv{program("openfab").string(),
                                  "print",
                                  (scratch / "w.fab.json").string(),
                                  "-o",
                                  (scratch / "out.ofr").string(),
                                  "--voxel",
                                  voxel,
                                  "--progress",
                                  "none"};
    argv.insert(argv.end(), more.begin(), more.end());
    const Outcome outcome = run(argv);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome.err;
}

TEST(LostPart, IsToldForEveryKind) {
    ScratchFolder scratch;
    for (const char* name : {"wire", "beam", "rod", "twig"}) {
        // The lattice of the block's 2 mm has centres at odd millimetres.
        const auto build = [&](double x) {
            return fmt::format(
                R"({{"object": "block"}}, {{"object": "{}", "translate_mm": [{}, 2, 1]}})", name,
                x);
        };
        EXPECT_THAT(printed(scratch, build(10), "2mm"), Says(kPartLost, name, 1)) << name;
        EXPECT_THAT(printed(scratch, build(10), "0.1mm"), Not(HasSubstr("is in the print")))
            << name;
    }
}

TEST(LostPart, IsNotLostOutsideOfASlice) {
    ScratchFolder scratch;
    const std::string build =
        R"({"object": "block"}, {"object": "wire", "translate_mm": [10, 2, 1]})";
    EXPECT_THAT(printed(scratch, build, "2mm", {"--slices", "0:2"}),
                Not(HasSubstr("is in the print")));
}

TEST(LostPart, ManyAreCounted) {
    ScratchFolder scratch;
    EXPECT_THAT(
        printed(
            scratch,
            R"({"object": "block"}, {"object": "wire", "translate_mm": [10, 2, 1], "grid": {"count": [4, 3, 1], "spacing_mm": [2, 2, 0]}})",
            "2mm"),
        AllOf(Says(kPartLost, "wire", 1), Says(kPartLost, "wire", 4),
              Not(Says(kPartLost, "wire", 5)), Says(pipeline::messages::kMorePartsLost, 8)));
}

}  // namespace
}  // namespace openfab::testing

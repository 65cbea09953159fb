// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What `printf` and `assert` of a surface stage print: each vertex of the tessellation once for each
// normal, whatever the patches and threads.

#include <gmock/gmock.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "runtime/pipeline/messages.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class SurfacePrintf : public ::testing::Test {
  protected:
    SurfacePrintf() {
        scratch_.write("world.fab.json", R"({"openfab": 1, "printer": "generic",
            "fablets": {"f": {"source": "f.fl", "fablet": "F"}}, "materials": {"a": {"key": "#ff0000"}},
            "meshes": {"box": {"box": [1, 1, 1]}},
            "objects": {"o": {"mesh": "box", "fablet": "f", "uniforms": {"a": "a"}, "max_displacement_mm": 0.5}},
            "build": [{"object": "o"}, {"object": "o", "translate_mm": [4, 0, 0]}]})");
    }
    /// Prints with a surface stage of these statements.
    Outcome print(const std::string& surface, const std::string& voxel, const std::string& threads,
                  bool prints = true) {
        scratch_.write("f.fl",
                       "fablet F { @uniform { Material a; }\n"
                       "@Surface(@varying { SurfaceAttributes attr }) {\n" +
                           surface +
                           "\n}\n@Volume(@varying { VolumeAttributes attr }) {"
                           "MaterialComposition mc; mc.Set(a, 1); return mc; } }");
        const auto path = [&](const char* name) { return (scratch_ / name).string(); };
        std::vector<std::string> command{program("openflc"),
                                         "run",
                                         path("f.fl"),
                                         path("world.fab.json"),
                                         "-o",
                                         path("o.ofr"),
                                         "--voxel",
                                         voxel,
                                         "--threads",
                                         threads};
        if (prints) command.emplace_back("--prints");
        RunOptions options;
        options.environment = {{"OPENFAB_CACHE", path("cache")}};
        return run(command, options);
    }

    ScratchFolder scratch_;
};

/// The lines that begin with this.
std::vector<std::string> lines_of(const std::string& text, const std::string& begin) {
    std::vector<std::string> out;
    for (size_t at = 0; at < text.size();) {
        const size_t end = std::min(text.find('\n', at), text.size());
        if (text.compare(at, begin.size(), begin) == 0) out.push_back(text.substr(at, end - at));
        at = end + 1;
    }
    return out;
}

constexpr const char* kPrints =
    "printf(\"%g %g\\n\", attr.p, attr.n); return attr.n * (attr.p.x > 0 ? 0.25 : 0);";

/// A face whose sides have 2 edges and whose diagonal has 3: both lattices have 3 edges a side and
/// one inner point, and the outer sides' points are snapped to 2 edges.
TEST_F(SurfacePrintf, ShowsEachVertexOnce) {
    const Outcome outcome = print(kPrints, "0.501mm", "2");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const std::vector<std::string> lines = lines_of(outcome.err, "f.fl:3: at (");
    EXPECT_EQ(lines.size(), 6u * (4 + 4 * 1 + 2 + 2 * 1)) << outcome.err;
    EXPECT_EQ(std::set<std::string>(lines.begin(), lines.end()).size(), lines.size());
    EXPECT_THAT(outcome.err, HasSubstr("f.fl:3: at (0.5, -0.5, 1) mm: 0.5 -0.5 1 1 0 0\n"));
    EXPECT_THAT(outcome.err, HasSubstr("f.fl:3: at (0, -0.5, 1) mm: 0 -0.5 1 0 -1 0\n"));
    EXPECT_LT(outcome.err.find(lines.back()), outcome.err.find("slice 1 of"));
}

TEST_F(SurfacePrintf, IsTheSameForAnyThreads) {
    const Outcome one = print(kPrints, "0.0501mm", "1"), many = print(kPrints, "0.0501mm", "5");
    ASSERT_EQ(one.exit_code, 0) << one.err;
    EXPECT_EQ(lines_of(one.err, "f.fl:3: "), lines_of(many.err, "f.fl:3: "));
    // Inner points of the two lattices of 29, those of the diagonal, and of the sides of 20.
    const int all = 6 * (28 * 27 + 28 + 4 * 19 + 4);
    EXPECT_THAT(one.err, testing::Says(pipeline::messages::kLinesNotShown, "f.fl", 3, all - 100));
}

TEST_F(SurfacePrintf, ShowsAllOfAMatrixAnArrayAndAStruct) {
    const Outcome outcome = print(
        "struct Hit { float depth; int2 cell; bool inside; };\n"
        "float2x3 m = float2x3(1, 2, 3, 4, 5, 6); int a[2][2] = {1, 2, 3, 4}; Hit h[1];\n"
        "h[0].depth = 0.5; h[0].cell = int2(7, 8); h[0].inside = true;\n"
        "printf(\"%g %d %g %.1f\\n\", m, a, h, h[0]); return 0;",
        "0.501mm", "2");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(
        outcome.err,
        HasSubstr("mm: {1 2 3, 4 5 6} {{1, 2}, {3, 4}} {{0.5, 7 8, 1}} {0.5, 7.0 8.0, 1.0}\n"));
}

TEST_F(SurfacePrintf, AFailedAssertionEndsThePrint) {
    const std::string surface = "assert(attr.p.z < 0.9, \"high: %g\", attr.p.z); return 0;";
    const Outcome outcome = print(surface, "0.501mm", "2");
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_THAT(outcome.err, HasSubstr("f.fl:3: at ("));
    EXPECT_THAT(outcome.err, HasSubstr(", 1) mm: high: 1\n"));
    EXPECT_THAT(outcome.err, Not(HasSubstr("slice 1 of")));
    EXPECT_EQ(print(surface, "0.501mm", "2", false).exit_code, 0);
}

}  // namespace
}  // namespace openfab::testing

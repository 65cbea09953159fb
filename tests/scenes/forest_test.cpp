// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// A forest that grows by a rule: the same bytes for every way to print it, the memory of a few trees, and rules that never
// end or leave their bounds, which are told within memory.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "runtime/part/messages.h"
#include "runtime/solid/messages.h"
#include "tests/scenes/scene_fixture.h"
#include "tests/support/says/says.h"
#include "tools/openfab/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;

class Forest : public ::testing::Test {
  protected:
    static void SetUpTestSuite() {
        scratch_ = new ScratchFolder;
        const std::filesystem::path from = source_dir() / "bench" / "grow";
        rule_ = read_file(from / "forest.fl");
        world_ = read_file(from / "coloured.fab.json");
        write("forest", rule_);
        write("small", rule_, "[[-12, -12, -1], [12, 12, 9]]");
    }
    static void TearDownTestSuite() {
        delete scratch_;
        scratch_ = nullptr;
    }

    /// Writes a rule and its world.
    static void write(const std::string& name, const std::string& rule,
                      const std::string& box = "[[-115, -115, -8], [115, 115, 12]]") {
        scratch_->write(name + ".fl", rule);
        scratch_->write(name + ".fab.json", replaced(replaced(world_, "forest.fl", name + ".fl"),
                                                     "[[-115, -115, -8], [115, 115, 12]]", box));
    }
    static std::string replaced(std::string text, const std::string& what, const std::string& by) {
        const size_t at = text.find(what);
        EXPECT_NE(at, std::string::npos) << what;
        return at == std::string::npos ? text : text.replace(at, what.size(), by);
    }
    static std::string path(const std::string& name) { return (*scratch_ / name).string(); }
    static Outcome openfab(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), program("openfab").string());
        return run(arguments, {{{"OPENFAB_CACHE", path("cache")}}, {}, {}});
    }
    static Outcome print(const std::string& world, const std::vector<std::string>& more) {
        std::vector<std::string> arguments{"print", path(world + ".fab.json"), "--progress",
                                           "none"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return openfab(arguments);
    }
    /// Prints 64 trees of 1,093 beams.
    static std::string small(std::vector<std::string> more = {},
                             const std::string& file = "a.ofr") {
        more.insert(more.end(), {"--voxel", "0.1mm", "--set", "forest.trees=8", "--set",
                                 "forest.levels=7", "-o", path(file)});
        const Outcome printed = print("small", more);
        EXPECT_EQ(printed.exit_code, 0) << printed.err;
        return read_file(path(file));
    }

    static ScratchFolder* scratch_;
    static std::string rule_, world_;
};

ScratchFolder* Forest::scratch_ = nullptr;
std::string Forest::rule_, Forest::world_;

TEST_F(Forest, HasTheSameBytesForAllWaysToPrint) {
    const std::string whole = small();
    EXPECT_GT(whole.size(), 20'000u);
    for (const std::vector<std::string>& way : std::vector<std::vector<std::string>>{
             {"--threads", "1"},
             {"--threads", "5", "--no-cull"},
             {"--isa", "sse41", "--threads", "2"},
#ifndef OPENFAB_SANITIZED
             {"--memory", "140MB", "--threads", "2"},
#endif
         })
        EXPECT_TRUE(small(way) == whole) << fmt::format("{}", fmt::join(way, " "));
}

/// Cut within slabs.
TEST_F(Forest, IsTheSameInParts) {
    const std::string whole = small();
    std::vector<std::string> merge{"merge", "-o", path("merged.ofr")};
    for (const std::string slices : {"0:13", "13:34", "34:100"}) {
        small({"--slices", slices}, "part" + slices.substr(0, 2) + ".ofr");
        merge.push_back(path("part" + slices.substr(0, 2) + ".ofr"));
    }
    const Outcome merged = openfab(merge);
    ASSERT_EQ(merged.exit_code, 0) << merged.err;
    EXPECT_TRUE(read_file(path("merged.ofr")) == whole);
}

TEST_F(Forest, GoesOnWhereAPrintWasCut) {
    const std::string whole = small({}, "cut.ofr");
    std::filesystem::resize_file(path("cut.ofr"), whole.size() / 2);
    EXPECT_TRUE(small({"--resume", "--threads", "1"}, "cut.ofr") == whole);
}

/// A program that makes a post, in the language of its answers.
TEST_F(Forest, OfAProgramIsDescribedAndExported) {
    scratch_->write("made.sh", "while read w; do echo 'beam 0 0 2 0 0 8 2 1'; echo done; done\n");
    scratch_->write("made.fab.json", R"({
    "openfab": 1, "printer": "generic",
    "fablets": {"f": {"source": "post.fl", "fablet": "Post"}},
    "materials": {"wood": {"key": "#7a5230"}},
    "meshes": {"post": {"program": ["sh", "made.sh"], "box_mm": [[-3, -3, 0], [3, 3, 10]]}},
    "objects": {"post": {"mesh": "post", "fablet": "f", "uniforms": {"wood": "wood"}}},
    "build": [{"object": "post"}]
})");
    scratch_->write("post.fl", R"(fablet Post {
    @uniform { Material wood; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        mc.Set(wood, 1);
        return mc;
    }
}
)");
    const Outcome told = openfab({"info", path("made.fab.json")});
    EXPECT_THAT(told.out, HasSubstr("program    sh made.sh\n"));
    EXPECT_THAT(told.out, HasSubstr("box        6 x 6 x 10 mm, from -3 -3 0"));
    EXPECT_THAT(openfab({"info", path("small.fab.json")}).out,
                HasSubstr("shape      by fablet forest"));
    const std::vector<std::string> to_3mf{
        "export", path("made.fab.json"), "-o", path("made.3mf"), "--voxel", "0.5mm"};
    const Outcome refused = openfab(to_3mf);
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_THAT(refused.err, Says(part::messages::kProgramNotAllowedHelp, "--allow-programs"));
    std::vector<std::string> allowed = to_3mf;
    allowed.emplace_back("--allow-programs");
    const Outcome written = openfab(allowed);
    EXPECT_EQ(written.exit_code, 0) << written.err;
    EXPECT_THAT(written.err,
                HasSubstr(std::string("object `post`: ") + tools::messages::kMadeByProgram));
    EXPECT_GT(std::filesystem::file_size(path("made.3mf")), 1000u);
}

/// Nodes of which nothing is kept are looked through, too: without any beam, and with beams on the first level only.
TEST_F(Forest, NodesWithoutBeamsHaveALimit) {
    for (const char* const radius : {"0", "attr.level < 1 ? 1 : 0"}) {
        scratch_->write("nodes.fl", fmt::format(R"(struct Node {{
    float3 end[2];
    float radius;
    int children;
    float reach;
}};

fablet Nodes {{
    @uniform {{ Material a; }}
    @Grow(@varying {{ GrowAttributes attr, Node parent }})
    {{
        Node n;
        n.end[0] = float3(0, 0, 0);
        n.end[1] = float3(0, 0, 5);
        n.radius = {};
        n.children = attr.level < 3 ? 65536 : 0;
        n.reach = 5;
        return n;
    }}
    @Volume(@varying {{ VolumeAttributes attr }})
    {{
        MaterialComposition mc;
        mc.Set(a, 1);
        return mc;
    }}
}}
)",
                                                radius));
        scratch_->write("nodes.fab.json", R"({
    "openfab": 1, "printer": "generic",
    "materials": {"a": {"key": "#ffffff"}},
    "fablets": {"nodes": {"source": "nodes.fl", "fablet": "Nodes"}},
    "meshes": {"m": {"grow": "nodes", "box_mm": [[-30, -30, -5], [30, 30, 30]]}},
    "objects": {"o": {"mesh": "m", "fablet": "nodes", "uniforms": {"a": "a"}}},
    "build": [{"object": "o"}]
})");
        const Outcome printed = print("nodes", {"--voxel", "0.5mm", "-o", path("nodes.ofr")});
        EXPECT_EQ(printed.exit_code, 1) << printed.err;
        EXPECT_THAT(printed.err, Says(solid::messages::kTooManyNodesAtOnce));
    }
}

#ifndef OPENFAB_SANITIZED
constexpr int64_t kMost = 300'000'000;

/// 98 million beams: the first slices with wood.
TEST_F(Forest, TakesTheMemoryOfAFewTrees) {
    const Outcome printed =
        print("forest", {"--voxel", "0.1mm", "--slices", "80:88", "-o", path("large.ofr")});
    ASSERT_EQ(printed.exit_code, 0) << printed.err;
    EXPECT_LT(printed.peak_rss_bytes, kMost);
}

/// Where more beams crowd than one tile may have, tiles are halved.
TEST_F(Forest, IsPrintedWhereVoxelsAreCoarse) {
    const Outcome printed =
        print("small", {"--voxel", "0.5mm", "--set", "forest.trees=8", "-o", path("coarse.ofr")});
    EXPECT_EQ(printed.exit_code, 0) << printed.err;
    EXPECT_LT(printed.peak_rss_bytes, kMost);
}

TEST_F(Forest, SaysWhatIsWrongWithinMemory) {
    struct Mistake {
        const char *what, *by, *message, *help;
    };
    using namespace solid::messages;
    const Mistake mistakes[] = {
        // The second reaches its last level, the third is lost in what numbers are rounded by.
        {"attr.level < levels ? 3 : 0", "1", kChildrenTooDeep, kLetChildrenEnd},
        {"attr.level < levels ? 3 : 0", "2", kChildrenTooDeep, kLetChildrenEnd},
        {"attr.level < levels ? 3 : 0", "60000", kTooManyNodesAtOnce, kTooManyNodesAtOnceHelp},
        {"0.7 / 0.3 * t.size", "0.2 * t.size", kBeamOutside, kEnlargeNodeBox},
        {"t.along = float3(0, 0, 1)", "t.along = float3(0, 0, 40)", kBeamOutside, kEnlargeNodeBox},
    };
    for (const Mistake& mistake : mistakes) {
        write("wrong", replaced(rule_, mistake.what, mistake.by), "[[-12, -12, -1], [12, 12, 9]]");
        const Outcome printed = print(
            "wrong", {"--voxel", "0.2mm", "--set", "forest.trees=1", "-o", path("wrong.ofr")});
        EXPECT_EQ(printed.exit_code, 1) << printed.err;
        EXPECT_THAT(printed.err, HasSubstr("wrong.fab.json"));
        EXPECT_THAT(printed.err, Says(mistake.message)) << mistake.by;
        EXPECT_THAT(printed.err, Says(mistake.help)) << mistake.by;
        EXPECT_LT(printed.peak_rss_bytes, kMost);
    }
}
#endif

}  // namespace
}  // namespace openfab::testing

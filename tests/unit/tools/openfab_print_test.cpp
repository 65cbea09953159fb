// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab print`: compiles what changed, once, and gives the compiler's errors through.

#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>

#include "tests/support/process/process.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

constexpr const char* kFablet = R"(fablet Plain {
    @uniform { Material body; }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        mc.Set(body, 1);
        return mc;
    }
}
)";

constexpr const char* kWorld = R"({
  "openfab": 1,
  "printer": "generic",
  "fablets": {"plain": {"source": "plain.fl", "fablet": "Plain"}},
  "materials": {"resin": {"key": "#ffffff", "preview": "#f0f0f0ff", "density_g_cm3": 1.18}},
  "meshes": {"block": {"box": [4, 3, 2]}},
  "objects": {"thing": {"mesh": "block", "fablet": "plain", "uniforms": {"body": "resin"}}},
  "build": [{"object": "thing"}]
}
)";

class OpenfabPrint : public ::testing::Test {
  protected:
    OpenfabPrint() {
        scratch_.write("plain.fl", kFablet);
        scratch_.write("world.fab.json", kWorld);
        scratch_.write("block.obj",
                       "v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nv 0 0 2\nv 4 0 2\nv 4 3 2\nv 0 3 2\n"
                       "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
    }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    Outcome print(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), {OPENFAB_PROGRAM, "print"});
        return run(arguments, {{{"OPENFAB_CACHE", path("cache")}}, {}, {}});
    }

    ScratchFolder scratch_;
};

TEST_F(OpenfabPrint, CompilesOnceAndAgainWhenTheSourceChanged) {
    const Outcome first = print({path("world.fab.json"), "-o", path("a.ofr")});
    ASSERT_EQ(first.exit_code, 0) << first.err;
    EXPECT_THAT(first.err, HasSubstr("compiling plain.fl"));
    const Outcome second = print({path("world.fab.json"), "-o", path("b.ofr")});
    ASSERT_EQ(second.exit_code, 0) << second.err;
    EXPECT_THAT(second.err, Not(HasSubstr("compiling")));
    EXPECT_TRUE(read_file(path("a.ofr")) == read_file(path("b.ofr")));
    // The mesh alone, by the same fablet: the cache has the binary.
    const Outcome quick =
        print({path("block.obj"), "--fablet", path("plain.fl"), "-o", path("c.ofr")});
    EXPECT_EQ(quick.exit_code, 0) << quick.err;
    EXPECT_THAT(quick.err, Not(HasSubstr("compiling")));

    scratch_.write("plain.fl", std::string(kFablet) + "// changed\n");
    const Outcome changed = print({path("world.fab.json"), "-o", path("b.ofr")});
    ASSERT_EQ(changed.exit_code, 0) << changed.err;
    EXPECT_THAT(changed.err, HasSubstr("compiling plain.fl"));
    EXPECT_TRUE(read_file(path("a.ofr")) == read_file(path("b.ofr")));
}

TEST_F(OpenfabPrint, SourcesAndTheirModulesAreSpared) {
    scratch_.write("helper.fl", "float half_of(float x) { return x / 2; }\n");
    for (const std::string name : {"plain.fl", "helper.fl"}) {
        const std::string before = read_file(path(name));
        for (const std::vector<std::string>& options :
             {std::vector<std::string>{path("world.fab.json"), "-o", path(name), "--format", "ofr"},
              {path("block.obj"), "--fablet", path("plain.fl"), "-o", path("a.ofr"), "--stats",
               path(name)}}) {
            const Outcome outcome = print(options);
            EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
            EXPECT_THAT(outcome.err, HasSubstr("would overwrite"));
            EXPECT_TRUE(read_file(path(name)) == before);
        }
    }
}

// A damaged picture has one message, ours.
TEST_F(OpenfabPrint, ImageLibrariesDoNotSpeakForThemselves) {
    const std::string png =
        std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x40\0\0\0\x40\x08\2\0\0\0", 29) +
        "nonsense that no checksum covers";
    scratch_.write("broken.png", png);
    const Outcome outcome =
        run({OPENFAB_PROGRAM, "texture", path("broken.png"), "-o", path("broken.oftx")});
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_THAT(outcome.err, HasSubstr("error: "));
    EXPECT_THAT(outcome.err, HasSubstr("broken.png"));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    const Outcome onto =
        run({OPENFAB_PROGRAM, "texture", path("broken.png"), "-o", path("broken.png")});
    EXPECT_EQ(onto.exit_code, 1);
    EXPECT_TRUE(read_file(path("broken.png")) == png);
}

TEST_F(OpenfabPrint, CompileErrorsPassThrough) {
    std::string wrong = kFablet;
    wrong.replace(wrong.find("mc.Set"), 6, "md.Set");
    scratch_.write("plain.fl", wrong);
    const Outcome outcome = print({path("world.fab.json"), "-o", path("a.ofr")});
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_THAT(outcome.err, HasSubstr("plain.fl:5:9: error"));
    EXPECT_FALSE(fs::exists(path("a.ofr")));
    EXPECT_TRUE(fs::is_empty(path("cache/prints")));
}

TEST_F(OpenfabPrint, MistakesAreFoundBeforeAnythingIsCompiled) {
    EXPECT_EQ(print({}).exit_code, 2);
    EXPECT_EQ(print({path("world.fab.json"), "-o", path("a.ofr"), "--nonsense"}).exit_code, 2);
    EXPECT_EQ(print({path("block.obj"), "-o", path("a.ofr")}).exit_code, 2);
    EXPECT_EQ(print({path("gone.fab.json"), "-o", path("a.ofr")}).exit_code, 1);
    EXPECT_EQ(
        print({path("block.obj"), "--fablet", path("gone.fl"), "-o", path("a.ofr")}).exit_code, 1);
    const Outcome help = print({"--help"});
    EXPECT_EQ(help.exit_code, 0);
    EXPECT_THAT(help.out, HasSubstr("openfab print"));
    EXPECT_FALSE(fs::exists(path("cache")));
}

}  // namespace
}  // namespace openfab::testing

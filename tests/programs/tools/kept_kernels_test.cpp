// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The edit loop: after a change only the kernels are compiled that it changes, whichever command
// made the others, and the print is that of a program compiled from nothing.

#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <thread>

#include "tests/support/places/places.h"
#include "tests/support/process/process.h"

namespace openfab::testing {
namespace {

using ::testing::AnyOf;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;
namespace fs = std::filesystem;

constexpr const char* kFablet = R"(fablet Wavy {
    @uniform { Material body, core; float height = 0.2; float skin = 0.5; }
    @Surface(@varying { SurfaceAttributes attr }) {
        return attr.n * (height * saturate(attr.p.x * attr.p.y));
    }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        if (distance(attr.voxelCenter) > -skin) {
            mc.Set(body, 1);
        } else {
            mc.Set(core, saturate(attr.voxelCenter.x));
            mc.Set(body, 1 - saturate(attr.voxelCenter.x));
        }
        return mc;
    }
}
)";

constexpr const char* kWorld = R"({
  "openfab": 1,
  "printer": "generic",
  "fablets": {"wavy": {"source": "wavy.fl", "fablet": "Wavy"}},
  "materials": {"resin": {"key": "#ffffff", "preview": "#f0f0f0ff", "density_g_cm3": 1.18},
                "ink": {"key": "#000000", "preview": "#000000ff", "density_g_cm3": 1.18}},
  "meshes": {"block": {"box": [4, 3, 2]}},
  "objects": {"thing": {"mesh": "block", "fablet": "wavy", "max_displacement_mm": 0.5,
                        "uniforms": {"body": "resin", "core": "ink"}}},
  "build": [{"object": "thing"}]
}
)";

/// What `--time` says of kernels.
struct Made {
    std::set<std::string> compiled;  ///< "volume_bounds"
    int from_cache = -1;
};

Made made_of(const Outcome& outcome) {
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    Made made;
    const std::regex one(R"(s  kernel (\w+) \w+)");
    for (std::sregex_iterator at(outcome.err.begin(), outcome.err.end(), one), end; at != end; ++at)
        made.compiled.insert((*at)[1]);
    // Some are compiled while the print runs, and counted after it.
    size_t compiled = 0;
    const std::regex sum(R"((\d+) kernels compiled, (\d+) from the cache)");
    for (std::sregex_iterator at(outcome.err.begin(), outcome.err.end(), sum), end; at != end;
         ++at) {
        compiled += std::stoul((*at)[1]);
        made.from_cache = std::max(made.from_cache, std::stoi((*at)[2]));
    }
    EXPECT_EQ(made.compiled.size(), compiled) << outcome.err;
    EXPECT_GE(made.from_cache, 0) << outcome.err;
    return made;
}

class KeptKernels : public ::testing::Test {
  protected:
    KeptKernels() {
        scratch_.write("wavy.fl", kFablet);
        scratch_.write("world.fab.json", kWorld);
    }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    fs::path kernels(const std::string& cache = "cache") const { return path(cache) + "/kernels"; }

    Outcome openflc(const std::vector<std::string>& words,
                    const std::string& cache = "cache") const {
        std::vector<std::string> argv = {program("openflc")};
        argv.insert(argv.end(), words.begin(), words.end());
        return run(argv, {{{"OPENFAB_CACHE", path(cache)}}, {}, {}});
    }
    /// `openflc run`, for one instruction set.
    Outcome run_world(const std::string& out, const std::vector<std::string>& more = {},
                      const std::string& cache = "cache") const {
        std::vector<std::string> words = {"run", "--time", path("wavy.fl"), path("world.fab.json"),
                                          "-o",  path(out)};
        words.insert(words.end(), more.begin(), more.end());
        return openflc(words, cache);
    }
    void change(const std::string& from, const std::string& to) const {
        std::string text = read_file(path("wavy.fl"));
        ASSERT_NE(text.find(from), std::string::npos) << from;
        text.replace(text.find(from), from.size(), to);
        scratch_.write("wavy.fl", text);
    }
    std::vector<fs::path> entries() const {
        std::vector<fs::path> out;
        for (const auto& entry : fs::directory_iterator(kernels()))
            out.push_back(entry.path());
        return out;
    }

    ScratchFolder scratch_;
};

TEST_F(KeptKernels, OnlyWhatAChangeTouchesIsCompiled) {
    const Made first = made_of(run_world("a.ofr"));
    EXPECT_EQ(first.from_cache, 0);
    EXPECT_THAT(first.compiled, ::testing::IsSupersetOf({"surface", "slab", "volume_bounds"}));
    const std::string before = read_file(path("a.ofr"));
    const auto same = [&](const char* what, const std::vector<std::string>& more = {}) {
        const Made made = made_of(run_world("b.ofr", more));
        EXPECT_THAT(made.compiled, IsEmpty()) << what;
        EXPECT_EQ(made.from_cache, static_cast<int>(first.compiled.size())) << what;
    };
    same("nothing changed");
    EXPECT_TRUE(read_file(path("b.ofr")) == before);
    change("MaterialComposition mc;", "// a remark\n\n        MaterialComposition   mc ;");
    same("a remark and blanks");
    EXPECT_TRUE(read_file(path("b.ofr")) == before);
    change("height = 0.2", "height = 0.3");
    same("a uniform's default");
    EXPECT_FALSE(read_file(path("b.ofr")) == before);
    same("a uniform", {"--set", "thing.skin=0.25"});

    change("mc.Set(core, saturate(attr.voxelCenter.x))",
           "mc.Set(core, 3 * saturate(attr.voxelCenter.x))");
    const Made changed = made_of(run_world("b.ofr"));
    EXPECT_THAT(changed.compiled, ::testing::IsSupersetOf({"slab", "volume_bounds"}));
    EXPECT_THAT(changed.compiled, Each(AnyOf("slab", StartsWith("volume"))));
    EXPECT_GE(changed.from_cache, 2) << "those of the surface";
    made_of(run_world("c.ofr", {}, "another_cache"));
    EXPECT_TRUE(read_file(path("b.ofr")) == read_file(path("c.ofr")));
}

TEST_F(KeptKernels, CommandsShareThem) {
    EXPECT_FALSE(made_of(run_world("a.ofr", {"--isa", "sse41"})).compiled.empty());
    const Outcome built =
        openflc({"build", "--time", "--target", "sse41", path("wavy.fl"), "-o", path("program")});
    EXPECT_THAT(made_of(built).compiled, IsEmpty());
    const Outcome printed = run({path("program"), path("world.fab.json"), "-o", path("b.ofr")});
    ASSERT_EQ(printed.exit_code, 0) << printed.err;
    EXPECT_TRUE(read_file(path("a.ofr")) == read_file(path("b.ofr")));
    // A print here is for this machine alone.
    const auto count = [&] { return entries().size(); };
    fs::remove_all(path("cache"));
    const Outcome print =
        run({program("openfab"), "print", path("world.fab.json"), "-o", path("c.ofr")},
            {{{"OPENFAB_CACHE", path("cache")}}, {}, {}});
    ASSERT_EQ(print.exit_code, 0) << print.err;
    EXPECT_TRUE(read_file(path("a.ofr")) == read_file(path("c.ofr")));
    const size_t of_print = count();
    EXPECT_THAT(made_of(run_world("d.ofr")).compiled, IsEmpty());
    EXPECT_EQ(count(), of_print);
}

TEST_F(KeptKernels, DamagedOnesAreMadeAgain) {
    const Made first = made_of(run_world("a.ofr"));
    const auto whole = entries();
    ASSERT_EQ(whole.size(), first.compiled.size());
    for (size_t k = 0; k < whole.size(); ++k) {
        std::string bytes = read_file(whole[k]);
        if (k % 3 == 0) bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
        if (k % 3 == 1) bytes.resize(bytes.size() / 3);
        if (k % 3 == 2) bytes = "planted";
        std::ofstream(whole[k], std::ios::binary) << bytes;
    }
    const Made again = made_of(run_world("b.ofr"));
    EXPECT_EQ(again.compiled, first.compiled);
    EXPECT_TRUE(read_file(path("a.ofr")) == read_file(path("b.ofr")));
    EXPECT_THAT(made_of(run_world("b.ofr")).compiled, IsEmpty());
}

TEST_F(KeptKernels, AFolderThatOthersCanWriteIsNotUsed) {
    const Made first = made_of(run_world("a.ofr"));
    for (const fs::path& open : {kernels(), fs::path(path("cache"))}) {
        fs::permissions(open, fs::perms(0777));
        const Outcome outcome = run_world("b.ofr");
        EXPECT_EQ(made_of(outcome).compiled, first.compiled);
        EXPECT_THAT(outcome.err, HasSubstr("note: no kernel is kept for the next run: "));
        EXPECT_EQ(entries().size(), first.compiled.size()) << "nor written";
        fs::permissions(open, fs::perms(0700));
    }
    fs::rename(kernels(), path("elsewhere"));
    std::ofstream(kernels()) << "no folder";
    EXPECT_EQ(made_of(run_world("b.ofr")).compiled, first.compiled);
}

TEST_F(KeptKernels, TwoAtOnceDoNotDisturbEachOther) {
    std::vector<Outcome> outcomes(2);
    std::vector<std::thread> threads;
    for (size_t k = 0; k < outcomes.size(); ++k)
        threads.emplace_back([&, k] { outcomes[k] = run_world(std::to_string(k) + ".ofr"); });
    for (std::thread& thread : threads)
        thread.join();
    for (const Outcome& outcome : outcomes)
        made_of(outcome);
    EXPECT_TRUE(read_file(path("0.ofr")) == read_file(path("1.ofr")));
    for (const fs::path& entry : entries())
        EXPECT_EQ(entry.extension(), ".kernel") << entry;
    EXPECT_THAT(made_of(run_world("2.ofr")).compiled, IsEmpty());
}

TEST_F(KeptKernels, AProgramForAnotherMachineSaysSo) {
    ASSERT_EQ(
        openflc({"build", "--target", "avx2", path("wavy.fl"), "-o", path("program")}).exit_code,
        0);
    const Outcome outcome =
        run({path("program"), path("world.fab.json"), "-o", path("a.ofr"), "--isa", "sse41"});
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_EQ(outcome.err,
              "error: fablet `Wavy` was compiled for other instruction sets than this machine's, "
              "SSE4.1; `openflc build --target both` makes a program for every machine\n");
    EXPECT_FALSE(fs::exists(path("a.ofr")));
}

TEST_F(KeptKernels, WhatAQuickLinkerRefusesTheUsualOneLinks) {
    // First on the PATH, and of no use.
    fs::create_directory(path("bin"));
    scratch_.write("bin/ld.mold", "#!/bin/sh\ntouch \"" + path("asked") + "\"\nexit 1\n");
    fs::permissions(path("bin/ld.mold"), fs::perms::owner_exec, fs::perm_options::add);
    const Outcome built = run(
        {program("openflc"), "build", "--target", "sse41", path("wavy.fl"), "-o", path("program")},
        {{{"OPENFAB_CACHE", path("cache")}, {"PATH", path("bin") + ":" + std::getenv("PATH")}},
         {},
         {}});
    EXPECT_EQ(built.exit_code, 0) << built.err;
    EXPECT_TRUE(fs::exists(path("asked")));
    EXPECT_EQ(run({path("program"), path("world.fab.json"), "-o", path("a.ofr")}).exit_code, 0);
}

}  // namespace
}  // namespace openfab::testing

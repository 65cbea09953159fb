// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Random small worlds, kinds of geometry by features, printed in this process: every voxel is what brute force says, or the
// world is refused by a message that may. Of five compiled fablets, whose uniforms are drawn.
// OPENFAB_SEED=N OPENFAB_WORLDS=M are M worlds from that seed.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "tests/crossings/fablets.h"
#include "tests/crossings/random_world.h"
#include "tests/support/long_run.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"

namespace openfab::testing {
namespace {

struct Tally {
    int64_t printed = 0, refused = 0, voxels = 0, solid = 0, not_sure = 0;
};

class RandomWorlds : public ::testing::Test {
  protected:
    /// Returns whether it is as it must be; says what is not.
    bool try_world(uint64_t seed, const openfab_fablet_list& fablets, Tally* tally) {
        const RandomWorld world = random_world(seed);
        scratch_.write("w.fab.json", world.text);
        for (const auto& [name, text] : world.files)
            scratch_.write(name, text);
        std::vector<std::string> words{(scratch_ / "w.fab.json").string(),
                                       "--voxel",
                                       fmt::format("{}mm", world.voxel_mm),
                                       "--draft",
                                       std::to_string(world.draft),
                                       "--threads",
                                       "1"};
        if (seed % 7 == 0) words.emplace_back("--no-cull");
        if (world.programs) words.emplace_back("--allow-programs");
        MemorySink sink;
        const Result<void> done = print_here(fablets, words, &sink);
        if (!done) return is_refused(world, done.error(), tally);
        return is_as_expected(world, sink, tally);
    }

    static bool is_refused(const RandomWorld& world, const Error& error, Tally* tally) {
        const std::string text = shown(error);
        for (const std::string_view message : world.refusals) {
            if (says(text, message)) {
                ++tally->refused;
                return true;
            }
        }
        ADD_FAILURE() << "refused: " << text << "\n" << world.text;
        return false;
    }

    static bool is_as_expected(const RandomWorld& world, const MemorySink& sink, Tally* tally) {
        const pipeline::PrintInfo& info = sink.info;
        const std::vector<uint8_t> codes = sink.codes();
        const double pitch = std::max({info.pitch_mm.x, info.pitch_mm.y, info.pitch_mm.z});
        // Two voxels around the print's own: nothing is cut off.
        constexpr int kAround = 2;
        int64_t wrong = 0;
        std::string first;
        for (int z = -kAround; z < info.size.z + kAround; ++z) {
            for (int y = -kAround; y < info.size.y + kAround; ++y) {
                for (int x = -kAround; x < info.size.x + kAround; ++x) {
                    const Vec3d centre{info.origin_mm.x + (x + 0.5) * info.pitch_mm.x,
                                       info.origin_mm.y + (y + 0.5) * info.pitch_mm.y,
                                       info.origin_mm.z + (z + 0.5) * info.pitch_mm.z};
                    const int expected = expected_code(world.parts, centre, pitch);
                    const bool within = x >= 0 && y >= 0 && z >= 0 && x < info.size.x &&
                                        y < info.size.y && z < info.size.z;
                    const int code = within ? codes[static_cast<size_t>(
                                                  (int64_t{z} * info.size.y + y) * info.size.x + x)]
                                            : 0;
                    ++tally->voxels;
                    tally->solid += code != 0 ? 1 : 0;
                    tally->not_sure += expected < 0 ? 1 : 0;
                    if (expected < 0 || expected == code) continue;
                    if (wrong++ == 0)
                        first = fmt::format("{} {} {} at {:.4f} {:.4f} {:.4f} mm is {}, not {}{}",
                                            x, y, z, centre.x, centre.y, centre.z, code, expected,
                                            within ? "" : ", outside the print's grid");
                }
            }
        }
        ++tally->printed;
        if (wrong == 0) return true;
        ADD_FAILURE() << wrong << " voxels of " << codes.size() << ": " << first << "\n"
                      << world.text;
        return false;
    }

    ScratchFolder scratch_;
};

TEST_F(RandomWorlds, AreWhatBruteForceSays) {
    const openfab_fablet_list& fablets = fablets_of("random_worlds.fl");
    ASSERT_GT(fablets.count, 0);
    const auto number = [](const char* name, uint64_t otherwise) {
        const char* text = std::getenv(name);
        return text != nullptr ? std::strtoull(text, nullptr, 10) : otherwise;
    };
    const uint64_t first = number("OPENFAB_SEED", 1);
    const uint64_t worlds = number("OPENFAB_WORLDS", long_run() ? 100000 : 300);
    Tally tally;
    int wrong = 0;
    for (uint64_t seed = first; seed < first + worlds; ++seed) {
        SCOPED_TRACE(fmt::format("OPENFAB_SEED={} OPENFAB_WORLDS=1", seed));
        if (!try_world(seed, fablets, &tally) && ++wrong == 20) break;
        if (seed % 1000 == 0)
            fmt::print(stderr, "{} worlds, {} refused, {} wrong\n", seed, tally.refused, wrong);
    }
    fmt::print("{} printed, {} refused, {} voxels, {} solid, {} not sure\n", tally.printed,
               tally.refused, tally.voxels, tally.solid, tally.not_sure);
    // Most is compared.
    EXPECT_LT(tally.not_sure * 10, tally.voxels);
    EXPECT_GT(tally.printed, tally.refused);
}

}  // namespace
}  // namespace openfab::testing

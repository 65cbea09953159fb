// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Pieces of parts: together they are the uncut print, hash for hash; connectors have the clearance
// that was asked for; each piece is what a plain loop over voxels says it is.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>
#include <random>

#include "base/hash.h"
#include "runtime/part/bind.h"
#include "runtime/pipeline/print_job.h"
#include "tests/property/pipeline/reference_check.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/places/places.h"
#include "tests/support/prints/box_print.h"
#include "world/world.h"

namespace openfab {
namespace {

constexpr Vec3d kPitch{0.1, 0.11, 0.09};

struct Print {
    pipeline::PrintInfo info;
    std::vector<uint8_t> codes;
    std::string provenance;

    uint8_t at(const Vec3d& p) const {
        Vec3i i;
        for (int a = 0; a < 3; ++a) {
            i[a] = static_cast<int32_t>(std::floor((p[a] - info.origin_mm[a]) / info.pitch_mm[a]));
            if (i[a] < 0 || i[a] >= info.size[a]) return 0;
        }
        return codes[(static_cast<size_t>(i.z) * static_cast<size_t>(info.size.y) +
                      static_cast<size_t>(i.y)) *
                         static_cast<size_t>(info.size.x) +
                     static_cast<size_t>(i.x)];
    }
    Vec3d center(size_t i) const {
        const auto x = static_cast<size_t>(info.size.x), y = static_cast<size_t>(info.size.y);
        return {info.origin_mm.x + (static_cast<double>(i % x) + 0.5) * info.pitch_mm.x,
                info.origin_mm.y + (static_cast<double>(i / x % y) + 0.5) * info.pitch_mm.y,
                info.origin_mm.z + (static_cast<double>(i / x / y) + 0.5) * info.pitch_mm.z};
    }
    size_t solid() const {
        return codes.size() - static_cast<size_t>(std::count(codes.begin(), codes.end(), 0));
    }
};

const testing::Compiled& compiled() {
    static const testing::Compiled program =
        testing::compile(testing::source_dir() / "tests/property/pipeline/worlds.fl");
    return program;
}

std::string world_text(const std::string& object, const std::string& mesh,
                       const std::string& pieces, const std::string& build) {
    return fmt::format(R"({{
  "openfab": 1,
  "fablets": {{"ripples": {{"source": "w.fl", "fablet": "Ripples"}}, "checks": {{"source": "w.fl", "fablet": "Checks"}}}},
  "materials": {{"w": {{"key": "#ffffff"}}, "k": {{"key": "#000000"}}, "r": {{"key": "#ff0000"}}}},
  "meshes": {{"mesh": {}}},
  "objects": {{"part": {{"mesh": "mesh", {}, "pieces": {}}}}},
  "build": {}
}})",
                       mesh, object, pieces, build);
}

Result<Print> print(const std::string& text, int32_t support = 0) {
    const testing::TempFolder folder;
    Result<world::World> world = world::load_world(folder.write("w.fab.json", text));
    if (!world) return world.error();
    Result<std::vector<part::Part>> parts = part::bind(*world, compiled().program->fablets());
    if (!parts) return parts.error();
    // The fablet of a whole part and of its pieces may tell instances apart.
    for (part::Part& part : *parts)
        part.instance = 0;
    pipeline::PrintInput input;
    input.parts = std::move(*parts);
    for (const char* name : {"w", "k", "r", "s"}) {
        if (name[0] == 's' && support == 0) continue;
        input.materials.push_back({name, {}, {}, 1, ""});
    }
    input.pitch_mm = kPitch;
    input.support_code = support;
    testing::MemorySink sink;
    pipeline::PrintOptions options;
    options.seed = 7;
    auto job = pipeline::PrintJob::create(std::move(input), options);
    if (!job) return job.error();
    const std::atomic<bool> interrupt{false};
    pipeline::PrintStatistics statistics;
    const Result<void> run = (*job)->run(sink, {}, interrupt, &statistics);
    if (!run) return run.error();
    Print out{sink.info, sink.codes(), {}};
    for (const auto& [key, value] : sink.info.provenance) {
        if (key == "placements") out.provenance = value;
    }
    return out;
}

/// A random tree of at most `depth` cuts in a row through the box [-1, 1]³; `names` get its pieces.
std::string random_tree(std::mt19937* random, int depth, const std::string& path) {
    std::uniform_real_distribution<double> real(-1, 1);
    std::uniform_int_distribution<int> one_of(0, 9);
    std::string normal, at;
    if (one_of(*random) < 3) {
        // Through voxel centres and corners.
        const int axis = one_of(*random) % 3;
        normal = axis == 0 ? "[1, 0, 0]" : axis == 1 ? "[0, -2, 0]" : "[0, 0, 1]";
        at = fmt::format("{}", 0.05 * (one_of(*random) - 5));
    } else {
        normal = fmt::format("[{}, {}, {}]", real(*random), real(*random), real(*random));
        at = fmt::format("[{}, {}, {}]", real(*random) * 0.4, real(*random) * 0.4,
                         0.4 + real(*random) * 0.4);
    }
    std::string out = fmt::format(R"({{"normal": {}, "at_mm": {})", normal, at);
    for (const char* side : {"back", "front"}) {
        if (depth <= 1 || one_of(*random) < 3) continue;
        out += fmt::format(R"(, "{}": {})", side, random_tree(random, depth - 1, path + side));
    }
    return out + "}";
}

/// Returns false for a tree that is no tree: one with a cut that misses, which is told.
bool expect_union(const std::string& object, const std::string& mesh, uint32_t seed) {
    std::mt19937 random(seed);
    const std::string tree = random_tree(&random, 3, "");
    std::uniform_real_distribution<double> real(-180, 180);
    const std::string pose = fmt::format(
        R"("rotate_deg": [{}, {}, {}], "translate_mm": [{}, {}, {}], "scale": [{}, 1.1, 0.9])",
        real(random), real(random), real(random), real(random) / 100, real(random) / 100,
        real(random) / 100, seed % 2 == 0 ? 1 : -1);
    const std::string whole =
        world_text(object, mesh, tree, R"([{"object": "part", )" + pose + "}]");
    const std::string cut =
        world_text(object, mesh, tree, R"([{"object": "part", "piece": "all", )" + pose + "}]");
    const Result<Print> a = print(whole);
    if (!a) {
        EXPECT_NE(a.error().text().find("misses"), std::string::npos) << a.error().text();
        return false;
    }
    const Result<Print> b = print(cut);
    if (!b) {
        ADD_FAILURE() << b.error().text();
        return true;
    }
    EXPECT_EQ(a->info.size, b->info.size) << "seed " << seed << "\n" << tree;
    EXPECT_EQ(xxh3(a->codes, 0), xxh3(b->codes, 0)) << "seed " << seed << "\n" << tree;
    EXPECT_GT(a->solid(), 100u);
    EXPECT_NE(a->provenance, b->provenance);
    return true;
}

TEST(Pieces, TogetherAreTheUncutPrint) {
    int compared = 0;
    for (uint32_t seed = 0; compared < 70; ++seed) {
        compared +=
            expect_union(R"("fablet": "checks", "uniforms": {"a": "w", "b": "k"})",
                         seed % 3 != 0 ? R"({"box": [2, 1.8, 1.6]})" : R"({"sphere": 2.2})", seed)
                ? 1
                : 0;
    }
}

TEST(Pieces, OfADisplacedPartTogetherAreTheUncutPrint) {
    int compared = 0;
    for (uint32_t seed = 1000; compared < 30; ++seed) {
        compared += expect_union(R"("fablet": "ripples", "uniforms": {"core": "w", "shell": "r"})",
                                 R"({"sphere": 1.6})", seed)
                        ? 1
                        : 0;
    }
}

constexpr const char* kPlain = R"("fablet": "checks", "uniforms": {"a": "w", "b": "w"})";

TEST(Pieces, APieceIsWhatAPlainLoopSays) {
    const std::string tree =
        R"({"normal": [1, 1, 0], "at_mm": 0.2, "front": "left", "back": {"normal": [0, 0, 1], "at_mm": 1.2}})";
    const std::string box = R"({"box": [3, 2.8, 2.6]})";
    const Result<Print> whole = print(world_text(kPlain, box, tree, R"([{"object": "part"}])"));
    const Result<Print> low =
        print(world_text(kPlain, box, tree, R"([{"object": "part", "piece": "1.1"}])"));
    ASSERT_TRUE(whole) << whole.error().text();
    ASSERT_TRUE(low) << low.error().text();
    // The grid is that of the piece alone: below the cut at z = 1.2.
    EXPECT_LT(low->info.size.z, whole->info.size.z);
    EXPECT_GT(low->solid(), 500u);
    for (size_t i = 0; i < whole->codes.size(); ++i) {
        const Vec3d p = whole->center(i);
        const double cut = (p.x + p.y) / std::sqrt(2.0) - 0.2;
        if (std::fabs(cut) < 1e-6 || std::fabs(p.z - 1.2) < 1e-6) continue;
        const bool in = whole->codes[i] != 0 && cut < 0 && p.z < 1.2;
        ASSERT_EQ(low->at(p) != 0, in) << p.x << " " << p.y << " " << p.z;
    }
}

TEST(Pieces, APegHasItsClearanceAndMaterial) {
    const std::string tree = R"({"normal": [0, 0, 1], "at_mm": 2, "connectors": [
        {"peg": [0, 0, 5], "diameter_mm": 1, "length_mm": 0.8, "clearance_mm": 0.2, "skin_mm": 0.3, "material": "r"}]})";
    const std::string box = R"({"box": [3, 3, 4]})";
    const Result<Print> low =
        print(world_text(kPlain, box, tree, R"([{"object": "part", "piece": "1"}])"));
    const Result<Print> high =
        print(world_text(kPlain, box, tree, R"([{"object": "part", "piece": "2"}])"));
    ASSERT_TRUE(low) << low.error().text();
    ASSERT_TRUE(high) << high.error().text();
    // Volumes to a voxel's shell: a cylinder of 1 mm stands 0.8 mm out, the hole is 1.4 by 1.0 mm.
    const double voxel = kPitch.x * kPitch.y * kPitch.z, pi = 3.14159265;
    size_t red = 0;
    for (const uint8_t code : low->codes)
        red += code == 3 ? 1 : 0;
    EXPECT_NEAR(static_cast<double>(red) * voxel, pi * 0.25 * 1.6, 0.1);
    const std::string flat = R"({"normal": [0, 0, 1], "at_mm": 2})";
    const Result<Print> flat_low =
        print(world_text(kPlain, box, flat, R"([{"object": "part", "piece": "1"}])"));
    const Result<Print> flat_high =
        print(world_text(kPlain, box, flat, R"([{"object": "part", "piece": "2"}])"));
    ASSERT_TRUE(flat_low && flat_high);
    EXPECT_NEAR(static_cast<double>(low->solid() - flat_low->solid()) * voxel, pi * 0.25 * 0.8,
                0.1);
    EXPECT_NEAR(static_cast<double>(flat_high->solid() - high->solid()) * voxel, pi * 0.49, 0.2);
    // Every voxel of the hole's side is the clearance away, within a voxel.
    for (size_t i = 0; i < high->codes.size(); ++i) {
        const Vec3d p = high->center(i);
        const double r = std::sqrt(p.x * p.x + p.y * p.y);
        if (p.z < 2 || p.z > 3.9 || r > 1.4) continue;
        const bool hole = r <= 0.7 && p.z <= 3.0;
        if (std::fabs(r - 0.7) < 1e-6 || std::fabs(p.z - 3.0) < 1e-6) continue;
        ASSERT_EQ(high->codes[i] == 0, hole) << p.x << " " << p.y << " " << p.z;
    }
}

TEST(Pieces, APegWithoutClearanceLosesNothing) {
    const std::string tree = R"({"normal": [0.2, 0.1, 1], "at_mm": 1.2, "connectors": [
        {"peg": [0.2, 0, 0], "diameter_mm": 0.9, "length_mm": 0.7, "clearance_mm": 0, "skin_mm": 0.1},
        {"dovetail": [-0.8, 0, 0], "width_mm": 0.4, "length_mm": 0.3, "clearance_mm": 0, "skin_mm": 0.1, "along": [0, 1, 0], "from": "front"}]})";
    const std::string box = R"({"box": [3, 2.6, 2.4]})";
    const Result<Print> whole = print(world_text(kPlain, box, tree, R"([{"object": "part"}])"));
    const Result<Print> both =
        print(world_text(kPlain, box, tree, R"([{"object": "part", "piece": "all"}])"));
    ASSERT_TRUE(whole) << whole.error().text();
    ASSERT_TRUE(both) << both.error().text();
    EXPECT_EQ(whole->codes, both->codes);
}

TEST(Pieces, SupportIsBelowThePieceAlone) {
    // The half of a box that is in front of x = 0, lifted by the part below it.
    const std::string tree = R"({"normal": [0, 0, 1], "at_mm": 0.5, "front":
        {"normal": [1, 0, 0], "at_mm": 0}})";
    const Result<Print> one = print(
        world_text(
            kPlain, R"({"box": [2, 2, 2]})", tree,
            R"([{"object": "part", "piece": "2.2", "translate_mm": [0, 0, 3]}, {"object": "part", "piece": "1", "translate_mm": [4, 0, 0]}])"),
        4);
    ASSERT_TRUE(one) << one.error().text();
    EXPECT_EQ(one->at({0.5, 0, 2}), 4);   // below the piece
    EXPECT_EQ(one->at({-0.5, 0, 2}), 0);  // below where the rest of the part would be
    EXPECT_EQ(one->at({0.5, 0, 4}), 1);
}

std::string error_of(const std::string& pieces, const std::string& build,
                     const std::string& mesh = R"({"box": [10, 10, 10]})") {
    const Result<Print> made = print(world_text(kPlain, mesh, pieces, build));
    return made ? "no error" : made.error().text();
}

TEST(Pieces, BadOnesAreToldWithPlaceAndRemedy) {
    const auto has = [](const std::string& text, const std::string& part) {
        EXPECT_NE(text.find(part), std::string::npos) << text;
    };
    const std::string all = R"([{"object": "part", "piece": "all"}])";
    std::string text = error_of(R"({"normal": [0, 0, 1], "at_mm": 10.5})", all);
    has(text, "piece `2` of object `part` is empty");
    has(text, "the mesh lies between 0 and 10 mm there");
    text = error_of(R"({"normal": [0, 0, 0], "at_mm": 0})", all);
    has(text, "is not a direction");
    text =
        error_of(R"({"normal": [0, 0, 1], "at_mm": 5})", R"([{"object": "part", "piece": "3"}])");
    has(text, "object `part` has no piece `3`");
    text = error_of(
        R"({"normal": [0, 0, 1], "at_mm": 5, "connectors": [{"peg": [4, 0, 0], "diameter_mm": 1.5, "length_mm": 2}]})",
        all);
    has(text, "the hole of the peg is 0.15 mm from the surface");
    has(text, "and 1 mm are asked for");
    text = error_of(
        R"({"normal": [0, 0, 1], "at_mm": 5, "front": {"normal": [0, 0, 1], "at_mm": 7}, "connectors": [{"dowel": [0, 0, 0], "diameter_mm": 2, "length_mm": 6}]})",
        all);
    has(text, "reaches 1.1 mm through another cut of piece `2.1`");
    text = error_of(
        R"({"normal": [0, 0, 1], "at_mm": 5, "connectors": [{"magnet": [0, 0, 0], "diameter_mm": 2, "length_mm": 2, "material": "r"}]})",
        all);
    has(text, "a magnet has no `material`");
    text = error_of(R"({"normal": [0, 0, 1], "at_mm": 5, "back": "a", "front": "a"})", all);
    has(text, "two pieces are called `a`");
    text = error_of(R"({"normal": [0, 0, 1], "at_mm": 5})",
                    R"([{"object": "part", "explode_mm": 2}])");
    has(text, "has `explode_mm` but no `piece`");
}

}  // namespace
}  // namespace openfab

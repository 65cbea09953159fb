// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Small worlds with large claims: memory and time of reading stay below their limits, whether the world
// is read or refused.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "base/messages.h"
#include "mesh/model/messages.h"
#include "tests/support/memory/meter.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/says/says.h"
#include "tests/unit/mesh/ball_mesh.h"
#include "world/messages.h"
#include "world/world.h"

namespace openfab::mesh {
namespace {

constexpr int64_t kMegabyte = 1'000'000;

#define EXPECT_SAYS(text, ...) EXPECT_THAT(text, testing::Says(__VA_ARGS__))

/// Returns the error for a world.
std::string world_refusal(const std::string& text, int64_t memory_bytes = 50 * kMegabyte) {
    const testing::TempFolder folder;
    const auto file = folder.write("w.fab.json", text);
    for (int i = 0; i < 8; ++i)
        folder.write(fmt::format("{}.stl", i), ball(60, true, false, false));
    if (text.find("large.stl") != std::string::npos)
        folder.write("large.stl", ball(100, true, false, false));
    const testing::Meter meter;
    std::string message;
    {
        const Result<world::World> world = world::load_world(file, {{}, memory_bytes});
        message = world ? "no error" : world.error().text();
    }
    EXPECT_LE(meter.peak_bytes(), memory_bytes + 4 * kMegabyte);
    EXPECT_LT(meter.seconds(), testing::kHangSeconds);
    return message;
}

std::string world_of(const std::string& meshes, const std::string& objects,
                     const std::string& build) {
    return R"({"openfab": 1, "fablets": {"f": {"source": "f.fl", "fablet": "F"}}, "meshes": {)" +
           meshes + R"(}, "objects": {)" + objects + R"(}, "build": [)" + build + "]}";
}

TEST(WorldMemory, CountsWhatAWorldHolds) {
    const std::string object = R"("o": {"mesh": "m", "fablet": "f"})";
    const std::string box = R"("m": {"box": [1, 1, 1]})";
    std::string uniforms;
    for (int i = 0; i < 3000; ++i)
        uniforms += fmt::format(R"({}"u{}": {})", i > 0 ? "," : "", i, i);
    EXPECT_SAYS(world_refusal(world_of(box, object,
                                       R"({"object": "o", "uniforms": {)" + uniforms +
                                           R"(}, "grid": {"count": [100, 100], "step_mm": 2}})")),
                world::messages::kPlacementsTakeTooMuch);
    std::string balls;
    for (int i = 0; i < 5000; ++i)
        balls += fmt::format(R"("b{}": {{"sphere": 1}},)", i);
    EXPECT_SAYS(world_refusal(world_of(balls + box, object, R"({"object": "o"})")),
                world::messages::kMeshesTakeTooMuch);
    std::string values;
    for (int i = 0; i < 900'000; ++i)
        values += "0,";
    EXPECT_SAYS(
        world_refusal(world_of(box, object, R"({"object": "o", "matrix": [)" + values + "0]}")),
        openfab::messages::kValuesTakeTooMuch);
    // Files, each of which fits.
    std::string files;
    for (int i = 0; i < 8; ++i)
        files += fmt::format(R"("m{}": {{"file": "{}.stl"}},)", i, i);
    const std::string world = world_of(files + box, object, R"({"object": "o"})");
    EXPECT_EQ(world_refusal(world, 20 * kMegabyte), "no error");
    EXPECT_SAYS(world_refusal(world, 5 * kMegabyte), messages::kTooLargeToRead);
}

#ifndef OPENFAB_SANITIZED  // is about work: it reads nothing that others do not read
TEST(WorldMemory, BoundsTheWorkThatAWorldAsksFor) {
    const std::string box = R"("m": {"box": [1, 1, 1]})";
    const std::string objects =
        R"("o": {"mesh": "m", "fablet": "f"}, "p": {"mesh": "m", "fablet": "f"})";
    // Overrides of a group: of all copies, and many of one object beside many copies of another.
    std::string all, one;
    for (int i = 0; i < 100'000; ++i) {
        if (i < 2000) all += fmt::format(R"({}"o.u{}": 1)", i > 0 ? "," : "", i);
        one += fmt::format(R"({}"p.u{}": 1)", i > 0 ? "," : "", i);
    }
    const auto grouped = [&](const std::string& uniforms) {
        std::string text =
            world_of(box, objects, R"({"group": "g", "uniforms": {)" + uniforms + "}}");
        text.insert(
            text.find(R"("build")"),
            R"("groups": {"g": [{"object": "p"}, {"object": "o", "grid": {"count": [300, 300], "step_mm": 2}}]}, )");
        return text;
    };
    EXPECT_SAYS(world_refusal(grouped(all), 200 * kMegabyte),
                world::messages::kPlacementsTakeTooMuch);
    EXPECT_EQ(world_refusal(grouped(one), 400 * kMegabyte), "no error");
    // Boxes of rotated meshes.
    std::string turned;
    for (int i = 0; i < 90'000; ++i)
        turned += fmt::format(
            R"({}{{"object": "o", "rotate_deg": [0, 0, {:.3f}], "translate_mm": [0, 0]}})",
            i > 0 ? "," : "", i * 0.004);
    EXPECT_SAYS(world_refusal(world_of(R"("m": {"file": "large.stl"})",
                                       R"("o": {"mesh": "m", "fablet": "f"})", turned),
                              2000 * kMegabyte),
                world::messages::kTooManyRotatedMeshes);
    // A file that is read for each of many meshes.
    std::string again;
    for (int i = 0; i < 10'000; ++i)
        again += fmt::format(R"("m{}": {{"file": "0.stl"}},)", i);
    EXPECT_SAYS(
        world_refusal(world_of(again + box, objects, R"({"object": "o"})"), 2000 * kMegabyte),
        world::messages::kFilesReadAgain);
    // Names, which messages and locations repeat.
    EXPECT_SAYS(world_refusal(world_of(R"(")" + std::string(1001, 'x') + R"(": {"box": [1, 1, 1]})",
                                       objects, R"({"object": "o"})")),
                world::messages::kNameTooLong, 1001, "meshes", 1000);
    // A name that differs from many similar ones.
    std::string many;
    for (int i = 0; i < 150'000; ++i)
        many += fmt::format(R"({}"{:0>200}": {{"box": [1, 1, 1]}})", i > 0 ? "," : "", i);
    EXPECT_SAYS(
        world_refusal(
            world_of(many, R"("o": {"mesh": ")" + std::string(200, 'x') + R"(", "fablet": "f"})",
                     R"({"object": "o"})"),
            2000 * kMegabyte),
        world::messages::kNoneOfName, "mesh");
}
#endif

TEST(WorldMemory, FindsNamesAmongManyAtOnce) {
    std::string meshes, objects;
    for (int i = 0; i < 60'000; ++i) {
        meshes += fmt::format(R"({}"m{}": {{"box": [1, 1, 1]}})", i > 0 ? "," : "", i);
        objects +=
            fmt::format(R"({}"o{}": {{"mesh": "m{}", "fablet": "f"}})", i > 0 ? "," : "", i, i);
    }
    EXPECT_EQ(world_refusal(world_of(meshes, objects, R"({"object": "o7"})"), 2000 * kMegabyte),
              "no error");
}

}  // namespace
}  // namespace openfab::mesh

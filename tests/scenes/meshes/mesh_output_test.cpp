// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Meshes of whole prints: the same bytes for all settings, the volume of the voxels, and no files
// if a print ends early.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <map>

#include "mesh/load/load_mesh.h"
#include "tests/scenes/scene_fixture.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr int kInterrupted = 130;

class MeshOutput : public PostcardScene {
  protected:
    static void expect_print(std::vector<std::string> arguments, const fs::path& out) {
        arguments.insert(arguments.end(), {"-o", out.string()});
        const Outcome printed = print(arguments);
        EXPECT_EQ(printed.exit_code, 0) << printed.err;
    }
    static std::vector<std::string> names_like(const std::string& part) {
        std::vector<std::string> names;
        for (const fs::directory_entry& entry : fs::directory_iterator(scratch().path())) {
            const std::string name = entry.path().filename().string();
            if (name.find(part) != std::string::npos) names.push_back(name);
        }
        return names;
    }
};

TEST_F(MeshOutput, SameBytesForAnyWayOfRunning) {
    const std::vector<std::string> pitch{"--mesh-pitch", "0.5mm"};
    expect_print({"--mesh-pitch", "0.5mm", "--threads", "1"}, scratch() / "one.3mf");
    const std::string reference = read_file(scratch() / "one.3mf");
    ASSERT_GT(reference.size(), 10'000u);
    const std::vector<std::vector<std::string>> ways{
        {"--threads", "2"},
        {"--threads", "2", "--groups-in-flight", "3"},
        {"--threads", "1", "--memory", "300MB", "--no-cull"},
        {"--isa", "sse41"},
    };
    for (std::vector<std::string> way : ways) {
        way.insert(way.end(), pitch.begin(), pitch.end());
        expect_print(way, scratch() / "other.3mf");
        EXPECT_TRUE(read_file(scratch() / "other.3mf") == reference)
            << fmt::format("{}", fmt::join(way, " "));
    }
}

/// The mesh of a print equals that of the exported voxels, and has their volume.
TEST_F(MeshOutput, HasTheVolumeOfTheVoxels) {
    expect_print({"--voxel", "0.5mm", "--dither", "floyd_steinberg"}, scratch() / "card.ofr");
    expect_print({"--mesh-pitch", "0.5mm", "--dither", "floyd_steinberg"}, scratch() / "card.3mf");
    const Outcome exported =
        run({program("openfab").string(), "export", (scratch() / "card.ofr").string(), "-o",
             (scratch() / "exported.3mf").string()},
            environment());
    ASSERT_EQ(exported.exit_code, 0) << exported.err;
    EXPECT_TRUE(read_file(scratch() / "card.3mf") == read_file(scratch() / "exported.3mf"));

    const Voxels voxels = read_ofr(scratch() / "card.ofr");
    Result<mesh::LoadedMesh> mesh = mesh::load_mesh(scratch() / "card.3mf", {});
    ASSERT_TRUE(mesh) << mesh.error().text();
    const mesh::MeshAttribute* face = mesh->mesh.find("face");
    ASSERT_NE(face, nullptr);
    std::map<std::string, double> six_volumes;
    for (size_t t = 0; t < mesh->mesh.triangles.size(); ++t) {
        const auto& corners = mesh->mesh.triangles[t];
        const auto at = [&](size_t c) { return mesh->mesh.positions[corners[c]]; };
        for (const auto& [name, number] : mesh->groups) {
            if (number == face->faces[t]) six_volumes[name] += dot(at(0), cross(at(1), at(2)));
        }
    }
    for (size_t m = 0; m < voxels.materials.size(); ++m) {
        const auto count =
            std::count(voxels.codes.begin(), voxels.codes.end(), static_cast<uint8_t>(m + 1));
        EXPECT_NEAR(six_volumes[voxels.materials[m]], 6 * 0.125 * static_cast<double>(count), 1e-6)
            << voxels.materials[m];
    }
}

/// Dithered, the front of the card would consist of specks.
TEST_F(MeshOutput, IsNotDitheredUnlessTold) {
    for (const char* dither : {"majority", "floyd_steinberg"})
        expect_print({"--mesh-pitch", "0.5mm", "--dither", dither},
                     scratch() / fmt::format("{}.3mf", dither));
    expect_print({"--mesh-pitch", "0.5mm"}, scratch() / "plain.3mf");
    const std::string plain = read_file(scratch() / "plain.3mf");
    EXPECT_TRUE(plain == read_file(scratch() / "majority.3mf"));
    EXPECT_LT(plain.size() * 2, read_file(scratch() / "floyd_steinberg.3mf").size());
}

TEST_F(MeshOutput, OneStlAMaterial) {
    expect_print({"--mesh-pitch", "0.5mm"}, scratch() / "parts.stl");
    EXPECT_THAT(names_like("parts"),
                ::testing::UnorderedElementsAre("parts_VeroWhite.stl", "parts_VeroBlack.stl"));
}

TEST_F(MeshOutput, CtrlCLeavesNoMesh) {
    for (const char* name : {"cut.3mf", "cut.stl"}) {
        RunOptions options = environment();
        options.interrupt_when = [](int, const Outcome& so_far) {
            return so_far.err.find("slice 1 of") != std::string::npos;
        };
        const Outcome outcome =
            run({binary().string(), (gallery_postcard() / "postcard.fab.json").string(),
                 "--threads", "1", "--mesh-pitch", "0.04mm", "--progress", "plain", "-o",
                 (scratch() / name).string()},
                options);
        EXPECT_EQ(outcome.exit_code, kInterrupted) << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr("none was written"));
    }
    EXPECT_THAT(names_like("cut"), ::testing::IsEmpty());
    EXPECT_THAT(names_like("mesh-"), ::testing::IsEmpty());
}

}  // namespace
}  // namespace openfab::testing

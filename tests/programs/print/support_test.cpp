// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Support as seen in the outputs: what enables it, its material, and where outputs name it.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <rapidjson/document.h>

#include <algorithm>
#include <map>

#include "backends/boundary/mesh_sink.h"
#include "backends/ofr/ofr_reader.h"
#include "base/messages.h"
#include "mesh/read/stl.h"
#include "tests/support/boundary/mesh_files.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/reference/column_scan.h"
#include "tests/support/says/says.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

struct Voxels {
    pipeline::PrintInfo info;
    std::vector<uint8_t> codes;

    int64_t count(uint8_t code) const { return std::count(codes.begin(), codes.end(), code); }
};

struct EdgeOrder {
    static std::array<int32_t, 6> key(const std::array<Vec3i, 2>& e) {
        return {e[0].x, e[0].y, e[0].z, e[1].x, e[1].y, e[1].z};
    }
    bool operator()(const std::array<Vec3i, 2>& a, const std::array<Vec3i, 2>& b) const {
        return key(a) < key(b);
    }
};

class SupportOption : public ::testing::Test {
  protected:
    SupportOption() {
        scratch_.write("f.fl", "fablet Skin {}\n");
        write_world("plain.fab.json", "");
        write_world("on.fab.json", "\"support\": true,");
        scratch_.write("own.printer.json", R"({"name": "own", "pitch_mm": [0.1, 0.1, 0.1],
            "build_volume_mm": [200, 200, 100], "native_format": "ofr", "makes_support": false,
            "support_material": {"name": "gel", "key": "#00ff80", "density_g_cm3": 1.5}})");
    }
    /// A plate on a central pin, and a floating ball beside it. The fablet is partly void near the
    /// surface.
    void write_world(const std::string& name, const std::string& keys,
                     const std::string& ball = "") {
        scratch_.write(name, fmt::format(R"({{
  "openfab": 1, "printer": "generic", {}
  "fablets": {{"f": {{"source": "f.fl", "fablet": "Skin"}}}},
  "materials": {{
    "white": {{"key": "#ffffff", "preview": "#f0f0f0ff", "density_g_cm3": 1.18}},
    "black": {{"key": "#000000", "preview": "#101010ff", "density_g_cm3": 1.18}}
  }},
  "meshes": {{"plate": {{"box": [5, 4, 0.8]}}, "pin": {{"cylinder": [1.2, 2]}}, "ball": {{"sphere": 2}}}},
  "objects": {{
    "plate": {{"mesh": "plate", "fablet": "f", "uniforms": {{"a": "white", "b": "black"}}}},
    "pin": {{"mesh": "pin", "fablet": "f", "uniforms": {{"a": "black", "b": "black"}}}},
    "ball": {{"mesh": "ball", "fablet": "f"{}, "uniforms": {{"a": "white", "b": "black"}}}}
  }},
  "build": [{{"object": "pin", "translate_mm": [0, 0]}},
            {{"object": "plate", "translate_mm": [0, 0, 2.2]}},
            {{"object": "ball", "translate_mm": [5, 0, 2.5]}}]
}}
)",
                                         keys, ball));
    }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    Outcome print(const std::string& world, const std::string& output,
                  std::vector<std::string> more = {}) {
        std::vector<std::string> argv{test_program("openfab_test_print_4"), path(world), "-o",
                                      path(output)};
        argv.insert(argv.end(), more.begin(), more.end());
        return run(argv);
    }
    Voxels read(const std::string& name) {
        Voxels out;
        const Result<std::unique_ptr<ofr::OfrReader>> reader = ofr::OfrReader::open(path(name));
        if (!reader) {
            ADD_FAILURE() << reader.error().text();
            return out;
        }
        out.info = (*reader)->info();
        Result<bool> more = true;
        while ((more = (*reader)->next()) && *more) {
            const pipeline::SliceView& slice = (*reader)->slice();
            for (int32_t y = 0; y < slice.height; ++y) {
                for (int32_t x = 0; x < slice.width; ++x)
                    out.codes.push_back(slice.code(x, y, out.info.bits));
            }
        }
        EXPECT_TRUE(more);
        return out;
    }
    Voxels printed(const std::string& world, const std::vector<std::string>& more = {}) {
        const Outcome outcome = print(world, "voxels.ofr", more);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return read("voxels.ofr");
    }
    rapidjson::Document json(const std::string& name) {
        rapidjson::Document d;
        d.Parse(read_file(scratch_ / name).c_str());
        EXPECT_FALSE(d.HasParseError()) << name;
        return d;
    }
    /// At least what the columns of the print without support require; only void became support.
    void expect_supports(const Voxels& with, const Voxels& without, uint8_t code) {
        ASSERT_EQ(with.codes.size(), without.codes.size());
        const std::vector<uint8_t> scanned =
            reference::add_support(without.codes, without.codes, without.info.size, code);
        int64_t missing = 0, changed = 0;
        for (size_t v = 0; v < scanned.size(); ++v) {
            missing += scanned[v] != 0 && with.codes[v] == 0 ? 1 : 0;
            changed += with.codes[v] != scanned[v] && with.codes[v] != code ? 1 : 0;
            changed += with.codes[v] != scanned[v] && scanned[v] != 0 ? 1 : 0;
        }
        EXPECT_EQ(missing, 0);
        EXPECT_EQ(changed, 0);
        EXPECT_GT(with.count(code), without.count(code) + 10'000);
    }

    ScratchFolder scratch_;
};

TEST_F(SupportOption, TheWorldAsksAndTheCommandLineHasTheLastWord) {
    const Voxels without = printed("plain.fab.json");
    ASSERT_EQ(without.info.materials.size(), 2u);
    const Voxels asked = printed("on.fab.json");
    ASSERT_EQ(asked.info.materials.size(), 3u);
    EXPECT_EQ(asked.info.materials[2].name, "support");
    EXPECT_EQ(asked.info.size, without.info.size);
    expect_supports(asked, without, 3);
    EXPECT_TRUE(printed("plain.fab.json", {"--support", "on"}).codes == asked.codes);

    const Voxels off = printed("on.fab.json", {"--support", "off"});
    EXPECT_TRUE(off.codes == without.codes);
    EXPECT_EQ(off.info.materials.size(), 2u);
}

TEST_F(SupportOption, IsOfAMaterialOfTheWorldWhereOneIsNamed) {
    const Voxels without = printed("plain.fab.json");
    write_world("black.fab.json", "\"support\": \"black\",");
    const Voxels black = printed("black.fab.json");
    EXPECT_EQ(black.info.materials.size(), 2u);
    expect_supports(black, without, 2);
    const Voxels white = printed("black.fab.json", {"--support", "white"});
    expect_supports(white, without, 1);
    const Outcome outcome = print("plain.fab.json", "no.ofr", {"--support", "blak"});
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_THAT(outcome.err, testing::Says(messages::kDidYouMean, "black"));
    EXPECT_FALSE(fs::exists(path("no.ofr")));
}

TEST_F(SupportOption, IsInTheSlicesWhereThePrinterMakesNone) {
    const Voxels own = printed("plain.fab.json", {"--printer", path("own.printer.json")});
    ASSERT_EQ(own.info.materials.size(), 3u);
    EXPECT_EQ(own.info.materials[2].name, "gel");
    const std::vector<uint8_t> generic = printed("on.fab.json").codes;
    EXPECT_TRUE(own.codes == generic);
    write_world("off.fab.json", "\"support\": false,");
    EXPECT_EQ(printed("off.fab.json", {"--printer", path("own.printer.json")}).count(3), 0);
}

TEST_F(SupportOption, AnObjectMayAskForNone) {
    write_world("ball.fab.json", "\"support\": true,", ", \"support\": false");
    const Voxels all = printed("on.fab.json"), some = printed("ball.fab.json");
    // Below the ball, at x of 5 mm and more, nothing; elsewhere the same.
    const Vec3i size = all.info.size;
    int64_t below = 0, different = 0;
    for (size_t v = 0; v < all.codes.size(); ++v) {
        const double x = all.info.origin_mm.x +
                         (static_cast<double>(v % static_cast<size_t>(size.x)) + 0.5) * 0.1;
        if (x > 2.6) {
            below += some.codes[v] == 3 ? 1 : 0;
        } else {
            different += some.codes[v] != all.codes[v] ? 1 : 0;
        }
    }
    EXPECT_EQ(below, 0);
    EXPECT_EQ(different, 0);
    EXPECT_GT(all.count(3), some.count(3) + 3000);
}

TEST_F(SupportOption, ManifestsEstimatesAndStatisticsCountIt) {
    const std::vector<std::string> own{"--printer", path("own.printer.json")};
    const auto with_own = [&](std::vector<std::string> more) {
        more.insert(more.end(), own.begin(), own.end());
        return more;
    };
    ASSERT_EQ(
        print("plain.fab.json", "slices",
              with_own({"--format", "png", "--stats", path("s.json"), "--preview", path("p.png")}))
            .exit_code,
        0);
    const Voxels voxels = printed("plain.fab.json", own);
    const double ml = static_cast<double>(voxels.count(3)) * 1e-6;  // voxels of 0.001 mm³
    const rapidjson::Document manifest = json("slices/manifest.json");
    EXPECT_STREQ(manifest["support_made_by"].GetString(), "slices");
    const auto& materials = manifest["materials"];
    ASSERT_EQ(materials.Size(), 3u);
    EXPECT_STREQ(materials[2]["name"].GetString(), "gel");
    EXPECT_NEAR(materials[2]["ml"].GetDouble(), ml, 1e-6);
    EXPECT_NEAR(materials[2]["g"].GetDouble(), 1.5 * ml, 1e-5);
    EXPECT_THAT(read_file(scratch_ / "slices/HANDOFF.txt"), HasSubstr("is in the slices"));

    const rapidjson::Document stats = json("s.json");
    EXPECT_EQ(stats["voxels_support"].GetInt64(), voxels.count(3));
    EXPECT_STREQ(stats["support_material"].GetString(), "gel");
    EXPECT_NEAR(stats["ml_by_material"]["gel"].GetDouble(), ml, 1e-6);
    EXPECT_EQ(stats["voxels_solid"].GetInt64(), voxels.count(1) + voxels.count(2));

    const Outcome estimated =
        print("plain.fab.json", "none", with_own({"--estimate", "--stats", path("e.json")}));
    ASSERT_EQ(estimated.exit_code, 0) << estimated.err;
    EXPECT_NEAR(json("e.json")["ml_by_material"]["gel"].GetDouble(), ml, 0.1 * ml);

    // The handoff text mentions a front end that makes its own support.
    ASSERT_EQ(print("plain.fab.json", "bare", {"--format", "png"}).exit_code, 0);
    EXPECT_STREQ(json("bare/manifest.json")["support_made_by"].GetString(), "front_end");
    ASSERT_EQ(print("on.fab.json", "both", {"--format", "png"}).exit_code, 0);
    EXPECT_STREQ(json("both/manifest.json")["support_made_by"].GetString(), "slices");
}

TEST_F(SupportOption, AnExportedPrintSaysTheSame) {
    ASSERT_EQ(print("on.fab.json", "a.ofr").exit_code, 0);
    ASSERT_EQ(print("on.fab.json", "direct", {"--format", "png"}).exit_code, 0);
    const Outcome exported =
        run({program("openfab"), "export", path("a.ofr"), "-o", path("slices")});
    ASSERT_EQ(exported.exit_code, 0) << exported.err;
    for (const char* name : {"manifest.json", "HANDOFF.txt", "slice_0003.png", "slice_0020.png"}) {
        EXPECT_TRUE(read_file(scratch_ / "direct" / name) == read_file(scratch_ / "slices" / name))
            << name;
    }
}

// Support is another closed mesh, and together all meshes tile the print.
TEST_F(SupportOption, IsAClosedMeshOfItsOwn) {
    const std::vector<std::string> pitch{"--mesh-pitch", "0.1mm"};
    const Voxels voxels = printed("on.fab.json", {"--dither", "majority"});
    VoxelBlock block(voxels.info.size);
    block.codes = voxels.codes;
    ASSERT_GT(block.count(3), 10'000);

    const Outcome package = print("on.fab.json", "part.3mf", pitch);
    ASSERT_EQ(package.exit_code, 0) << package.err;
    const CollectedMeshes meshes =
        read_threemf_meshes(read_file(scratch_ / "part.3mf"), voxels.info);
    EXPECT_EQ(meshes.count(3), 1u);
    EXPECT_EQ(check_meshes(block, meshes), "");

    const Outcome files = print("on.fab.json", "part.stl", pitch);
    ASSERT_EQ(files.exit_code, 0) << files.err;
    const fs::path support = boundary::stl_path(scratch_ / "part.stl", voxels.info, 2);
    EXPECT_EQ(support.filename(), "part_support.stl");
    // An edge along which voxels touch has four triangles in an STL, two each way.
    const Result<mesh::MeshSource> read = mesh::parse_stl(read_file(support), "part_support.stl");
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_EQ(read->mesh.triangles.size(), meshes.at(3).triangles.size());
    CollectedMesh mesh;
    std::map<std::array<Vec3i, 2>, int, EdgeOrder> edges;
    for (const auto& t : read->mesh.triangles) {
        std::array<Vec3i, 3> p;
        for (size_t c = 0; c < 3; ++c)
            p[c] = half_voxels(read->mesh.positions[t[c]], voxels.info);
        const auto first = static_cast<uint32_t>(mesh.points.size());
        mesh.points.insert(mesh.points.end(), p.begin(), p.end());
        mesh.triangles.push_back({first, first + 1, first + 2});
        for (size_t c = 0; c < 3; ++c) {
            ++edges[{p[c], p[(c + 1) % 3]}];
            --edges[{p[(c + 1) % 3], p[c]}];
        }
    }
    EXPECT_TRUE(
        std::all_of(edges.begin(), edges.end(), [](const auto& e) { return e.second == 0; }));
    EXPECT_EQ(six_volumes(mesh), 48 * block.count(3));

    ASSERT_EQ(print("on.fab.json", "off.stl", {"--support", "off"}).exit_code, 0);
    EXPECT_TRUE(fs::exists(path("off_white.stl")));
    EXPECT_FALSE(fs::exists(path("off_support.stl")));
}

}  // namespace
}  // namespace openfab::testing

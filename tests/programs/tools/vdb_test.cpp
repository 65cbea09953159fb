// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab export -o FILE.vdb`, read back by OpenVDB.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstring>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "backends/ofr/ofr_sink.h"
#include "tests/programs/print/simple_world.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/unit/backends/sample_print.h"
#include "tools/vdb/openvdb.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class Vdb : public ::testing::Test {
  protected:
    Vdb() { openvdb::initialize(); }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    Outcome export_vdb(const std::string& from, const std::vector<std::string>& more = {},
                       const RunOptions& options = {}) {
        std::vector<std::string> argv{program("openfab"), "export", path(from), "-o",
                                      path("out.vdb")};
        argv.insert(argv.end(), more.begin(), more.end());
        return run(argv, options);
    }
    void write_ofr(const SamplePrint& print, bool complete = true) {
        Result<std::unique_ptr<pipeline::SliceSink>> sink = ofr::OfrSink::create(path("a.ofr"));
        ASSERT_TRUE(sink);
        ASSERT_TRUE(print.send(sink->get(), complete));
    }
    std::map<std::string, openvdb::GridBase::Ptr> grids() {
        openvdb::io::File file(path("out.vdb"));
        file.open(false);
        std::map<std::string, openvdb::GridBase::Ptr> out;
        const openvdb::GridPtrVecPtr read = file.getGrids();
        for (const openvdb::GridBase::Ptr& grid : *read)
            out[grid->getName()] = grid;
        return out;
    }

    ScratchFolder scratch_;
};

/// Checks that a voxel's index leads to its center.
void expect_frame(const openvdb::GridBase& grid, const Vec3d& origin_mm, const Vec3d& pitch_mm) {
    for (const Vec3i& v : {Vec3i{0, 0, 0}, Vec3i{10, 20, 30}}) {
        const openvdb::Vec3d mm = grid.indexToWorld(openvdb::Coord(v.x, v.y, v.z));
        for (int a = 0; a < 3; ++a)
            EXPECT_NEAR(mm[a], origin_mm[a] + (v[a] + 0.5) * pitch_mm[a], 1e-9);
    }
    EXPECT_TRUE(grid.transform().isLinear());
}

TEST_F(Vdb, HasTheCodesOfAPrint) {
    for (const int32_t bits : {4, 8}) {
        SamplePrint print = make_sample({21, 13, 30}, bits);
        // Blocks of one material, and void ones.
        for (int32_t z = 8; z < 24; ++z) {
            for (int32_t y = 0; y < 8; ++y) {
                for (int32_t x = 0; x < 21; ++x)
                    print.at(x, y, z) = x < 8 ? 2 : 0;
            }
        }
        print.info.slice_begin = 3;
        print.info.slice_end = 28;
        write_ofr(print);
        const Outcome outcome = export_vdb("a.ofr");
        ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
        const auto read = grids();
        ASSERT_EQ(read.size(), 1u);
        const openvdb::GridBase::Ptr grid = read.at("material");
        EXPECT_EQ(grid->metaValue<std::string>("material_1"), "white");
        EXPECT_EQ(grid->metaValue<std::string>("material_3"), "clear \"x\"");
        expect_frame(*grid, print.info.origin_mm, print.info.pitch_mm);
        const auto codes = openvdb::gridPtrCast<openvdb::Int32Grid>(grid);
        ASSERT_NE(codes, nullptr);
        EXPECT_EQ(codes->background(), 0);
        auto accessor = codes->getConstAccessor();
        uint64_t solid = 0;
        for (int32_t z = -1; z < 32; ++z) {
            for (int32_t y = -1; y < 17; ++y) {
                for (int32_t x = -1; x < 25; ++x) {
                    const bool inside = x >= 0 && y >= 0 && x < 21 && y < 13 && z >= 3 && z < 28;
                    const int expected = inside ? print.at(x, y, z) : 0;
                    const openvdb::Coord at(x, y, z);
                    ASSERT_EQ(accessor.getValue(at), expected) << x << ' ' << y << ' ' << z;
                    ASSERT_EQ(accessor.isValueOn(at), expected != 0);
                    solid += expected != 0 ? 1 : 0;
                }
            }
        }
        EXPECT_EQ(codes->activeVoxelCount(), solid);
    }
}

TEST_F(Vdb, HasTheFractionsOfAPrint) {
    scratch_.write("f.fl", "fablet Skin {}\n");
    scratch_.write("w.fab.json", SimpleWorld{"Skin", R"({"sphere": 6})"}.text());
    const Outcome printed =
        run({test_program("openfab_test_print_4"), path("w.fab.json"), "--dpi", "200x150",
             "--layer", "0.1mm", "--slices", "5:31", "--fractions", path("f.npy")});
    ASSERT_EQ(printed.exit_code, 0) << printed.err;
    const Outcome outcome = export_vdb("f.npy");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const auto read = grids();
    ASSERT_EQ(read.size(), 2u);
    const std::string bytes = read_file(path("f.npy"));
    int size[3];
    const size_t shape = bytes.find("'shape': (") + 10;
    ASSERT_EQ(std::sscanf(bytes.c_str() + shape, "%d, %d, %d, 2", size, size + 1, size + 2), 3);
    ASSERT_EQ(size[0], 26);
    std::vector<float> values((bytes.size() - 128) / sizeof(float));
    std::memcpy(values.data(), bytes.data() + 128, values.size() * sizeof(float));
    for (size_t m = 0; m < 2; ++m) {
        const openvdb::GridBase::Ptr grid = read.at(m == 0 ? "white" : "black");
        EXPECT_EQ(grid->getGridClass(), openvdb::GRID_FOG_VOLUME);
        const openvdb::Vec3d pitch = grid->voxelSize();
        EXPECT_NEAR(pitch.x(), 25.4 / 200, 1e-6);
        EXPECT_NEAR(pitch.y(), 25.4 / 150, 1e-6);
        EXPECT_NEAR(pitch.z(), 0.1, 1e-6);
        const auto amounts = openvdb::gridPtrCast<openvdb::FloatGrid>(grid);
        ASSERT_NE(amounts, nullptr);
        auto accessor = amounts->getConstAccessor();
        uint64_t some = 0;
        size_t i = m;
        for (int z = 5; z < 31; ++z) {
            for (int y = 0; y < size[1]; ++y) {
                for (int x = 0; x < size[2]; ++x, i += 2) {
                    ASSERT_EQ(accessor.getValue(openvdb::Coord(x, y, z)), values[i]);
                    some += values[i] != 0 ? 1 : 0;
                }
            }
        }
        EXPECT_EQ(amounts->activeVoxelCount(), some);
        EXPECT_GT(some, 1000u);
    }
}

TEST_F(Vdb, MemoryIsBounded) {
    write_ofr(make_sample({200, 200, 100}));
    const Outcome little = export_vdb("a.ofr", {"--memory", "8MB"});
    EXPECT_EQ(little.exit_code, 1);
    EXPECT_THAT(little.err, HasSubstr("`--memory`"));
    EXPECT_FALSE(fs::exists(path("out.vdb")));
    const Outcome enough = export_vdb("a.ofr", {"--memory", "40MB"});
    EXPECT_EQ(enough.exit_code, 0) << enough.err;
}

TEST_F(Vdb, TroubleIsToldAndLeavesNothing) {
    write_ofr(make_sample({60, 60, 60}));
    RunOptions small;
    small.largest_file_bytes = 100'000;
    const Outcome full = export_vdb("a.ofr", {}, small);
    EXPECT_EQ(full.exit_code, 3);
    EXPECT_THAT(full.err, HasSubstr("File too large"));
    write_ofr(make_sample({60, 60, 60}), false);
    EXPECT_EQ(export_vdb("a.ofr").exit_code, 1);
    scratch_.write("f.npy", "\x93NUMPY");
    EXPECT_EQ(export_vdb("f.npy").exit_code, 1);
    scratch_.write("f.npy.json",
                   R"({"complete": true, "shape_zyx": [9, 9, 9], "pitch_mm": [1, 1, 1],
                       "origin_mm": [0, 0, 0], "first_slice_z": 0, "materials": [{"name": "a"}]})");
    EXPECT_THAT(export_vdb("f.npy").err, HasSubstr("is not the array"));
    EXPECT_EQ(export_vdb("a.ofr", {"--slice", "1"}).exit_code, 2);
    for (const fs::directory_entry& entry : fs::directory_iterator(scratch_.path()))
        EXPECT_FALSE(entry.path().filename().string().starts_with("out")) << entry.path();
}

}  // namespace
}  // namespace openfab::testing

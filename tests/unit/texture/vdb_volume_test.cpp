// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Grids that OpenVDB wrote, as volumes; and what `openfab export` wrote, in again.
#include "tools/vdb/vdb_volume.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>

#include "backends/raster/npy.h"
#include "backends/raster/npy_sink.h"
#include "base/vec.h"
#include "tests/fuzz/mutations/mutate.h"
#include "tests/support/long_run.h"
#include "tests/support/says/says.h"
#include "tests/unit/texture/border_reach.h"
#include "tests/unit/texture/field_test.h"
#include "tests/unit/texture/guarded_error.h"
#include "tools/texture/guarded.h"
#include "tools/texture/messages.h"
#include "tools/vdb/convert.h"
#include "tools/vdb/messages.h"
#include "tools/vdb/openvdb.h"

namespace openfab::tools {
namespace {

namespace fs = std::filesystem;

class VdbVolumeTest : public FieldTest {
  protected:
    VdbVolumeTest() { openvdb::initialize(); }
    fs::path file() const { return folder_.path() / "a.vdb"; }
    void write(const openvdb::GridPtrVec& grids, const openvdb::MetaMap& metadata = {}) const {
        openvdb::io::File out(file().string());
        out.write(grids, metadata);
        out.close();
    }
    /// The field at voxels (-2, 1, 0) to (9, 10, 8), background -7.
    static openvdb::FloatGrid::Ptr field(const openvdb::math::Mat4d& map) {
        openvdb::FloatGrid::Ptr grid = openvdb::FloatGrid::create(-7);
        grid->setName("E");
        grid->setTransform(openvdb::math::Transform::createLinearTransform(map));
        auto accessor = grid->getAccessor();
        for (int z = 0; z <= 8; ++z) {
            for (int y = 1; y <= 10; ++y) {
                for (int x = -2; x <= 9; ++x) {
                    const openvdb::Coord at(x, y, z);
                    const openvdb::Vec3d p = grid->transform().indexToWorld(at);
                    accessor.setValue(at, static_cast<float>(linear({p[0], p[1], p[2]})));
                }
            }
        }
        return grid;
    }
    std::shared_ptr<const Pyramid> converted(const VolumeOptions& options = {}) {
        const fs::path out = folder_.path() / "out.oftx";
        const Result<void> made = make_vdb_volume_file(file(), out, options);
        EXPECT_TRUE(made) << made.error().text();
        if (!made) return nullptr;
        const auto opened = Pyramid::open(out, 0, 0);
        EXPECT_TRUE(opened) << opened.error().text();
        return opened ? *opened : nullptr;
    }
    std::string trouble(const VolumeOptions& options = {}, const texture::ReadLimits& limits = {}) {
        const Result<void> made =
            make_vdb_volume_file(file(), folder_.path() / "out.oftx", options, limits);
        return made ? "no error" : made.error().text();
    }
};

/// OpenVDB's matrices act on rows: the last row translates.
openvdb::math::Mat4d map(const std::array<double, 16>& rows) {
    return openvdb::math::Mat4d(rows.data());
}
const openvdb::math::Mat4d kScaled = map({0.5, 0, 0, 0, 0, 0.25, 0, 0, 0, 0, 2, 0, 10, 20, 30, 1});

TEST_F(VdbVolumeTest, GridsAreInPlace) {
    write({field(kScaled)});
    const auto p = converted();
    ASSERT_NE(p, nullptr);
    EXPECT_EQ(size(*p), (Vec3i{12, 10, 9}));
    EXPECT_EQ(origin(*p), (Vec3d{8.75, 20.125, 29}));
    EXPECT_EQ(extent(*p), (Vec3d{6, 2.5, 18}));
    each(*p, [](const Vec3d& at, const float* value) {
        EXPECT_FLOAT_EQ(*value, static_cast<float>(linear(at)));
    });
    // By the unit that the file names, and the options' before it.
    openvdb::MetaMap metadata;
    metadata.insertMeta("unit", openvdb::StringMetadata("cm"));
    write({field(kScaled)}, metadata);
    EXPECT_EQ(extent(*converted()), (Vec3d{60, 25, 180}));
    VolumeOptions options;
    options.unit = "m";
    EXPECT_EQ(extent(*converted(options)), (Vec3d{6000, 2500, 18000}));
}

TEST_F(VdbVolumeTest, ExchangedAndTurnedAxes) {
    // Index x runs along -z, y along x, z along y.
    write({field(map({0, 0, -1, 0, 2, 0, 0, 0, 0, 0.5, 0, 0, 1, 2, 3, 1}))});
    const auto p = converted();
    ASSERT_NE(p, nullptr);
    EXPECT_EQ(size(*p), (Vec3i{10, 9, 12}));
    each(*p, [](const Vec3d& at, const float* value) {
        EXPECT_FLOAT_EQ(*value, static_cast<float>(linear(at)));
    });
    const double c = std::cos(0.3), s = std::sin(0.3);
    write({field(map({c, s, 0, 0, -s, c, 0, 0, 0, 0, 2, 0, 1, 2, 3, 1}))});
    VolumeOptions options;
    options.pitch_mm = 0.4;
    options.outside = 55;
    const auto q = converted(options);
    ASSERT_NE(q, nullptr);
    int inside = 0, outside = 0;
    const double reach = border_reach({c, s, 0}, options.pitch_mm) + 1e-6;
    each(*q, [&](const Vec3d& at, const float* value) {
        const double x = c * (at.x - 1) + s * (at.y - 2), y = -s * (at.x - 1) + c * (at.y - 2),
                     z = (at.z - 3) / 2;
        if (x > -2 && x < 9 && y > 1 && y < 10 && z > 0 && z < 8) {
            EXPECT_NEAR(*value, linear(at), 1e-5);
            ++inside;
        } else if (std::max({-2 - x, x - 9, 1 - y, y - 10}) > reach) {
            EXPECT_EQ(*value, 55);
            ++outside;
        }
    });
    EXPECT_GT(inside, 10000);
    EXPECT_GT(outside, 5000);
}

TEST_F(VdbVolumeTest, VectorsCodesAndWhatIsNotActive) {
    openvdb::Vec3SGrid::Ptr flow = openvdb::Vec3SGrid::create(openvdb::Vec3s(0));
    flow->setName("flow");
    flow->getAccessor().setValue(openvdb::Coord(0, 0, 0), openvdb::Vec3s(1, 2, 3));
    openvdb::Int32Grid::Ptr codes = openvdb::Int32Grid::create(4);
    codes->setName("codes");
    codes->getAccessor().setValue(openvdb::Coord(0, 0, 0), 9);
    codes->getAccessor().setValue(openvdb::Coord(2, 0, 0), -9);
    write({flow, codes, openvdb::BoolGrid::create()});
    EXPECT_THAT(trouble(), testing::Says(messages::kSeveralGrids));
    VolumeOptions options;
    options.field = "flow";
    const auto p = converted(options);
    ASSERT_NE(p, nullptr);
    EXPECT_EQ(p->channels(), 3);
    EXPECT_EQ(p->texels()[2], 3);
    options.field = "codes";
    const auto q = converted(options);
    EXPECT_EQ((std::vector<float>(q->texels().begin(), q->texels().begin() + 3)),
              (std::vector<float>{9, 4, -9}));
    options.outside = 0;
    EXPECT_EQ(converted(options)->texels()[1], 0);
    options.field = "none";
    EXPECT_THAT(trouble(options), testing::Says(messages::kNoSuchGrid, "none"));
}

TEST_F(VdbVolumeTest, SaysWhatIsNotRead) {
    openvdb::FloatGrid::Ptr empty = openvdb::FloatGrid::create();
    empty->setName("E");
    write({empty});
    EXPECT_THAT(trouble(), testing::Says(messages::kGridEmpty, "E"));
    empty->getAccessor().setValue(openvdb::Coord(0, 0, 0), 1);
    empty->getAccessor().setValue(openvdb::Coord(20'000, 0, 0), 1);
    write({empty});
    EXPECT_THAT(trouble(), testing::Says(messages::kGridTooLarge, "E", "20001", "x", "16384"));
    openvdb::BoolGrid::Ptr mask = openvdb::BoolGrid::create();
    mask->setName("mask");
    write({mask});
    EXPECT_THAT(trouble(), testing::Says(messages::kGridTypeNotRead, "mask", "bool"));
    openvdb::Vec3SGrid::Ptr flow = openvdb::Vec3SGrid::create();
    flow->setName("flow");
    flow->setGridClass(openvdb::GRID_STAGGERED);
    flow->getAccessor().setValue(openvdb::Coord(0, 0, 0), openvdb::Vec3s(1, 2, 3));
    write({flow});
    EXPECT_THAT(trouble(), testing::Says(messages::kGridStaggered, "flow"));
    write({field(kScaled)});
    EXPECT_THAT(trouble({}, {5000, {}}), testing::Says(messages::kTakesTooMuchMemory, "*", "5 kB"));
    folder_.write("a.vdb", "no grids");
    EXPECT_THAT(trouble(), testing::Says(messages::kCannotReadBefore));
}

TEST_F(VdbVolumeTest, IntegersThatAFloatDoesNotHoldAreTold) {
    constexpr int64_t kHeld = 16777216;  // 2^24
    for (const auto& [value, is_told] : {std::pair{kHeld, false},
                                         {kHeld + 1, true},
                                         {-kHeld - 1, true},
                                         {kHeld * kHeld, false},
                                         {(int64_t{1} << 60) + 1, true},
                                         {std::numeric_limits<int64_t>::min(), false}}) {
        SCOPED_TRACE(value);
        openvdb::Int64Grid::Ptr grid = openvdb::Int64Grid::create();
        grid->getAccessor().setValue(openvdb::Coord(0, 0, 0), value);
        write({grid});
        ::testing::internal::CaptureStderr();
        const auto read = converted();
        const std::string told = ::testing::internal::GetCapturedStderr();
        ASSERT_NE(read, nullptr);
        EXPECT_EQ(read->texels()[0], static_cast<float>(value));
        EXPECT_EQ(told.empty(), !is_told) << told;
    }
}

TEST_F(VdbVolumeTest, FractionsGoOutAndComeInAgain) {
    // Two materials on 5 x 4 x 11 voxels, slices from 3 on.
    const std::array<int64_t, 4> shape{11, 4, 5, 2};
    const std::vector<uint8_t> header = raster::npy_header("<f4", shape);
    std::string bytes(header.begin(), header.end());
    std::vector<float> first;
    std::mt19937 random(3);
    for (int i = 0; i < 11 * 4 * 5; ++i) {
        const float part = std::uniform_int_distribution(1, 255)(random) / 256.0F;
        first.push_back(part);
        for (const float value : {part, 1 - part})
            bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
    const std::string array = folder_.write("f.npy", bytes).string();
    folder_.write(
        fs::path(raster::array_json_path(array)).filename().string(),
        R"({"shape_zyx": [11, 4, 5], "pitch_mm": [0.25, 0.5, 0.125], "origin_mm": [1, 2, 3],
                      "first_slice_z": 3, "complete": true,
                      "materials": [{"name": "soft"}, {"name": "rigid"}]})");
    const Result<void> out = make_vdb_of_fractions(array, file().string(), 100'000'000);
    ASSERT_TRUE(out) << out.error().text();
    VolumeOptions options;
    options.field = "soft";
    const auto p = converted(options);
    ASSERT_NE(p, nullptr);
    EXPECT_EQ(size(*p), (Vec3i{5, 4, 11}));
    EXPECT_EQ(origin(*p), (Vec3d{1, 2, 3 + 3 * 0.125}));
    EXPECT_EQ(extent(*p), (Vec3d{1.25, 2, 11 * 0.125}));
    EXPECT_EQ(std::vector<float>(p->texels().begin(), p->texels().begin() + 220), first);
}

TEST_F(VdbVolumeTest, DamagedFilesAreErrors) {
    write({field(kScaled)});
    std::ifstream in(file(), std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(in), {}};
    const int many = testing::long_run() ? 2000 : 60;
    int wrong = 0;
    for (int seed = 0; seed < many; ++seed) {
        std::mt19937_64 random(static_cast<uint64_t>(seed));
        folder_.write("a.vdb", testing::mutate(whole, false, &random));
        const Result<void> made = guarded(50'000'000, file(), [&] {
            return make_vdb_volume_file(file(), folder_.path() / "out.oftx", {}, {50'000'000, {}});
        });
        if (made) continue;
        ++wrong;
        EXPECT_EQ(made.error().code, ErrorCode::kUserInput) << "seed " << seed;
        EXPECT_THAT(made.error().text(), SaysWhyNotRead()) << "seed " << seed;
    }
    EXPECT_GT(wrong, many / 10);
}

}  // namespace
}  // namespace openfab::tools

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// VTKHDF, laid out as VTK's writer does: a group with the place as attributes, and groups of fields within it.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <fstream>
#include <functional>
#include <iterator>
#include <numeric>
#include <random>

#include "tests/fuzz/mutations/mutate.h"
#include "tests/support/long_run.h"
#include "tests/support/says/says.h"
#include "tests/unit/texture/field_test.h"
#include "tools/hdf5/hdf5_volume.h"
#include "tools/hdf5/messages.h"
#include "tools/texture/guarded.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

namespace fs = std::filesystem;

class VtkHdfTest : public FieldTest {
  protected:
    VtkHdfTest() {
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
        file_ = H5Fcreate(path().c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
        root_ = group("/VTKHDF");
        points_ = group("/VTKHDF/PointData");
        cells_ = group("/VTKHDF/CellData");
    }
    ~VtkHdfTest() override {
        for (const hid_t id : {cells_, points_, root_})
            H5Gclose(id);
        H5Fclose(file_);
    }
    fs::path path() const { return folder_.path() / "a.vtkhdf"; }
    hid_t group(const char* name) const {
        return H5Gcreate2(file_, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    }
    static void text(hid_t of, const char* name, const std::string& value) {
        const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
        H5Tset_size(type, value.size());
        const hid_t made = H5Acreate2(of, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
        EXPECT_GE(H5Awrite(made, type, value.data()), 0);
        H5Aclose(made);
        H5Sclose(space);
        H5Tclose(type);
    }
    static void numbers(hid_t of, const char* name, const std::vector<double>& values) {
        const hsize_t count = values.size();
        const hid_t space = H5Screate_simple(1, &count, nullptr);
        if (H5Aexists(of, name) > 0) H5Adelete(of, name);
        const hid_t made = H5Acreate2(of, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT);
        EXPECT_GE(H5Awrite(made, H5T_NATIVE_DOUBLE, values.data()), 0);
        H5Aclose(made);
        H5Sclose(space);
    }
    /// 2 x 3 x 4 points, the lowest at (10, 20, 30) mm, 1 x 2 x 3 mm apart.
    void image() const {
        text(root_, "Type", "ImageData");
        numbers(root_, "WholeExtent", {0, 1, 0, 2, 0, 3});
        numbers(root_, "Origin", {10, 20, 30});
        numbers(root_, "Spacing", {1, 2, 3});
    }
    /// Writes 0, 1, 2, ... from `first` on, of sides z, y, x and components.
    void field(const std::string& name, const std::vector<hsize_t>& sides, float first = 0) const {
        std::vector<float> values(
            std::accumulate(sides.begin(), sides.end(), size_t{1}, std::multiplies<>()));
        std::iota(values.begin(), values.end(), first);
        const hid_t space = H5Screate_simple(static_cast<int>(sides.size()), sides.data(), nullptr);
        const hid_t set = H5Dcreate2(root_, name.c_str(), H5T_IEEE_F32LE, space, H5P_DEFAULT,
                                     H5P_DEFAULT, H5P_DEFAULT);
        EXPECT_GE(H5Dwrite(set, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0);
        H5Dclose(set);
        H5Sclose(space);
    }
    std::shared_ptr<const Pyramid> read(const VolumeOptions& options = {}) const {
        H5Fflush(file_, H5F_SCOPE_LOCAL);
        const fs::path out = folder_.path() / "out.oftx";
        const Result<void> made = make_hdf5_volume_file(path(), out, options);
        EXPECT_TRUE(made) << made.error().text();
        return made ? *Pyramid::open(out, 0, 0) : nullptr;
    }
    std::string wrong(const VolumeOptions& options = {}) const {
        H5Fflush(file_, H5F_SCOPE_LOCAL);
        const Result<void> made =
            make_hdf5_volume_file(path(), folder_.path() / "out.oftx", options);
        return made ? "no error" : made.error().text();
    }
    static std::vector<float> counted(size_t count, float first = 0) {
        std::vector<float> out(count);
        std::iota(out.begin(), out.end(), first);
        return out;
    }

    hid_t file_ = -1, root_ = -1, points_ = -1, cells_ = -1;
};

TEST_F(VtkHdfTest, PointsAndCellsOfImagesLieWhereTheySay) {
    image();
    field("PointData/f", {4, 3, 2});
    field("CellData/c", {3, 2, 1}, 100);
    field("PointData/v", {4, 3, 2, 3});
    VolumeOptions options;
    options.field = "f";
    const auto f = read(options);
    ASSERT_NE(f, nullptr);
    EXPECT_EQ(level0(*f), counted(24));
    // A texel reaches half a step beyond its point.
    EXPECT_EQ(domain(*f), (std::vector<float>{9.5F, 19, 28.5F, 2, 6, 12}));
    options.field = "c";
    const auto c = read(options);
    ASSERT_NE(c, nullptr);
    EXPECT_EQ(level0(*c), counted(6, 100));
    EXPECT_EQ(domain(*c), (std::vector<float>{10, 20, 30, 1, 4, 9}));
    options.field = "v";
    options.unit = "cm";
    const auto v = read(options);
    ASSERT_NE(v, nullptr);
    EXPECT_EQ(v->channels(), 3);
    EXPECT_EQ(level0(*v), counted(72));
    EXPECT_EQ(domain(*v), (std::vector<float>{95, 190, 285, 20, 60, 120}));
    EXPECT_THAT(wrong(), testing::Says(messages::kSeveralFields));
    options.field = "g";
    EXPECT_THAT(wrong(options), testing::Says(messages::kNoSuchField, "g", "`f`, `v`, `c`"));
    // What the file calls its scalars is read without a name.
    text(points_, "Scalars", "f");
    EXPECT_EQ(level0(*read()), counted(24));
}

TEST_F(VtkHdfTest, MirroredAndExchangedAxesArePutInOrder) {
    image();
    field("PointData/f", {4, 3, 2});
    // The file's x runs along y, its y against x.
    numbers(root_, "Direction", {0, -1, 0, 1, 0, 0, 0, 0, 1});
    const auto p = read();
    ASSERT_NE(p, nullptr);
    const auto values = level0(*p);
    ASSERT_EQ(size(*p).x, 3);
    ASSERT_EQ(size(*p).y, 2);
    for (int z = 0; z < 4; ++z) {
        for (int y = 0; y < 2; ++y) {
            for (int x = 0; x < 3; ++x)
                EXPECT_EQ(values[static_cast<size_t>((z * 2 + y) * 3 + x)],
                          static_cast<float>((z * 3 + 2 - x) * 2 + y));
        }
    }
    EXPECT_EQ(domain(*p), (std::vector<float>{5, 19.5F, 28.5F, 6, 2, 12}));
}

TEST_F(VtkHdfTest, WhatIsNotAnImageOfOneTimeIsRefusedByName) {
    EXPECT_THAT(wrong(), testing::Says(messages::kVtkHdfKind, ""));
    text(root_, "Type", "UnstructuredGrid");
    EXPECT_THAT(wrong(), testing::Says(messages::kVtkHdfKind, "UnstructuredGrid"));
    EXPECT_THAT(wrong(), ::testing::HasSubstr(messages::kVtkHdfKindHelp));
    H5Adelete(root_, "Type");
    text(root_, "Type", "PolyData");
    EXPECT_THAT(wrong(), testing::Says(messages::kVtkHdfKind, "PolyData"));
    EXPECT_THAT(wrong(), ::testing::HasSubstr(messages::kVtkHdfSurfaceHelp));
    H5Adelete(root_, "Type");
    image();
    EXPECT_THAT(wrong(), testing::Says(messages::kNoField));
    field("PointData/f", {2, 3, 4});
    EXPECT_THAT(wrong(),
                testing::Says(messages::kVtkHdfSides, "/VTKHDF/PointData/f", "2 3 4", "4 3 2"));
    numbers(root_, "Origin", {1, 2});
    EXPECT_THAT(wrong(), testing::Says(messages::kVtkHdfPlace));
    numbers(root_, "Origin", {1, 2, 3});
    numbers(root_, "WholeExtent", {0, 1, 0, 1e9, 0, 3});
    EXPECT_THAT(wrong(), testing::Says(messages::kExtentNotPossible));
    H5Adelete(root_, "WholeExtent");
    EXPECT_THAT(wrong(), testing::Says(messages::kExtentNotPossible, 0, -1));
}

TEST_F(VtkHdfTest, OneStepIsReadAndSeveralAreRefused) {
    image();
    field("PointData/f", {1, 4, 3, 2});
    const hid_t steps = group("/VTKHDF/Steps");
    numbers(steps, "NSteps", {1});
    EXPECT_EQ(level0(*read()), counted(24));
    numbers(steps, "NSteps", {2});
    EXPECT_THAT(wrong(), testing::Says(messages::kVtkHdfSteps, 2));
    H5Gclose(steps);
}

TEST_F(VtkHdfTest, FieldsOfOtherFilesAreNotRead) {
    image();
    folder_.write("other.h5", "");
    H5Lcreate_external((folder_.path() / "other.h5").c_str(), "/f", points_, "f", H5P_DEFAULT,
                       H5P_DEFAULT);
    EXPECT_THAT(wrong(), testing::Says(messages::kNoDataSetOfName, "/VTKHDF/PointData/f"));
}

TEST_F(VtkHdfTest, DamagedFilesAreErrors) {
    image();
    field("PointData/f", {4, 3, 2});
    H5Fflush(file_, H5F_SCOPE_LOCAL);
    std::ifstream in(path(), std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(in), {}};
    const int many = testing::long_run() ? 2500 : 60;
    int wrong = 0;
    for (int seed = 0; seed < many; ++seed) {
        std::mt19937_64 random(static_cast<uint64_t>(seed));
        const fs::path damaged = folder_.write("b.vtkhdf", testing::mutate(whole, false, &random));
        constexpr int64_t kMemory = 50'000'000;
        const Result<void> done = guarded(kMemory, damaged, [&] {
            return make_hdf5_volume_file(damaged, folder_.path() / "out.oftx", {}, {kMemory, {}});
        });
        if (done) continue;
        ++wrong;
        EXPECT_EQ(done.error().code, ErrorCode::kUserInput) << "seed " << seed;
    }
    EXPECT_GT(wrong, many / 10);
}

}  // namespace
}  // namespace openfab::tools

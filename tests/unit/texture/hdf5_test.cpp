// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// XDMF whose numbers are in HDF5 files, which the library wrote: as they lie, in chunks, compressed, of
// either byte order.
#include "tools/hdf5/hdf5_volume.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "tests/fuzz/mutations/mutate.h"
#include "tests/support/long_run.h"
#include "tests/support/says/says.h"
#include "tests/unit/texture/field_test.h"
#include "texture/messages.h"
#include "tools/hdf5/messages.h"
#include "tools/texture/guarded.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class Hdf5Test : public FieldTest {
  protected:
    Hdf5Test() {
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
        begin(0);
    }
    /// Begins a file behind a block of another's, as MATLAB's version 7.3 has one of 512 bytes.
    void begin(hsize_t block) {
        const hid_t options = H5Pcreate(H5P_FILE_CREATE);
        H5Pset_userblock(options, block);
        file_ = H5Fcreate(h5().c_str(), H5F_ACC_TRUNC, options, H5P_DEFAULT);
        H5Pclose(options);
        group_ = H5Gcreate2(file_, "mesh", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    }
    ~Hdf5Test() override { close(); }
    fs::path h5() const { return folder_.path() / "m.h5"; }
    void close() {
        if (file_ < 0) return;
        H5Gclose(group_);
        H5Fclose(file_);
        file_ = -1;
    }
    /// Writes a data set and returns the item that names it.
    template <typename T>
    std::string item(const std::string& name, const std::vector<hsize_t>& sizes,
                     const std::vector<T>& values, hid_t type, hid_t layout = H5P_DEFAULT) {
        const hid_t space = H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(), nullptr);
        const hid_t set =
            H5Dcreate2(file_, name.c_str(), type, space, H5P_DEFAULT, layout, H5P_DEFAULT);
        EXPECT_GE(set, 0);
        if (!values.empty()) {
            const hid_t memory = std::is_integral_v<T> ? H5T_NATIVE_INT64 : H5T_NATIVE_DOUBLE;
            EXPECT_GE(H5Dwrite(set, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0);
        }
        H5Dclose(set);
        H5Sclose(space);
        return named(fmt::format("{}", fmt::join(sizes, " ")), "m.h5:" + name);
    }
    static std::string named(const std::string& sizes, const std::string& text) {
        return "<DataItem Dimensions=\"" + sizes + "\" Format=\"HDF\">\n " + text + "\n</DataItem>";
    }
    /// The hexahedra, with one field of points.
    std::string file(const std::string& field) const {
        return "<Xdmf Version=\"3.0\"><Domain><Grid>"
               "<Topology TopologyType=\"Hexahedron\" NumberOfElements=\"27\">" +
               cells_ + "</Topology><Geometry GeometryType=\"XYZ\">" + points_ +
               "</Geometry><Attribute Name=\"E\" Center=\"Node\">" + field +
               "</Attribute></Grid></Domain></Xdmf>\n";
    }
    void write_mesh(hid_t layout = H5P_DEFAULT) {
        cells_ = item("/mesh/cells", {27, 8}, mesh_.corners, H5T_STD_I32BE);
        points_ = item("/mesh/points", {64, 3}, mesh_.points, H5T_IEEE_F64LE, layout);
    }
    std::vector<double> values() const {
        std::vector<double> out;
        for (size_t i = 0; i < mesh_.point_count(); ++i)
            out.push_back(linear(mesh_.point(i)));
        return out;
    }
    Result<void> made(const std::string& text, const VolumeOptions& options = {}) const {
        return make_hdf5_volume_file(folder_.write("m.xdmf", text), folder_.path() / "out.oftx",
                                     options);
    }
    std::string wrong(const std::string& field) {
        H5Fflush(file_, H5F_SCOPE_LOCAL);
        const Result<void> done = made(file(field));
        return done ? "no error" : done.error().text();
    }
    void expect_linear(const std::string& text, double near) {
        close();
        VolumeOptions options;
        options.pitch_mm = 0.21;
        const Result<void> done = made(text, options);
        ASSERT_TRUE(done) << done.error().text();
        const auto opened = Pyramid::open(folder_.path() / "out.oftx", 0, 0);
        ASSERT_TRUE(opened);
        int inside = 0;
        each(**opened, [&](const Vec3d& at, const float* value) {
            if (at.x > 2 || at.y > 3 || at.z > 5) return;
            ++inside;
            EXPECT_NEAR(*value, linear(at), near);
        });
        EXPECT_EQ(inside, 14 * 14 * 14);
    }

    const BlockMesh mesh_ = block(12);
    std::string cells_, points_;
    hid_t file_ = -1, group_ = -1;
};

TEST_F(Hdf5Test, LinearFieldsComeBack) {
    write_mesh();
    expect_linear(file(item("/E", {64}, values(), H5T_IEEE_F64BE)), 2e-6);
}

TEST_F(Hdf5Test, ChunksThatArePackedComeBackToo) {
    const hid_t packed = H5Pcreate(H5P_DATASET_CREATE), row = H5Pcreate(H5P_DATASET_CREATE);
    const std::array<hsize_t, 2> chunk{5, 2}, wide{1, 7};
    H5Pset_chunk(packed, 2, chunk.data());
    H5Pset_shuffle(packed);
    H5Pset_deflate(packed, 6);
    H5Pset_chunk(row, 2, wide.data());
    write_mesh(packed);
    expect_linear(file(item("/E", {1, 64}, values(), H5T_IEEE_F32LE, row)), 4e-6);
    H5Pclose(packed);
    H5Pclose(row);
}

/// Lays a set out in one of four ways.
hid_t laid_out(int way) {
    const hid_t out = H5Pcreate(H5P_DATASET_CREATE);
    const std::array<hsize_t, 3> chunk{2, 3, 3};
    if (way == 1) H5Pset_layout(out, H5D_COMPACT);
    if (way >= 2) H5Pset_chunk(out, 3, chunk.data());
    if (way == 3) {
        H5Pset_shuffle(out);
        H5Pset_deflate(out, 9);
        H5Pset_fletcher32(out);
    }
    return out;
}

TEST_F(Hdf5Test, NumbersOfEachKindComeBackInEachLayout) {
    std::vector<double> wanted;
    for (int i = 0; i < 60; ++i)
        wanted.push_back(2 * i);
    const hid_t truth = H5Tenum_create(H5T_STD_I8LE);  // as h5py writes truth values
    for (int8_t value = 0; value < 120; ++value)
        H5Tenum_insert(truth, fmt::format("v{}", value).c_str(), &value);
    const std::vector<int8_t> bytes(wanted.begin(), wanted.end());
    int sets = 0;
    for (const hid_t type :
         {H5T_STD_I8LE, H5T_STD_U8LE, H5T_STD_I16LE, H5T_STD_I16BE, H5T_STD_U16LE, H5T_STD_U16BE,
          H5T_STD_I32LE, H5T_STD_I32BE, H5T_STD_U32LE, H5T_STD_U32BE, H5T_STD_I64LE, H5T_STD_I64BE,
          H5T_STD_U64LE, H5T_STD_U64BE, H5T_IEEE_F32LE, H5T_IEEE_F32BE, H5T_IEEE_F64LE,
          H5T_IEEE_F64BE, truth}) {
        for (int way = 0; way < 4; ++way) {
            SCOPED_TRACE(::testing::Message() << "type " << sets / 4 << ", layout " << way);
            const std::string name = fmt::format("/n{}", sets++);
            const hid_t layout = laid_out(way);
            const std::string numbers =
                item(name, {3, 4, 5}, type == truth ? std::vector<double>() : wanted, type, layout);
            if (type == truth) {
                const hid_t set = H5Dopen2(file_, name.c_str(), H5P_DEFAULT);
                EXPECT_GE(H5Dwrite(set, truth, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()), 0);
                H5Dclose(set);
            }
            H5Pclose(layout);
            H5Fflush(file_, H5F_SCOPE_LOCAL);
            const Result<void> done = made(
                "<Xdmf><Domain><Grid><Topology TopologyType=\"3DCoRectMesh\" Dimensions=\"3 4 5\"/>"
                "<Geometry GeometryType=\"ORIGIN_DXDYDZ\"><DataItem Dimensions=\"3\">0 0 "
                "0</DataItem>"
                "<DataItem Dimensions=\"3\">1 1 1</DataItem></Geometry><Attribute Name=\"E\">" +
                numbers + "</Attribute></Grid></Domain></Xdmf>");
            ASSERT_TRUE(done) << done.error().text();
            const auto opened = Pyramid::open(folder_.path() / "out.oftx", 0, 0);
            ASSERT_TRUE(opened);
            EXPECT_TRUE(std::equal(wanted.begin(), wanted.end(), (*opened)->texels().begin()));
        }
    }
    H5Tclose(truth);
}

TEST_F(Hdf5Test, ASetOfOtherSidesThanTheGridIsRefusedWhateverTheFieldSays) {
    std::vector<double> numbers(60);
    const auto outcome = [&](const std::vector<hsize_t>& sides, const std::string& dimensions) {
        const std::string name = fmt::format("/d{}", fmt::join(sides, "_"));
        item(name, sides, numbers, H5T_IEEE_F32LE);
        H5Fflush(file_, H5F_SCOPE_LOCAL);
        const Result<void> done = made(
            "<Xdmf><Domain><Grid><Topology TopologyType=\"3DCoRectMesh\" Dimensions=\"3 4 5\"/>"
            "<Geometry GeometryType=\"ORIGIN_DXDYDZ\"><DataItem Dimensions=\"3\">0 0 0</DataItem>"
            "<DataItem Dimensions=\"3\">1 1 1</DataItem></Geometry><Attribute Name=\"E\">" +
            named(dimensions, "m.h5:" + name) + "</Attribute></Grid></Domain></Xdmf>");
        return done ? std::string("no error") : done.error().text();
    };
    EXPECT_EQ(outcome({3, 4, 5}, "60"), "no error");
    EXPECT_EQ(outcome({60}, "60"), "no error");
    EXPECT_EQ(outcome({12, 5}, "3 4 5"), "no error");
    for (const std::vector<hsize_t>& sides :
         {std::vector<hsize_t>{5, 4, 3}, {4, 3, 5}, {15, 4}, {5, 12}})
        EXPECT_THAT(
            outcome(sides, "60"),
            testing::Says(messages::kDataSetSides, fmt::format("/d{}", fmt::join(sides, "_")),
                          fmt::format("{}", fmt::join(sides, " ")), "3 4 5 1"));
}

TEST_F(Hdf5Test, PartsOfDataSetsAreRead) {
    // Chunks that were never written claim nothing, and no memory.
    const hid_t chunked = H5Pcreate(H5P_DATASET_CREATE);
    const std::array<hsize_t, 3> chunk{2, 7, 1};
    H5Pset_chunk(chunked, 3, chunk.data());
    write_mesh();
    // Row 3 of 5 steps, every second number from the fourth on, second of two components.
    std::vector<double> all(size_t{5} * 140 * 2, -7);
    const std::vector<double> field = values();
    for (size_t i = 0; i < field.size(); ++i)
        all[(3 * 140 + 4 + 2 * i) * 2 + 1] = field[i];
    const std::string contiguous = item("/E", {5, 140, 2}, all, H5T_IEEE_F64LE);
    const std::string chunks = item("/C", {5, 140, 2}, all, H5T_IEEE_F64BE, chunked);
    H5Pclose(chunked);
    const auto part = [](const std::string& which, const std::string& of) {
        return "<DataItem ItemType=\"HyperSlab\" Dimensions=\"64\"><DataItem>" + which +
               "</DataItem>" + of + "</DataItem>";
    };
    EXPECT_THAT(wrong(part("3 1 4 1 1 1 1 1 64", named("5 2 140", "m.h5:/E"))),
                testing::Says(messages::kDataSetSides, "/E", "5 140 2", "5 2 140"));
    const std::string which = "3 4 1  1 2 1  1 64 1";
    EXPECT_EQ(wrong(part(which, contiguous)), "no error");
    expect_linear(file(part(which, chunks)), 2e-6);
    expect_linear(file(part(which, contiguous)), 2e-6);
}

TEST_F(Hdf5Test, ReadsNothingFromOtherFiles) {
    write_mesh();
    const std::string outside = (folder_.path() / "outside.bin").string();
    folder_.write("outside.bin", std::string(512, 'a'));
    const hid_t external = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_external(external, outside.c_str(), 0, 512);
    EXPECT_THAT(wrong(item("/E", {64}, std::vector<double>(), H5T_IEEE_F64LE, external)),
                testing::Says(messages::kNumbersElsewhere, "/E"));
    H5Pclose(external);

    const hid_t other =
        H5Fcreate((folder_.path() / "other.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const hsize_t count = 64;
    const hid_t space = H5Screate_simple(1, &count, nullptr);
    const hid_t set =
        H5Dcreate2(other, "/F", H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    EXPECT_GE(H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values().data()), 0);
    H5Dclose(set);
    H5Fclose(other);
    H5Lcreate_external("other.h5", "/F", file_, "/F", H5P_DEFAULT, H5P_DEFAULT);
    const hid_t follows = H5Dopen2(file_, "/F", H5P_DEFAULT);
    EXPECT_GE(follows, 0) << "the link itself is sound";
    H5Dclose(follows);
    EXPECT_THAT(wrong(named("64", "m.h5:/F")), testing::Says(messages::kNumbersElsewhere, "/F"));

    const hid_t mapped = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_virtual(mapped, space, "other.h5", "/F", space);
    EXPECT_THAT(wrong(item("/V", {64}, std::vector<double>(), H5T_IEEE_F64LE, mapped)),
                testing::Says(messages::kNumbersElsewhere, "/V"));
    H5Pclose(mapped);
    H5Sclose(space);
    EXPECT_THAT(wrong(named("64", "../m.h5:/E")),
                ::testing::HasSubstr(
                    fmt::format(messages::kCannotBeRead, fmt::format(messages::kItsField, "E")) +
                    fmt::format(texture::messages::kDataFileUnreadable, "../m.h5")));
}

TEST_F(Hdf5Test, SaysWhatIsWrong) {
    write_mesh();
    item("/E", {64}, values(), H5T_IEEE_F64LE);
    EXPECT_THAT(wrong(named("64", "m.h5:/none")),
                testing::Says(messages::kNoDataSetOfName, "/none"));
    EXPECT_THAT(wrong(named("64", "m.h5:/mesh")),
                testing::Says(messages::kNoDataSetOfName, "/mesh"));
    EXPECT_THAT(wrong(named("128", "m.h5:/E")),
                testing::Says(messages::kDataSetCount, "/E", "128"));
    EXPECT_THAT(wrong(named("64", "m.h5")), testing::Says(texture::messages::kNoDataFile));
    // Numbers in another order than the file says, and sides that are only taken together.
    item("/S", {8, 2, 4}, values(), H5T_IEEE_F64LE);
    for (const char* sides : {"4 16", "4 2 8", "32 2"})
        EXPECT_THAT(wrong(named(sides, "m.h5:/S")),
                    testing::Says(messages::kDataSetSides, "/S", "8 2 4", sides));
    for (const char* sides : {"64", "8 8", "16 4", "1 64 1", "8 2 2 2"})
        EXPECT_EQ(wrong(named(sides, "m.h5:/S")), "no error") << sides;
    EXPECT_THAT(wrong(named("64", "m.xdmf:/E")), testing::Says(messages::kNotHdf5));
    const hid_t text = H5Tcopy(H5T_C_S1);
    H5Tset_size(text, 8);
    EXPECT_THAT(wrong(item("/text", {64}, std::vector<double>(), text)),
                testing::Says(messages::kDataSetWithoutNumbers, "/text"));
    H5Tclose(text);
    // Chunks that were never written claim nothing, and no memory.
    const hid_t chunked = H5Pcreate(H5P_DATASET_CREATE);
    const hsize_t chunk = 1024;
    H5Pset_chunk(chunked, 1, &chunk);
    EXPECT_THAT(
        wrong(item("/claimed", {hsize_t{1} << 36}, std::vector<double>(), H5T_IEEE_F64LE, chunked)),
        testing::Says(messages::kFieldComponents, "E", "1073741824"));
    H5Pclose(chunked);
}

class Hdf5BlockTest : public Hdf5Test, public ::testing::WithParamInterface<int> {
  protected:
    /// The file behind the block, whose words MATLAB begins it with.
    std::string whole(std::string* text) {
        close();
        begin(static_cast<hsize_t>(GetParam()));
        write_mesh();
        *text = file(item("/E", {64}, values(), H5T_IEEE_F64LE));
        close();
        std::ifstream in(h5(), std::ios::binary);
        std::string bytes{std::istreambuf_iterator<char>(in), {}};
        if (GetParam() > 0) bytes.replace(0, 19, "MATLAB 7.3 MAT-file");
        folder_.write("m.h5", bytes);
        return bytes;
    }
};

INSTANTIATE_TEST_SUITE_P(OfAnotherFile, Hdf5BlockTest, ::testing::Values(0, 512, 1024));

TEST_P(Hdf5BlockTest, IsPassedOver) {
    std::string text;
    whole(&text);
    expect_linear(text, 2e-6);
}

TEST_P(Hdf5BlockTest, DamagedFilesAreErrors) {
    std::string text;
    const std::string bytes = whole(&text);
    const fs::path xdmf = folder_.write("m.xdmf", text);
    const int many = testing::long_run() ? 1000 : 40;
    int wrong = 0;
    for (int seed = 0; seed < many; ++seed) {
        std::mt19937_64 random(static_cast<uint64_t>(seed));
        folder_.write("m.h5", testing::mutate(bytes, false, &random));
        const Result<void> done = guarded(50'000'000, xdmf, [&] {
            return make_hdf5_volume_file(xdmf, folder_.path() / "out.oftx", {}, {50'000'000, {}});
        });
        if (done) continue;
        ++wrong;
        EXPECT_EQ(done.error().code, ErrorCode::kUserInput) << "seed " << seed;
        EXPECT_THAT(done.error().text(), testing::Says(messages::kCannotReadBefore))
            << "seed " << seed;
    }
    EXPECT_GT(wrong, many / 10);
}

}  // namespace
}  // namespace openfab::tools

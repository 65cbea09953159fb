// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// VTK's older files, written here as its own writers do, as text and as bytes: a field that is linear in
// space must come back as such.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "tests/support/says/says.h"
#include "tests/unit/texture/field_test.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

/// Writes numbers, in either coding.
class Writer {
  public:
    explicit Writer(bool binary) : binary_(binary) {}

    std::string head() const {
        return std::string("# vtk DataFile Version 4.2\nof a test\n") +
               (binary_ ? "BINARY\n" : "ASCII\n");
    }
    template <typename T>
    std::string numbers(const std::vector<T>& values) const {
        if (!binary_) return fmt::format("{}\n", fmt::join(values, " "));
        std::string out;
        for (const T value : values) {
            std::array<char, sizeof(T)> at{};
            std::memcpy(at.data(), &value, sizeof value);
            std::reverse(at.begin(), at.end());
            out.append(at.data(), at.size());
        }
        return out + "\n";
    }
    /// The lengths of texts stand before them in bytes, here below 64.
    std::string texts(const std::vector<std::string>& values) const {
        std::string out;
        for (const std::string& value : values)
            out += binary_ ? static_cast<char>(0xC0 | value.size()) + value : value + "\n";
        return out + "\n";
    }

  private:
    bool binary_;
};

using VtkLegacyTest = FieldTest;

TEST_F(VtkLegacyTest, StructuredPointsAreReadInEveryForm) {
    for (const bool binary : {false, true}) {
        const Writer w(binary);
        std::vector<double> of_points;
        std::vector<int16_t> of_cells;
        std::vector<float> vectors;
        for (int z = 0; z < 2; ++z) {
            for (int y = 0; y < 3; ++y) {
                for (int x = 0; x < 4; ++x) {
                    of_points.push_back(linear({1 + 0.5 * x, 2.0 + y, 3 + 2.0 * z}));
                    vectors.insert(vectors.end(), {float(x), float(y), float(z)});
                }
            }
        }
        for (int16_t i = 0; i < 6; ++i)
            of_cells.push_back(static_cast<int16_t>(100 * i));
        const auto file = folder_.write(
            "p.vtk",
            w.head() + "FIELD FieldData 1\nTIME 1 1 double\n" + w.numbers<double>({7}) +
                "DATASET structured_points\nDIMENSIONS 4 3 2\nOrigin 1 2 3\nASPECT_RATIO 0.5 1 2\n"
                "Cell_Data 6\nFIELD more 2\nnames 1 6 string\n" +
                w.texts({"a", "b b", "", "d", "e", "f"}) + "n%20o 1 6 short\n" +
                w.numbers(of_cells) +
                "METADATA\nINFORMATION 1\nNAME L2_NORM_RANGE LOCATION vtkDataArray\nDATA 2 0 1\n\n"
                "POINT_DATA 24\nSCALARS E double 1\nLOOKUP_TABLE colours\n" +
                w.numbers(of_points) + "LOOKUP_TABLE colours 2\n" +
                (binary ? std::string(8, '\x7f') + "\n" : "0 0 0 1 1 1 1 1\n") +
                "VECTORS v float\n" + w.numbers(vectors));
        const auto p = converted(file);  // the scalars
        ASSERT_NE(p, nullptr);
        EXPECT_EQ(size(*p), (Vec3i{4, 3, 2}));
        each(*p,
             [](const Vec3d& at, const float* value) { EXPECT_NEAR(*value, linear(at), 2e-6); });
        VolumeOptions options;
        options.field = "n o";
        const auto cells = converted(file, options);
        ASSERT_NE(cells, nullptr);
        EXPECT_EQ(level0(*cells), (std::vector<float>{0, 100, 200, 300, 400, 500}));
        EXPECT_EQ(domain(*cells), (std::vector<float>{1, 2, 3, 1.5, 2, 2}));
        options.field = "v";
        const auto of_vectors = converted(file, options);
        ASSERT_NE(of_vectors, nullptr);
        EXPECT_EQ(level0(*of_vectors), vectors);
        options.field = "names";
        EXPECT_EQ(trouble(file, options),
                  fmt::format(messages::kNoSuchField, "names", "`E`, `v`, `n o`"));
    }
}

TEST_F(VtkLegacyTest, ColoursAreTheSameNumbersAsTextAndAsBytes) {
    const std::string head =
        "DATASET STRUCTURED_POINTS\nDIMENSIONS 3 1 1\nORIGIN 0 0 0\nSPACING 1 1 1\n"
        "POINT_DATA 3\nCOLOR_SCALARS c 1\n";
    for (const bool binary : {false, true}) {
        const auto file = folder_.write(
            "c.vtk", Writer(binary).head() + head +
                         (binary ? std::string("\0\x33\xff", 3) : std::string("0 0.2 1\n")));
        const auto p = converted(file);
        ASSERT_NE(p, nullptr);
        EXPECT_THAT(level0(*p), ::testing::ElementsAre(0, ::testing::FloatEq(51), 255)) << binary;
    }
}

TEST_F(VtkLegacyTest, OtherGridsAreSampled) {
    const BlockMesh mesh = block(12);
    for (const bool binary : {false, true}) {
        const Writer w(binary);
        // A block of hexahedra, in the older and the newer form of cells, and as a curvilinear grid.
        std::vector<double> values;
        for (size_t i = 0; i < mesh.point_count(); ++i)
            values.push_back(linear(mesh.point(i)));
        std::vector<int32_t> cells, types(mesh.types.begin(), mesh.types.end());
        for (size_t i = 0; i < mesh.types.size(); ++i) {
            cells.push_back(8);
            cells.insert(cells.end(), mesh.corners.begin() + static_cast<long>(8 * i),
                         mesh.corners.begin() + static_cast<long>(8 * i + 8));
        }
        // A line beside them, which is left out.
        cells.insert(cells.end(), {2, 0, 1});
        types.push_back(3);
        std::vector<int64_t> ends{0}, corners = mesh.corners;
        ends.insert(ends.end(), mesh.ends.begin(), mesh.ends.end());
        corners.insert(corners.end(), {0, 1});
        ends.push_back(static_cast<int64_t>(corners.size()));
        const std::string points =
            fmt::format("POINTS {} double\n", mesh.point_count()) + w.numbers(mesh.points);
        const std::string scalars =
            fmt::format("POINT_DATA {}\nSCALARS E double\nLOOKUP_TABLE default\n", values.size()) +
            w.numbers(values);
        const std::string types_text =
            fmt::format("CELL_TYPES {}\n", types.size()) + w.numbers(types);
        const std::array<std::string, 3> grids{
            "DATASET UNSTRUCTURED_GRID\n" + points +
                fmt::format("CELLS {} {}\n", types.size(), cells.size()) + w.numbers(cells) +
                types_text,
            "DATASET UNSTRUCTURED_GRID\n" + points +
                fmt::format("CELLS {} {}\nOFFSETS vtktypeint64\n", ends.size(), corners.size()) +
                w.numbers(ends) + "CONNECTIVITY vtktypeint64\n" + w.numbers(corners) + types_text,
            "DATASET STRUCTURED_GRID\nDIMENSIONS 4 4 4\n" + points};
        for (const std::string& grid : grids) {
            VolumeOptions options;
            options.pitch_mm = 0.25;
            const auto p = converted(folder_.write("g.vtk", w.head() + grid + scalars), options);
            ASSERT_NE(p, nullptr);
            EXPECT_EQ(size(*p), (Vec3i{12, 12, 12}));
            each(*p, [](const Vec3d& at, const float* value) {
                EXPECT_NEAR(*value, linear(at), 4e-6);
            });
        }
        const auto crossed = converted(folder_.write(
            "r.vtk",
            w.head() + "DATASET RECTILINEAR_GRID\nDIMENSIONS 2 3 2\nX_COORDINATES 2 float\n" +
                w.numbers<float>({0, 1}) + "Y_COORDINATES 3 float\n" + w.numbers<float>({0, 1, 3}) +
                "Z_COORDINATES 2 int\n" + w.numbers<int32_t>({0, 1}) +
                "CELL_DATA 2\nSCALARS c unsigned_char 1\n"
                "LOOKUP_TABLE default\n" +
                w.numbers<uint8_t>({7, 200})));
        ASSERT_NE(crossed, nullptr);
        each(*crossed, [](const Vec3d& at, const float* value) {
            EXPECT_EQ(*value, at.y < 1 ? 7.0F : 200.0F);
        });
    }
}

TEST_F(VtkLegacyTest, SaysWhatIsWrong) {
    const auto with = [&](const std::string& text) {
        return trouble(folder_.write("w.vtk", "# vtk DataFile Version 3.0\nof a test\n" + text));
    };
    const std::string grid = "ASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 1 1\n";
    const std::string one = grid + "POINT_DATA 2\nSCALARS a float\nLOOKUP_TABLE t\n";
    EXPECT_EQ(with(one + "1 2"), "no error");
    EXPECT_EQ(with(grid + "POINT_DATA 2\nSCALARS a float\n1 2"), "no error") << "without a table";
    EXPECT_EQ(with(one + "1"), fmt::format(messages::kAtLine, 8, messages::kArrayCutShort));
    EXPECT_EQ(with(one + "1 x"), fmt::format(messages::kNumberNotFinite, "x"));
    EXPECT_EQ(with("TEXT\n"), fmt::format(messages::kAtLine, 3,
                                          fmt::format(messages::kNeitherAsciiNorBinary, "TEXT")));
    EXPECT_EQ(with("ASCII\n"), messages::kNoDataSet);
    EXPECT_EQ(with("ASCII\nDATASET POLYDATA\n"),
              fmt::format(messages::kAtLine, 4, messages::kIsASurface) + "; " +
                  messages::kIsASurfaceHelp);
    EXPECT_EQ(with("ASCII\nDATASET FIELD\n"),
              fmt::format(messages::kAtLine, 4, fmt::format(messages::kDataSetNotRead, "FIELD")));
    EXPECT_EQ(
        with(grid + "BLANKING 1\n"),
        fmt::format(messages::kAtLine, 6, fmt::format(messages::kUnknownKeyword, "blanking")));
    EXPECT_EQ(with(grid), messages::kNoField);
    EXPECT_EQ(with(grid + "POINT_DATA 3\nSCALARS a float\n1 2 3"),
              fmt::format(messages::kArrayCount, "a", 3, 2));
    EXPECT_EQ(
        with(one + "1 2\nSCALARS b float\nLOOKUP_TABLE t\n1 2\n"),
        fmt::format(messages::kSeveralFields, "`a`, `b`") + "; " + messages::kSeveralFieldsChoose);
    EXPECT_EQ(
        with(grid + "POINT_DATA 2\nSCALARS a variant\n1 2"),
        fmt::format(messages::kAtLine, 7, fmt::format(messages::kUnknownNumberType, "variant")));
    EXPECT_EQ(with("BINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 1 1\nPOINT_DATA 2\n"
                   "SCALARS a float\nLOOKUP_TABLE t\n1234"),
              messages::kArrayCutShort);
    EXPECT_THAT(with("ASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 1 float\n0 0 0\nCELLS 1 3\n9 0 0\n"
                     "CELL_TYPES 1\n12\nCELL_DATA 1\nSCALARS a int\n1\n"),
                testing::Says(messages::kCornersBeyondCells));
}

}  // namespace
}  // namespace openfab::tools

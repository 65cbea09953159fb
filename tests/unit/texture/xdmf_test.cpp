// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// XDMF, written here: fields that are linear in space must come back as such, from text and from data
// files of either byte order.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "base/messages.h"
#include "tests/support/says/says.h"
#include "tests/unit/texture/xdmf_files.h"
#include "texture/messages.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

TEST_F(XdmfTest, LinearFieldsOnCellsComeBackInEveryForm) {
    for (const int type : {10, 12, 13}) {
        for (const Form form : kForms) {
            SCOPED_TRACE(fmt::format("{} {}", type, static_cast<int>(form)));
            const BlockMesh mesh = block(type);
            XdmfWriter writer(form, folder_);
            expect_linear(file(grid(
                points_of(mesh, &writer) + cells_of(mesh, &writer) +
                attribute("other", "Node", writer.item(kFloat32, "64", std::vector<float>(64, 7))) +
                attribute("E", "Node", writer.item(kFloat64, "64 1", field_of(mesh))))));
        }
    }
}

TEST_F(XdmfTest, NamesItsDocumentTypeAsVersionTwoDoes) {
    const BlockMesh mesh = block(12);
    XdmfWriter writer(Form::kText, folder_);
    std::string text =
        file(grid(points_of(mesh, &writer) + cells_of(mesh, &writer) +
                  attribute("E", "Node", writer.item(kFloat64, "64", field_of(mesh)))));
    text.insert(text.find("<Xdmf"), "<!DOCTYPE Xdmf SYSTEM \"Xdmf.dtd\" []>\n");
    expect_linear(text);
}

TEST_F(XdmfTest, MixedCellsAndPointsInThreeArrays) {
    const BlockMesh mesh = block(12);
    for (const Form form : kForms) {
        XdmfWriter writer(form, folder_);
        // A point, a line and a face beside the cells; points counted from 1.
        std::vector<int32_t> numbers{1, 1, 1, 2, 2, 1, 2, 4, 1, 2, 3};
        for (size_t cell = 0; cell < mesh.types.size(); ++cell) {
            numbers.push_back(9);
            for (size_t k = 8 * cell; k < 8 * cell + 8; ++k)
                numbers.push_back(static_cast<int32_t>(mesh.corners[k] + 1));
        }
        std::array<std::vector<double>, 3> axes;
        for (size_t i = 0; i < mesh.points.size(); ++i)
            axes[i % 3].push_back(mesh.points[i]);
        std::string geometry = "<Geometry Type=\"X_Y_Z\">";
        for (const std::vector<double>& axis : axes)
            geometry += writer.item(kFloat64, "64", axis);
        const std::string cells =
            "<Topology Type=\"Mixed\" NumberOfElements=\"30\" BaseOffset=\"1\">" +
            writer.item(R"(NumberType="Int")", std::to_string(numbers.size()), numbers) +
            "</Topology>";
        expect_linear(
            file(grid(cells + geometry + "</Geometry>" +
                      attribute("E", "Node", writer.item(kFloat64, "64", field_of(mesh))))));
        // Values of cells: those of the flat ones are left out.
        std::vector<int16_t> values{-1, -2, -3};
        for (int16_t i = 0; i < 27; ++i)
            values.push_back(i);
        VolumeOptions options;
        options.pitch_mm = 1;
        const auto p = converted(
            folder_.write(
                "c.xmf", file(grid(cells + geometry + "</Geometry>" +
                                   attribute("c", "Cell",
                                             writer.item(R"(NumberType="Short")", "30", values))))),
            options);
        ASSERT_NE(p, nullptr);
        for (size_t i = 0; i < 27; ++i)
            EXPECT_EQ(p->texels()[i], static_cast<float>(i));
    }
}

TEST_F(XdmfTest, RegularGridsAreInPlace) {
    for (const Form form : kForms) {
        XdmfWriter writer(form, folder_);
        const std::string frame =
            "<Topology TopologyType=\"3DCoRectMesh\" Dimensions=\"2 3 4\"/>"
            "<Geometry GeometryType=\"ORIGIN_DXDYDZ\">" +
            writer.item(kFloat64, "3", std::vector<double>{30, 20, 10}) +
            writer.item(kFloat64, "3", std::vector<double>{2, 0.25, 0.5}) + "</Geometry>";
        std::vector<float> values, vectors;
        for (int z = 0; z < 2; ++z) {
            for (int y = 0; y < 3; ++y) {
                for (int x = 0; x < 4; ++x)
                    values.push_back(
                        static_cast<float>(linear({10 + 0.5 * x, 20 + 0.25 * y, 30 + 2.0 * z})));
            }
        }
        for (int i = 0; i < 18; ++i)
            vectors.push_back(static_cast<float>(i));
        const auto written = folder_.write(
            "a.xdmf",
            file(grid(frame + attribute("E", "Node", writer.item(kFloat32, "2 3 4", values)) +
                      attribute("v", "Cell", writer.item(kFloat32, "1 2 3 3", vectors)))));
        VolumeOptions options;
        options.field = "E";
        const auto p = converted(written, options);
        ASSERT_NE(p, nullptr);
        EXPECT_EQ(size(*p), (Vec3i{4, 3, 2}));
        EXPECT_EQ(origin(*p), (Vec3d{9.75, 19.875, 29}));
        each(*p, [](const Vec3d& at, const float* value) {
            EXPECT_FLOAT_EQ(*value, static_cast<float>(linear(at)));
        });
        const auto turned = [&](const std::string& sides) {
            return message(
                file(grid(frame + attribute("E", "Node", writer.item(kFloat32, sides, values)))));
        };
        EXPECT_EQ(turned("4 3 2"), fmt::format(messages::kFieldSides, "E", "4 3 2", "2 3 4") +
                                       "; " + messages::kFieldSidesHelp);
        for (const char* other : {"4 6", "3 8", "12 2", "6 2 2", "3 2 4"})
            EXPECT_THAT(turned(other), testing::Says(messages::kFieldSides, "E", other, "2 3 4"));
        // Some sides taken together, which leaves the order as it is.
        for (const char* same : {"24", "6 4", "2 12", "1 2 3 4", "2 3 4 1", "2 3 2 2"})
            EXPECT_EQ(turned(same), "no error") << same;
        EXPECT_THAT(
            message(file(
                grid(frame + attribute("v", "Cell", writer.item(kFloat32, "3 1 2 3", vectors))))),
            testing::Says(messages::kFieldSides, "v", "3 1 2 3", "1 2 3 3"));
        options.field = "v";
        options.unit = "cm";
        const auto q = converted(written, options);
        ASSERT_NE(q, nullptr);
        EXPECT_EQ(size(*q), (Vec3i{3, 2, 1}));
        EXPECT_EQ(q->channels(), 3);
        EXPECT_EQ(origin(*q), (Vec3d{100, 200, 300}));
        EXPECT_EQ(pitch(*q), (Vec3d{5, 2.5, 20}));
        EXPECT_TRUE(std::equal(vectors.begin(), vectors.end(), q->texels().begin()));
    }
}

TEST_F(XdmfTest, RectilinearAndCurvilinearGridsAreSampled) {
    // Places from the lowest, but those along y, which fall.
    const std::array<std::vector<double>, 3> axes{
        {{-1, 0.3, 1.5, 2}, {3, 1, 0}, {2, 2.5, 4, 4.5, 5}}};
    BlockMesh mesh;
    for (const double z : axes[2]) {
        for (const double y : axes[1]) {
            for (const double x : axes[0])
                mesh.points.insert(mesh.points.end(), {x, y, z});
        }
    }
    for (const Form form : kForms) {
        SCOPED_TRACE(static_cast<int>(form));
        XdmfWriter writer(form, folder_);
        std::string crossed =
            "<Topology TopologyType=\"3DRectMesh\" Dimensions=\"5 3 4\"/>"
            "<Geometry GeometryType=\"VXVYVZ\">";
        for (const std::vector<double>& axis : axes)
            crossed += writer.item(kFloat64, std::to_string(axis.size()), axis);
        const std::string field =
            attribute("E", "Node", writer.item(kFloat64, "5 3 4", field_of(mesh)));
        expect_linear(file(grid(crossed + "</Geometry>" + field)));
        const std::string curved =
            "<Topology TopologyType=\"3DSMesh\" Dimensions=\"5 3 4\"/>" + points_of(mesh, &writer);
        expect_linear(file(grid(curved + field)));
        // Values of cells: 3 x 2 x 4 of them, here their numbers.
        std::vector<float> numbers(24);
        for (size_t i = 0; i < numbers.size(); ++i)
            numbers[i] = static_cast<float>(i);
        VolumeOptions options;
        options.pitch_mm = 0.25;
        const auto p = converted(
            folder_.write("c.xdmf",
                          file(grid(curved + attribute("n", "Cell",
                                                       writer.item(kFloat32, "4 2 3", numbers))))),
            options);
        ASSERT_NE(p, nullptr);
        each(*p, [&](const Vec3d& at, const float* value) {
            const int x = at.x < 0.3 ? 0 : at.x < 1.5 ? 1 : 2, y = at.y > 1 ? 0 : 1;
            const int z = at.z < 2.5 ? 0 : at.z < 4 ? 1 : at.z < 4.5 ? 2 : 3;
            EXPECT_EQ(*value, static_cast<float>((z * 2 + y) * 3 + x));
        });
    }
    XdmfWriter w(Form::kText, folder_);
    const std::string field = attribute("E", "Node", w.item(kFloat64, "60", field_of(mesh)));
    const auto shaped = [&](const std::string& type, const std::string& sizes) {
        return message(file(grid("<Topology TopologyType=\"" + type + "\" Dimensions=\"" + sizes +
                                 "\"/>" + points_of(mesh, &w) + field)));
    };
    EXPECT_EQ(shaped("3DRectMesh", "5 3 4"), fmt::format(messages::kRectilinearGeometry, "xyz"));
    EXPECT_EQ(shaped("3DSMesh", "5 12"), messages::kStructuredDimensions);
    EXPECT_EQ(shaped("3DSMesh", "5 12 1"), fmt::format(messages::kNoCellBetweenPoints, 1, 12, 5));
    EXPECT_EQ(shaped("3DSMesh", "5 3 5"),
              fmt::format(messages::kNumbersFor, fmt::format(messages::kItsField, "E"), 60, 75,
                          "points"));
    EXPECT_EQ(shaped("3DSMesh", "5 3 2"), fmt::format(messages::kGridPoints, 60, 30));
    const std::string short_axis =
        file(grid("<Topology TopologyType=\"3DRectMesh\" Dimensions=\"5 3 4\"/>"
                  "<Geometry GeometryType=\"VXVYVZ\">" +
                  w.item(kFloat64, "4", axes[0]) + w.item(kFloat64, "4", axes[0]) +
                  w.item(kFloat64, "5", axes[2]) + "</Geometry>" + field));
    EXPECT_EQ(message(short_axis), fmt::format(messages::kAxisPlaces, "y", 4, 3));
}

TEST_F(XdmfTest, PartsOfArraysAreTaken) {
    const BlockMesh mesh = block(12);
    for (const Form form : kForms) {
        SCOPED_TRACE(static_cast<int>(form));
        XdmfWriter writer(form, folder_);
        // The field is every second number of the second of three rows; the points are the last three
        // columns of five.
        std::vector<double> rows(3 * 130, -7), columns;
        const std::vector<double> values = field_of(mesh);
        for (size_t i = 0; i < values.size(); ++i) {
            rows[130 + 1 + 2 * i] = values[i];
            columns.insert(columns.end(), {-1, -2});
            for (size_t a = 0; a < 3; ++a)
                columns.push_back(mesh.points[3 * i + a]);
        }
        const auto part = [&](const std::string& sizes, const std::string& which,
                              const std::string& item) {
            return "<DataItem ItemType=\"HyperSlab\" Dimensions=\"" + sizes +
                   "\">\n<DataItem Dimensions=\"3 2\" Format=\"XML\">" + which + "</DataItem>\n" +
                   item + "</DataItem>";
        };
        const std::string points =
            "<Geometry GeometryType=\"XYZ\">" +
            part("64 3", "0 2 1 1 64 3", writer.item(kFloat64, "64 5", columns)) + "</Geometry>\n";
        expect_linear(file(
            grid(points + cells_of(mesh, &writer) +
                 attribute("E", "Node",
                           part("64", "1 1  1 2  1 64", writer.item(kFloat64, "3 130", rows))))));
        const auto wrong = [&](const std::string& sizes, const std::string& which) {
            return message(file(grid(
                points_of(mesh, &writer) + cells_of(mesh, &writer) +
                attribute("E", "Node", part(sizes, which, writer.item(kFloat64, "3 130", rows))))));
        };
        const std::string start =
            fmt::format(messages::kCannotBeRead, fmt::format(messages::kItsField, "E"));
        EXPECT_EQ(wrong("64", "1 1 1 2 1"), start + texture::messages::kSlabRowsMissing);
        EXPECT_EQ(wrong("64", "1 1 1 0 1 64"), start + texture::messages::kSlabRowsMissing);
        EXPECT_EQ(wrong("64", "1 4 1 2 1 64"),
                  start + fmt::format(texture::messages::kSlabBeyondArray, 130));
        EXPECT_EQ(wrong("64", "3 0 1 2 1 64"),
                  start + fmt::format(texture::messages::kSlabBeyondArray, 3));
        EXPECT_EQ(wrong("64", "1 1 1 2 1 60"),
                  start + fmt::format(texture::messages::kSlabCountDiffers, 60, 64));
        EXPECT_EQ(wrong("64", "1 1 1 2 1 64 1"),
                  start + fmt::format(texture::messages::kSlabCountDiffers, 64, 64));
    }
}

TEST_F(XdmfTest, ReadsNoDataFileFromElsewhere) {
    const BlockMesh mesh = block(10);
    XdmfWriter text(Form::kText, folder_);
    const auto with = [&](const std::string& name) {
        return file(grid(points_of(mesh, &text) + cells_of(mesh, &text) +
                         attribute("E", "Node",
                                   "<DataItem Dimensions=\"64\" Precision=\"4\" "
                                   "Format=\"Binary\">" +
                                       name + "</DataItem>")));
    };
    const std::string start =
        fmt::format(messages::kCannotBeRead, fmt::format(messages::kItsField, "E"));
    EXPECT_THAT(message(with("/etc/passwd")),
                ::testing::StartsWith(
                    start + fmt::format(texture::messages::kDataFileUnreadable, "/etc/passwd")));
    EXPECT_THAT(message(with("../x.bin")),
                ::testing::StartsWith(
                    start + fmt::format(texture::messages::kDataFileUnreadable, "../x.bin")));
    EXPECT_THAT(message(with("missing.bin")),
                ::testing::StartsWith(
                    start + fmt::format(texture::messages::kDataFileUnreadable, "missing.bin")));
    folder_.write("short.bin", std::string(255, 'a'));
    EXPECT_EQ(message(with("short.bin")),
              fmt::format(messages::kCannotBeRead, fmt::format(messages::kItsField, "E")) +
                  messages::kArrayCutShort);
    EXPECT_EQ(message(with(" ")),
              fmt::format(messages::kCannotBeRead, fmt::format(messages::kItsField, "E")) +
                  texture::messages::kNoDataFile);
    // The texture of other data is another one.
    folder_.write("e.bin", std::string(256, '\0'));
    const auto path = folder_.write("m.xdmf", with("e.bin"));
    const Result<uint64_t> one = texture::volume_key(path, {});
    folder_.write("e.bin", std::string(256, '\1'));
    const Result<uint64_t> two = texture::volume_key(path, {});
    ASSERT_TRUE(one);
    ASSERT_TRUE(two);
    EXPECT_NE(*one, *two);
}

TEST_F(XdmfTest, SaysWhatIsWrong) {
    const BlockMesh mesh = block(12);
    XdmfWriter w(Form::kText, folder_);
    const std::string points = points_of(mesh, &w), cells = cells_of(mesh, &w);
    const std::vector<float> values(64, 1);
    const std::string field = attribute("a", "Node", w.item(kFloat32, "64", values));
    const auto with = [&](const std::string& content) { return message(file(grid(content))); };
    const auto item = [&](const std::string& attributes) {
        return with(points + cells +
                    attribute("a", "Node",
                              "<DataItem Dimensions=\"64\" " + attributes + ">m.h5:/u</DataItem>"));
    };
    const std::string start =
        fmt::format(messages::kCannotBeRead, fmt::format(messages::kItsField, "a"));
    EXPECT_EQ(item(R"(Format="HDF")"), start + fmt::format(messages::kLiesInHdf5, "m.h5", "/u") +
                                           "; " + messages::kLiesInHdf5Help);
    EXPECT_THAT(
        item(R"(Format="TIFF")"),
        ::testing::StartsWith(start + fmt::format(texture::messages::kItemFormatUnknown, "tiff")));
    EXPECT_THAT(item(R"(Reference="XML")"),
                ::testing::StartsWith(start + texture::messages::kItemReference));
    EXPECT_THAT(item(R"(ItemType="HyperSlab")"),
                ::testing::StartsWith(start + texture::messages::kSlabWithoutTwoItems));
    EXPECT_THAT(
        item(R"(ItemType="Function")"),
        ::testing::StartsWith(start + fmt::format(texture::messages::kItemComputed, "function")));
    EXPECT_THAT(
        item(R"(Format="Binary" Compression="Zlib")"),
        ::testing::StartsWith(start + fmt::format(texture::messages::kItemCompressed, "zlib")));
    EXPECT_THAT(item(R"(NumberType="Double")"),
                ::testing::StartsWith(
                    start + fmt::format(texture::messages::kNumberTypeUnknown, "double")));
    EXPECT_THAT(
        item(R"(Precision="16")"),
        ::testing::StartsWith(start + fmt::format(texture::messages::kPrecisionUnknown, "16")));
    EXPECT_THAT(
        item(R"(Precision="2")"),
        ::testing::StartsWith(start + fmt::format(texture::messages::kNumberBytesUnknown, 2)));
    EXPECT_THAT(item(R"(Format="Binary" Seek="-1")"),
                ::testing::StartsWith(start + fmt::format(texture::messages::kSeekNoNumber, "-1")));
    EXPECT_THAT(with(points + cells +
                     R"(<Attribute Name="a" ItemType="FiniteElementFunction" Center="Other">)" +
                     w.item(kFloat32, "64", values) + "</Attribute>"),
                ::testing::StartsWith(start + texture::messages::kElementFunction));
    EXPECT_THAT(with(points + R"(<Topology Reference="/Xdmf/Domain/Topology[1]"/>)" + field),
                ::testing::StartsWith(fmt::format(texture::messages::kPartReference, "Topology")));
    EXPECT_THAT(with(cells + R"(<Geometry Reference="/Xdmf/Domain/Geometry[1]"/>)" + field),
                ::testing::StartsWith(fmt::format(texture::messages::kPartReference, "Geometry")));
    EXPECT_THAT(with(points + R"(<Topology TopologyType="2DSMesh" Dimensions="8 8"/>)" + field),
                testing::Says(messages::kXdmfTypesNotSampled, "2dsmesh"));
    EXPECT_EQ(with(points + cells), messages::kNoField);
    EXPECT_EQ(
        with(points + cells + field + attribute("b", "Node", w.item(kFloat32, "64", values))),
        fmt::format(messages::kSeveralFields, "`a`, `b`") + "; " + messages::kSeveralFieldsChoose);
    EXPECT_EQ(with(points + cells +
                   attribute("a", "Node", w.item(kFloat32, "64", std::vector<float>(63)))),
              messages::kArrayCutShort);
    EXPECT_EQ(with(points + cells + attribute("a", "Node", w.item(kFloat32, "63", values))),
              fmt::format(messages::kNumbersFor, fmt::format(messages::kItsField, "a"), 63, 64,
                          "points"));
    EXPECT_EQ(
        with(points + cells + attribute("a", "Cell", w.item(kFloat32, "64", values))),
        fmt::format(messages::kNumbersFor, fmt::format(messages::kItsField, "a"), 64, 27, "cells"));
    EXPECT_THAT(with(points + cells + attribute("a", "Node", w.item(kFloat32, "0", values))),
                ::testing::StartsWith(start + texture::messages::kSizesNotWhole));
    EXPECT_THAT(
        with(points + cells + attribute("a", "Node", w.item(kFloat32, "1099511627776 2", values))),
        ::testing::StartsWith(start + texture::messages::kSizesNotWhole));
    EXPECT_THAT(
        with(points + topology("Tetrahedron_10", 27, w.item(kInt64, "27 8", mesh.corners)) + field),
        testing::Says(messages::kXdmfTypesNotSampled, "tetrahedron_10"));
    EXPECT_EQ(
        with(points + topology("Hexahedron", 26, w.item(kInt64, "27 8", mesh.corners)) + field),
        fmt::format(messages::kTopologyCount, 216, 26));
    const auto mixed = [&](const std::vector<int64_t>& numbers) {
        return with(points +
                    topology("Mixed", 1, w.item(kInt64, std::to_string(numbers.size()), numbers)) +
                    field);
    };
    EXPECT_THAT(mixed({7, 0, 1, 2, 3, 4}),
                testing::Says(messages::kXdmfCellTypeNotSampled, "0", "7"));
    EXPECT_EQ(mixed({6, 0, 1, 2}), messages::kTopologyTooShort);
    EXPECT_EQ(mixed({6, 0, 1, 2, 16, 3}), messages::kTopologyTooLong);
    EXPECT_EQ(mixed({6, 0, 1, 2, 64}), fmt::format(messages::kCornerIsNoPoint, 0));
    EXPECT_EQ(mixed({3, 1000000000000, 1, 2}), messages::kTopologyTooShort);
    EXPECT_THAT(mixed({4, 0, 1, 2}), testing::Says(messages::kNoCellsWithVolume));
    EXPECT_THAT(with("<include/>"), testing::Says(texture::messages::kIncludeElsewhere));
    EXPECT_EQ(message("<VTKFile/>"),
              fmt::format(texture::messages::kAtLine, 1, texture::messages::kNotXdmf));
    EXPECT_EQ(message("<!DOCTYPE Xdmf [<!ENTITY a \"aaaa\">]><Xdmf>&a;</Xdmf>"),
              fmt::format(texture::messages::kAtLine, 1, openfab::messages::kEntityDeclaration));
    EXPECT_EQ(message("<!DOCTYPE Xdmf [<!ATTLIST Grid Name CDATA \"a\">]><Xdmf/>"),
              fmt::format(texture::messages::kAtLine, 1, openfab::messages::kAttributeDeclaration));
    EXPECT_EQ(message("<!DOCTYPE Xdmf SYSTEM \"/etc/passwd\">\n<Xdmf>&a;</Xdmf>"),
              fmt::format(texture::messages::kAtLine, 2,
                          fmt::format(openfab::messages::kUnknownEntity, "a")));
    // A grid in an array, deep or not, at its begin or end.
    for (const char* inner : {"<Grid><Topology/></Grid>1", "1<Grid><Attribute/></Grid>2",
                              "<DataItem><Grid><a/></Grid>3</DataItem>4",
                              "<Information><Grid GridType=\"Tree\"/></Information>5"}) {
        const std::string array =
            std::string("<DataItem Dimensions=\"64\">") + inner + "</DataItem>";
        EXPECT_THAT(with(points + cells + attribute("a", "Node", array)),
                    ::testing::HasSubstr(texture::messages::kGridInArray));
        EXPECT_THAT(with("<Geometry>" + array + "</Geometry>" + cells + field),
                    ::testing::HasSubstr(texture::messages::kGridInArray));
    }
    EXPECT_THAT(
        trouble(folder_.write("m.xdmf", file(grid(points + cells + field))), {}, {4000, {}}),
        testing::Says(texture::messages::kXmlTooLarge, "*", "4 kB"));
}

}  // namespace
}  // namespace openfab::tools

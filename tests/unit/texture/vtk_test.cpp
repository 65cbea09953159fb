// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// VTK's files of cells, written here as its own writers do: fields that are linear in space must come back as
// such, wherever and however their cells lie.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/says/says.h"
#include "tests/unit/texture/vtk_files.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

TEST_F(VtkTest, LinearFieldsOnCellsComeBack) {
    for (const int type : {10, 11, 12, 13}) {
        for (const Form form : {Form::kText, Form::kAppendedPacked}) {
            SCOPED_TRACE(type);
            const BlockMesh mesh = block(type);
            VtkWriter writer(form);
            std::vector<double> values;
            for (size_t i = 0; i < mesh.point_count(); ++i) {
                values.push_back(linear(mesh.point(i)));
                values.push_back(mesh.point(i).y);
            }
            const std::string fields =
                "<PointData>" + writer.array("E", "Float64", 2, values) + "</PointData>";
            VolumeOptions options;
            options.pitch_mm = 0.21;
            const auto p = converted(
                folder_.write("m.vtu",
                              writer.file("UnstructuredGrid", text_of(mesh, &writer, fields))),
                options);
            ASSERT_NE(p, nullptr);
            EXPECT_EQ(size(*p), (Vec3i{15, 15, 15}));
            EXPECT_EQ(origin(*p), (Vec3d{-1, 0, 2}));
            each(*p, [](const Vec3d& at, const float* value) {
                const Vec3d in{std::min(at.x, 2.0), std::min(at.y, 3.0), std::min(at.z, 5.0)};
                if (in == at) {
                    EXPECT_NEAR(value[0], linear(at), 2e-6);
                    EXPECT_NEAR(value[1], at.y, 1e-6);
                }
            });
        }
    }
}

TEST_F(VtkTest, CellsKeepTheirValueAndTheOutsideHasItsOwn) {
    BlockMesh mesh;
    mesh.points = {0, 0, 0, 4, 0, 0, 0, 4, 0, 0, 0, 4, 40, 40, 40};
    mesh.add(5, {0, 1, 2});  // a face, as exporters write them
    mesh.add(10, {0, 1, 2, 3});
    VtkWriter writer(Form::kBase64);
    const std::string fields =
        "<CellData>" + writer.array("E", "Float32", 1, std::vector<float>{1, 8}) + "</CellData>";
    const auto file =
        folder_.write("m.vtu", writer.file("UnstructuredGrid", text_of(mesh, &writer, fields)));
    VolumeOptions options;
    options.pitch_mm = 0.1;
    options.outside = -5;
    const auto p = converted(file, options);
    ASSERT_NE(p, nullptr);
    EXPECT_EQ(size(*p), (Vec3i{40, 40, 40})) << "a point of no cell counts nothing";
    each(*p, [](const Vec3d& at, const float* value) {
        const double over = (at.x + at.y + at.z - 4) / std::sqrt(3.0);
        if (over < 0) {
            EXPECT_EQ(*value, 8);
        } else if (over > 0.2) {  // two texels
            EXPECT_EQ(*value, -5);
        }
    });
}

TEST_F(VtkTest, AFieldGoesOnPastTheSurface) {
    // So that interpolation just under it is right; within the bounds of the field.
    const BlockMesh mesh = block(12);
    VtkWriter writer(Form::kText);
    std::vector<double> values;
    for (size_t i = 0; i < mesh.point_count(); ++i)
        values.push_back(mesh.point(i).x);
    VolumeOptions options;
    options.pitch_mm = 0.4;  // the last texels' centres lie at 2.0
    options.outside = 50;
    const std::string fields =
        "<PointData>" + writer.array("x", "Float64", 1, values) + "</PointData>";
    const auto p = converted(
        folder_.write("m.vtu", writer.file("UnstructuredGrid", text_of(mesh, &writer, fields))),
        options);
    ASSERT_NE(p, nullptr);
    EXPECT_EQ(size(*p).x, 8);
    each(*p, [](const Vec3d& at, const float* value) {
        EXPECT_NEAR(*value, std::min(at.x, 2.0), 1e-6);
    });
}

TEST_F(VtkTest, SaysWhatIsWrong) {
    const BlockMesh mesh = block(12);
    const auto with = [&](const std::string& fields, VtkWriter* writer) {
        return folder_.write("m.vtu",
                             writer->file("UnstructuredGrid", text_of(mesh, writer, fields)));
    };
    VtkWriter w(Form::kText);
    const std::vector<float> field(64, 1), short_field(63, 1);
    EXPECT_EQ(trouble(with("", &w)), messages::kNoField);
    const std::string two = "<PointData>" + w.array("a", "Float32", 1, field) +
                            w.array("b", "Float32", 1, field) + "</PointData>";
    EXPECT_EQ(trouble(with(two, &w)), fmt::format(messages::kSeveralFields, "`a`, `b`") + "; " +
                                          messages::kSeveralFieldsChoose);
    VolumeOptions options;
    options.field = "c";
    EXPECT_EQ(trouble(with(two, &w), options),
              fmt::format(messages::kNoSuchField, "c", "`a`, `b`"));
    EXPECT_EQ(
        trouble(with("<PointData>" + w.array("a", "Float32", 1, short_field) + "</PointData>", &w)),
        messages::kArrayCutShort);
    EXPECT_EQ(trouble(with("<PointData>" + w.array("t", "Float32", 9, field) + "</PointData>", &w)),
              fmt::format(messages::kFieldComponents, "t", 9));
    options = {};
    options.pitch_mm = 1e-4;
    const std::string one = "<PointData>" + w.array("a", "Float32", 1, field) + "</PointData>";
    EXPECT_EQ(trouble(with(one, &w), options),
              fmt::format(messages::kResampledTooLarge, 0.0001, 30000.0, "x", 16384.0));
    EXPECT_THAT(trouble(with(one, &w), {}, {4000, {}}),
                testing::Says(messages::kTakesTooMuchMemory, "*", "4 kB"));
    BlockMesh quadratic;
    quadratic.points.assign(30, 0);
    quadratic.add(24, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
    EXPECT_THAT(trouble(folder_.write(
                    "q.vtu", w.file("UnstructuredGrid",
                                    text_of(quadratic, &w,
                                            "<CellData>" +
                                                w.array("a", "Float32", 1, std::vector<float>{1}) +
                                                "</CellData>")))),
                testing::Says(messages::kVtkCellTypeNotSampled, "0", "24"));
    EXPECT_EQ(
        trouble(folder_.write("p.vtu", "<VTKFile type=\"PolyData\"></VTKFile>")),
        fmt::format(messages::kAtLine, 1, fmt::format(messages::kVtkKindNotRead, "PolyData")) +
            "; " + messages::kVtkSurfaceHelp);
    EXPECT_EQ(trouble(folder_.write("t.vtu", "<VTKFile type=\"Table\"></VTKFile>")),
              fmt::format(messages::kAtLine, 1, fmt::format(messages::kVtkKindNotRead, "Table")) +
                  "; " + messages::kVtkKindNotReadHelp);
    // The name of a packer stands in files of text, too.
    for (const Form form : {Form::kPacked, Form::kText}) {
        VtkWriter writer(form);
        std::string text = writer.file(
            "UnstructuredGrid",
            text_of(mesh, &writer,
                    "<PointData>" + writer.array("a", "Float32", 1, field) + "</PointData>"));
        const std::string mark = "header_type=\"UInt32\"";
        if (const size_t zlib = text.find("vtkZLib"); zlib != std::string::npos) {
            text.replace(zlib, 7, "vtkLZ4");
        } else {
            text.replace(text.find(mark), mark.size(),
                         mark + " compressor=\"vtkLZ4DataCompressor\"");
        }
        EXPECT_EQ(trouble(folder_.write("z.vtu", text)),
                  form == Form::kText ? "no error"
                                      : fmt::format(messages::kPackedBy, "vtkLZ4DataCompressor; ") +
                                            messages::kPackedByHelp);
    }
}

}  // namespace
}  // namespace openfab::tools

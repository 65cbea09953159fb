// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// VTK's files of grids, written here as its own writers do: images, rectilinear and curvilinear ones.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <random>

#include "tests/support/memory/meter.h"
#include "tests/unit/texture/border_reach.h"
#include "tests/unit/texture/vtk_files.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

TEST_F(VtkTest, ImageDataInEveryFormIsInPlace) {
    for (const Form form : kForms) {
        SCOPED_TRACE(static_cast<int>(form));
        VtkWriter writer(form);
        // Points from (1, 0, -1) to (4, 2, 0): 4 x 3 x 2 of them.
        std::vector<float> values;
        for (int z = -1; z <= 0; ++z) {
            for (int y = 0; y <= 2; ++y) {
                for (int x = 1; x <= 4; ++x)
                    values.push_back(
                        static_cast<float>(linear({10 + 0.5 * x, 20 + 0.25 * y, 30 + 2.0 * z})));
            }
        }
        const std::string content =
            "<ImageData WholeExtent=\"1 4 0 2 -1 0\" Origin=\"10 20 30\" Spacing=\"0.5 0.25 2\">\n"
            "<Piece Extent=\"1 4 0 2 -1 0\"><PointData Scalars=\"E\">" +
            writer.array("other", "Float32", 1, std::vector<float>(24, 7)) +
            writer.array("E", "Float32", 1, values) + "</PointData></Piece></ImageData>\n";
        const auto p = converted(folder_.write("a.vti", writer.file("ImageData", content)));
        ASSERT_NE(p, nullptr);
        EXPECT_EQ(size(*p), (Vec3i{4, 3, 2}));
        EXPECT_EQ(origin(*p), (Vec3d{10.25, 19.875, 27}));
        each(*p, [](const Vec3d& at, const float* value) {
            EXPECT_FLOAT_EQ(*value, static_cast<float>(linear(at)));
        });
        VolumeOptions options;
        options.field = "other";
        options.unit = "cm";
        const auto q = converted(folder_.path() / "a.vti", options);
        ASSERT_NE(q, nullptr);
        EXPECT_EQ(q->texels()[0], 7);
        EXPECT_EQ(origin(*q), (Vec3d{102.5, 198.75, 270}));
    }
}

TEST_F(VtkTest, ImageDataOfCellsAndVectorsAndIntegers) {
    VtkWriter writer(Form::kAppended);
    const std::string content =
        "<ImageData WholeExtent=\"0 2 0 1 0 1\" Origin=\"0 0 0\" Spacing=\"1 1 1\"><Piece>"
        "<CellData>" +
        writer.array("v", "Int16", 3, std::vector<int16_t>{1, -2, 300, 4, 5, 6}) +
        "</CellData></Piece></ImageData>";
    const auto p = converted(folder_.write("a.vti", writer.file("ImageData", content)));
    ASSERT_NE(p, nullptr);
    EXPECT_EQ(size(*p), (Vec3i{2, 1, 1}));
    EXPECT_EQ(p->channels(), 3);
    EXPECT_EQ(origin(*p), (Vec3d{0, 0, 0}));
    const std::vector<float> texels(p->texels().begin(), p->texels().begin() + 6);
    EXPECT_EQ(texels, (std::vector<float>{1, -2, 300, 4, 5, 6}));
}

TEST_F(VtkTest, TurnedImageDataIsSampledInPlace) {
    // Exchanged axes are put in order: index x runs along -y, y along z, z along x.
    const auto image = [&](const std::string& direction, const std::array<double, 9>& d) {
        std::vector<double> values;
        for (int k = 0; k < 4; ++k) {
            for (int j = 0; j < 5; ++j) {
                for (int i = 0; i < 6; ++i) {
                    const double a = i * 1.0, b = j * 0.5, c = k * 2.0;
                    values.push_back(linear({1 + d[0] * a + d[1] * b + d[2] * c,
                                             2 + d[3] * a + d[4] * b + d[5] * c,
                                             3 + d[6] * a + d[7] * b + d[8] * c}));
                }
            }
        }
        VtkWriter writer(Form::kAppendedPacked);
        return writer.file(
            "ImageData",
            "<ImageData WholeExtent=\"0 5 0 4 0 3\" Origin=\"1 2 3\" Spacing=\"1 0.5 2\" "
            "Direction=\"" +
                direction + "\"><Piece><PointData>" + writer.array("f", "Float64", 1, values) +
                "</PointData></Piece></ImageData>");
    };
    const auto p = converted(
        folder_.write("p.vti", image("0 0 1 -1 0 0 0 1 0", {0, 0, 1, -1, 0, 0, 0, 1, 0})));
    ASSERT_NE(p, nullptr);
    EXPECT_EQ(size(*p), (Vec3i{4, 6, 5}));
    EXPECT_EQ(pitch(*p), (Vec3d{2, 1, 0.5}));
    each(*p, [](const Vec3d& at, const float* value) {
        EXPECT_FLOAT_EQ(*value, static_cast<float>(linear(at)));
    });
    // Turned by 30 degrees about z; texels well inside lie between centres.
    const double c = std::sqrt(0.75), s = 0.5;
    const std::array<double, 9> turn{c, -s, 0, s, c, 0, 0, 0, 1};
    VolumeOptions options;
    options.pitch_mm = 0.25;
    options.outside = -99;
    const auto q = converted(
        folder_.write("q.vti", image(fmt::format("{} {} 0 {} {} 0 0 0 1", c, -s, s, c), turn)),
        options);
    ASSERT_NE(q, nullptr);
    int inside = 0, outside = 0;
    const double reach_i = border_reach({c, s, 0}, options.pitch_mm) + 1e-6;
    const double reach_j = border_reach(Vec3d{-s, c, 0} * 0.5, options.pitch_mm) + 1e-6;
    each(*q, [&](const Vec3d& at, const float* value) {
        const double x = at.x - 1, y = at.y - 2;
        const double i = c * x + s * y, j = (-s * x + c * y) / 0.5, k = (at.z - 3) / 2;
        if (i > 0 && i < 5 && j > 0 && j < 4 && k > 0 && k < 3) {
            EXPECT_NEAR(*value, linear(at), 4e-6);
            ++inside;
        } else if (std::max(-i, i - 5) > reach_i || std::max(-j, j - 4) > reach_j) {
            EXPECT_EQ(*value, -99);
            ++outside;
        }
    });
    EXPECT_GT(inside, 2000);
    EXPECT_GT(outside, 1000);
}

TEST_F(VtkTest, RectilinearAndCurvilinearGridsAreSampled) {
    // Places from the lowest, but those along y, which fall.
    const std::array<std::vector<double>, 3> axes{{{-1, 0.3, 1.5, 2}, {3, 1, 0}, {2, 2.5, 5}}};
    for (const bool is_rectilinear : {true, false}) {
        for (const Form form : kForms) {
            SCOPED_TRACE(static_cast<int>(form));
            VtkWriter writer(form);
            std::vector<double> points, values;
            std::vector<int16_t> numbers;
            for (const double z : axes[2]) {
                for (const double y : axes[1]) {
                    for (const double x : axes[0]) {
                        points.insert(points.end(), {x, y, z});
                        values.push_back(linear({x, y, z}));
                    }
                }
            }
            for (int16_t i = 0; i < 12; ++i)
                numbers.push_back(i);
            const std::string kind = is_rectilinear ? "RectilinearGrid" : "StructuredGrid";
            // Points from (3, 0, -1) on, as a part of a larger grid has them.
            std::string content = "<" + kind +
                                  " WholeExtent=\"3 6 0 2 -1 1\">"
                                  "<Piece Extent=\"3 6 0 2 -1 1\"><PointData>" +
                                  writer.array("E", "Float64", 1, values) +
                                  "</PointData><CellData>" +
                                  writer.array("n", "Int16", 1, numbers) + "</CellData>";
            if (is_rectilinear) {
                content += "<Coordinates>" + writer.array("x", "Float64", 1, axes[0]) +
                           writer.array("y", "Float64", 1, axes[1]) +
                           writer.array("z", "Float64", 1, axes[2]) + "</Coordinates>";
            } else {
                content += "<Points>" + writer.array("Points", "Float64", 3, points) + "</Points>";
            }
            const auto written =
                folder_.write(is_rectilinear ? "m.vtr" : "m.vts",
                              writer.file(kind, content + "</Piece></" + kind + ">"));
            VolumeOptions options;
            options.pitch_mm = 0.25;
            options.field = "E";
            const auto p = converted(written, options);
            ASSERT_NE(p, nullptr);
            EXPECT_EQ(size(*p), (Vec3i{12, 12, 12}));
            EXPECT_EQ(origin(*p), (Vec3d{-1, 0, 2}));
            each(*p, [](const Vec3d& at, const float* value) {
                EXPECT_NEAR(*value, linear(at), 2e-6);
            });
            options.field = "n";
            const auto q = converted(written, options);
            ASSERT_NE(q, nullptr);
            each(*q, [&](const Vec3d& at, const float* value) {
                const int x = at.x < 0.3 ? 0 : at.x < 1.5 ? 1 : 2, y = at.y > 1 ? 0 : 1;
                EXPECT_EQ(*value, static_cast<float>(((at.z < 2.5 ? 0 : 1) * 2 + y) * 3 + x));
            });
        }
    }
    VtkWriter w(Form::kText);
    const auto wrong = [&](const std::string& extent, const std::string& coordinates) {
        return trouble(folder_.write(
            "w.vtr", w.file("RectilinearGrid",
                            "<RectilinearGrid WholeExtent=\"" + extent + "\"><Piece><PointData>" +
                                w.array("a", "Float32", 1, std::vector<float>(8, 1)) +
                                "</PointData><Coordinates>" + coordinates +
                                "</Coordinates></Piece></RectilinearGrid>")));
    };
    const std::string axis = w.array("x", "Float32", 1, std::vector<float>{0, 1});
    EXPECT_EQ(wrong("0 1 0 1 0 1", axis + axis), fmt::format(messages::kAxesArrays, 2));
    EXPECT_EQ(wrong("0 1 0 1 0 2", axis + axis + axis), messages::kArrayCutShort);
    EXPECT_EQ(wrong("0 1 0 1 0 0", axis + axis + axis),
              fmt::format(messages::kNoCellBetweenPoints, 2, 2, 1));
    EXPECT_EQ(wrong("0 1 0 1 1 0", axis + axis + axis),
              fmt::format(messages::kExtentNotPossible, 1.0, 0.0));
    EXPECT_EQ(wrong("0 65535 0 65535 0 65535", axis + axis + axis),
              fmt::format(messages::kMoreThanPoints, 2147483647));
}

/// A grid of the same places and numbers as a rectilinear and as a curvilinear one.
std::array<std::string, 2> as_both_grids(const std::array<std::vector<double>, 3>& axes,
                                         const std::string& values) {
    VtkWriter writer(Form::kText);
    std::vector<double> points;
    for (const double z : axes[2]) {
        for (const double y : axes[1]) {
            for (const double x : axes[0])
                points.insert(points.end(), {x, y, z});
        }
    }
    std::array<std::string, 2> out;
    for (const bool is_rectilinear : {true, false}) {
        const std::string kind = is_rectilinear ? "RectilinearGrid" : "StructuredGrid";
        const std::string places =
            is_rectilinear
                ? "<Coordinates>" + writer.array("x", "Float64", 1, axes[0]) +
                      writer.array("y", "Float64", 1, axes[1]) +
                      writer.array("z", "Float64", 1, axes[2]) + "</Coordinates>"
                : "<Points>" + writer.array("Points", "Float64", 3, points) + "</Points>";
        out[is_rectilinear ? 0 : 1] = writer.file(
            kind, fmt::format("<{} WholeExtent=\"0 {} 0 {} 0 {}\"><Piece>{}{}</Piece></{}>", kind,
                              axes[0].size() - 1, axes[1].size() - 1, axes[2].size() - 1, values,
                              places, kind));
    }
    return out;
}

TEST_F(VtkTest, ARectilinearGridIsSampledAsItsCuboids) {
    // Texel centres on faces, places that fall, a cell of no width, texels outside of all cells.
    const std::array<std::vector<double>, 3> axes{
        {{0, 0.5, 2, 2, 3.1}, {4, 2.25, 1, 0.2}, {-1, 0.25, 1.4}}};
    VtkWriter writer(Form::kText);
    std::vector<double> of_points, of_cells;
    std::mt19937 random(3);
    std::uniform_real_distribution<double> value(-1, 1);
    for (int i = 0; i < 2 * 5 * 4 * 3; ++i)
        of_points.push_back(value(random));
    for (int i = 0; i < 2 * 4 * 3 * 2; ++i)
        of_cells.push_back(value(random));
    const auto files =
        as_both_grids(axes, "<PointData>" + writer.array("p", "Float64", 2, of_points) +
                                "</PointData><CellData>" +
                                writer.array("c", "Float64", 2, of_cells) + "</CellData>");
    for (const char* field : {"p", "c"}) {
        for (const double pitch : {0.0, 0.5, 0.17}) {
            VolumeOptions options;
            options.field = field;
            options.pitch_mm = pitch;
            const auto crossed = converted(folder_.write("a.vtr", files[0]), options);
            const std::vector<float> sampled = level0(*crossed), place = domain(*crossed);
            const auto cells = converted(folder_.write("a.vts", files[1]), options);
            ASSERT_EQ(size(*crossed), size(*cells));
            EXPECT_EQ(place, domain(*cells));
            const std::vector<float> wanted = level0(*cells);
            for (size_t i = 0; i < wanted.size(); ++i)
                EXPECT_NEAR(sampled[i], wanted[i], 1e-6) << field << ", texel " << i / 2;
        }
    }
    auto wrong = axes;
    wrong[1] = {0, 2, 1, 3};
    EXPECT_EQ(trouble(folder_.write(
                  "w.vtr",
                  as_both_grids(wrong, "<PointData>" + writer.array("p", "Float64", 2, of_points) +
                                           "</PointData>")[0])),
              fmt::format(messages::kPlacesNotMonotonic, "y"));
}

TEST_F(VtkTest, ALargeRectilinearGridIsRead) {
    std::vector<double> axis;
    for (int i = 0; i <= 48; ++i)
        axis.push_back(0.1 * i + 0.001 * i * i);
    VtkWriter writer(Form::kText);
    const auto file = folder_.write(
        "l.vtr",
        as_both_grids({axis, axis, axis},
                      "<CellData>" +
                          writer.array("p", "Float32", 1, std::vector<float>(48 * 48 * 48, 1)) +
                          "</CellData>")[0]);
    const std::clock_t start = std::clock();
    const auto p = converted(file);
    ASSERT_NE(p, nullptr);
    EXPECT_EQ(size(*p), (Vec3i{144, 144, 144}));
    // Three voxels for each cell along each axis, each of which looks for its cell.
    EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, testing::kHangSeconds);
}

}  // namespace
}  // namespace openfab::tools

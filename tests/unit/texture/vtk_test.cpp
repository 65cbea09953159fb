// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// VTK's files, written here as its own writers do: fields that are linear in space must come back as
// such, wherever and however their cells lie.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <array>
#include <cmath>
#include <cstring>
#include <ctime>

#include "tests/support/memory/meter.h"
#include "tests/support/says/says.h"
#include "tests/unit/texture/field_test.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

std::string base64(const std::string& bytes) {
    constexpr const char* kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t bits = 0;
        const size_t n = std::min<size_t>(3, bytes.size() - i);
        for (size_t k = 0; k < 3; ++k)
            bits = bits << 8 | (k < n ? static_cast<uint8_t>(bytes[i + k]) : 0U);
        for (size_t k = 0; k < 4; ++k)
            out += k <= n ? kDigits[bits >> (18 - 6 * k) & 63] : '=';
    }
    return out;
}

template <typename T>
std::string raw(T value) {
    std::string out(sizeof value, '\0');
    std::memcpy(out.data(), &value, sizeof value);
    return out;
}

/// How a file holds its arrays.
enum class Form { kText, kBase64, kPacked, kAppended, kAppendedBase64, kAppendedPacked };
constexpr std::array kForms{Form::kText,     Form::kBase64,         Form::kPacked,
                            Form::kAppended, Form::kAppendedBase64, Form::kAppendedPacked};

/// Writes the parts of a VTK file.
class Writer {
  public:
    explicit Writer(Form form) : form_(form) {}

    template <typename T>
    std::string array(const std::string& name, const std::string& type, int components,
                      const std::vector<T>& values) {
        std::string tag = "<DataArray type=\"" + type + "\" Name=\"" + name +
                          "\" NumberOfComponents=\"" + std::to_string(components) + "\" format=\"";
        // As VTK's writers put it behind the numbers of an array.
        const std::string end =
            "<InformationKey name=\"L2_NORM_RANGE\" location=\"vtkDataArray\" length=\"2\">"
            "<Value index=\"0\">0.5</Value><Value index=\"1\">7</Value></InformationKey>"
            "</DataArray>\n";
        std::string bytes;
        for (const T value : values)
            bytes += raw(value);
        switch (form_) {
            case Form::kText: {
                tag += "ascii\">\n";
                for (const T value : values)
                    tag += fmt::format("{} ", value);
                return tag + end;
            }
            case Form::kBase64:
                return tag + "binary\">\n  " + base64(raw<uint32_t>(bytes.size()) + bytes) + "\n" +
                       end;
            case Form::kPacked: {
                const auto [header, data] = packed(bytes);
                return tag + "binary\">" + base64(header) + base64(data) + end;
            }
            case Form::kAppended:
                tag += place();
                appended_ += raw<uint32_t>(bytes.size()) + bytes;
                return tag;
            case Form::kAppendedBase64:
                tag += place();
                appended_ += base64(raw<uint32_t>(bytes.size()) + bytes);
                return tag;
            case Form::kAppendedPacked:
                break;
        }
        tag += place();
        const auto [header, data] = packed(bytes);
        appended_ += header + data;
        return tag;
    }

    std::string file(const std::string& kind, const std::string& content) const {
        const bool is_packed = form_ == Form::kPacked || form_ == Form::kAppendedPacked;
        std::string out = "<?xml version=\"1.0\"?>\n<VTKFile type=\"" + kind +
                          "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt32\"" +
                          (is_packed ? " compressor=\"vtkZLibDataCompressor\"" : "") + ">\n" +
                          content;
        if (!appended_.empty()) {
            out += std::string("<AppendedData encoding=\"") +
                   (form_ == Form::kAppendedBase64 ? "base64" : "raw") + "\">\n  _" + appended_ +
                   "\n</AppendedData>\n";
        }
        return out + "</VTKFile>\n";
    }

  private:
    std::string place() const {
        return "appended\" offset=\"" + std::to_string(appended_.size()) + "\"/>\n";
    }
    /// Blocks of 64 bytes, the last one shorter, as VTK writes them in larger ones.
    static std::pair<std::string, std::string> packed(const std::string& bytes) {
        constexpr size_t kBlock = 64;
        std::string sizes, data;
        const size_t blocks = (bytes.size() + kBlock - 1) / kBlock;
        for (size_t i = 0; i < blocks; ++i) {
            const std::string plain = bytes.substr(i * kBlock, kBlock);
            std::string out(compressBound(plain.size()), '\0');
            uLongf size = out.size();
            EXPECT_EQ(compress(reinterpret_cast<Bytef*>(out.data()), &size,
                               reinterpret_cast<const Bytef*>(plain.data()), plain.size()),
                      Z_OK);
            data += out.substr(0, size);
            sizes += raw(static_cast<uint32_t>(size));
        }
        return {raw(static_cast<uint32_t>(blocks)) + raw(static_cast<uint32_t>(kBlock)) +
                    raw(static_cast<uint32_t>(bytes.size() % kBlock)) + sizes,
                data};
    }

    Form form_;
    std::string appended_;
};

std::string text_of(const BlockMesh& mesh, Writer* writer, const std::string& fields) {
    const std::string places = writer->array("Points", "Float64", 3, mesh.points);
    const std::string cells = writer->array("connectivity", "Int64", 1, mesh.corners) +
                              writer->array("offsets", "Int64", 1, mesh.ends) +
                              writer->array("types", "UInt8", 1, mesh.types);
    return "<UnstructuredGrid><Piece NumberOfPoints=\"" + std::to_string(mesh.point_count()) +
           "\" NumberOfCells=\"" + std::to_string(mesh.types.size()) + "\">\n" + fields +
           "<Points>" + places + "</Points><Cells>" + cells +
           "</Cells></Piece></UnstructuredGrid>\n";
}

using VtkTest = FieldTest;

TEST_F(VtkTest, ImageDataInEveryFormIsInPlace) {
    for (const Form form : kForms) {
        SCOPED_TRACE(static_cast<int>(form));
        Writer writer(form);
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
    Writer writer(Form::kAppended);
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
        Writer writer(Form::kAppendedPacked);
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
    each(*q, [&](const Vec3d& at, const float* value) {
        const double x = at.x - 1, y = at.y - 2;
        const double i = c * x + s * y, j = (-s * x + c * y) / 0.5, k = (at.z - 3) / 2;
        if (i > 0 && i < 5 && j > 0 && j < 4 && k > 0 && k < 3) {
            EXPECT_NEAR(*value, linear(at), 4e-6);
            ++inside;
        } else if (i < -0.51 || i > 5.51 || j < -0.51 || j > 4.51) {
            EXPECT_EQ(*value, -99);
            ++outside;
        }
    });
    EXPECT_GT(inside, 2000);
    EXPECT_GT(outside, 1000);
}

TEST_F(VtkTest, LinearFieldsOnCellsComeBack) {
    for (const int type : {10, 11, 12, 13}) {
        for (const Form form : {Form::kText, Form::kAppendedPacked}) {
            SCOPED_TRACE(type);
            const BlockMesh mesh = block(type);
            Writer writer(form);
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

TEST_F(VtkTest, RectilinearAndCurvilinearGridsAreSampled) {
    // Places from the lowest, but those along y, which fall.
    const std::array<std::vector<double>, 3> axes{{{-1, 0.3, 1.5, 2}, {3, 1, 0}, {2, 2.5, 5}}};
    for (const bool is_rectilinear : {true, false}) {
        for (const Form form : kForms) {
            SCOPED_TRACE(static_cast<int>(form));
            Writer writer(form);
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
    Writer w(Form::kText);
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
    Writer writer(Form::kText);
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
    Writer writer(Form::kText);
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
    Writer writer(Form::kText);
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

TEST_F(VtkTest, CellsKeepTheirValueAndTheOutsideHasItsOwn) {
    BlockMesh mesh;
    mesh.points = {0, 0, 0, 4, 0, 0, 0, 4, 0, 0, 0, 4, 40, 40, 40};
    mesh.add(5, {0, 1, 2});  // a face, as exporters write them
    mesh.add(10, {0, 1, 2, 3});
    Writer writer(Form::kBase64);
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
    Writer writer(Form::kText);
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
    const auto with = [&](const std::string& fields, Writer* writer) {
        return folder_.write("m.vtu",
                             writer->file("UnstructuredGrid", text_of(mesh, writer, fields)));
    };
    Writer w(Form::kText);
    const std::vector<float> field(64, 1), short_field(63, 1);
    EXPECT_EQ(trouble(with("", &w)), messages::kNoField);
    const std::string two = "<PointData>" + w.array("a", "Float32", 1, field) +
                            w.array("b", "Float32", 1, field) + "</PointData>";
    EXPECT_EQ(trouble(with(two, &w)),
              std::string(messages::kSeveralFields) + "`a`, `b`" + messages::kSeveralFieldsHelp);
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
            "; " + messages::kVtkKindNotReadHelp);
    // The name of a packer stands in files of text, too.
    for (const Form form : {Form::kPacked, Form::kText}) {
        Writer writer(form);
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

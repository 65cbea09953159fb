// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// XDMF files that tests write, as text or with data files of either byte order.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "tests/unit/texture/field_test.h"

namespace openfab::tools {

enum class Form { kText, kLittle, kBig };
inline constexpr std::array kForms{Form::kText, Form::kLittle, Form::kBig};

/// Writes items, and their data files into a folder.
class XdmfWriter {
  public:
    XdmfWriter(Form form, const testing::TempFolder& folder) : form_(form), folder_(folder) {}

    /// `type` are attributes such as `NumberType="Float" Precision="8"`.
    template <typename T>
    std::string item(const std::string& type, const std::string& sizes,
                     const std::vector<T>& values) {
        std::string tag = "<DataItem Dimensions=\"" + sizes + "\" " + type + " Format=\"";
        if (form_ == Form::kText)
            return tag + fmt::format("XML\">\n {}\n</DataItem>", fmt::join(values, " "));
        std::string bytes = "before";
        for (const T value : values) {
            std::array<char, sizeof(T)> at{};
            std::memcpy(at.data(), &value, sizeof value);
            if (form_ == Form::kBig) std::reverse(at.begin(), at.end());
            bytes.append(at.data(), at.size());
        }
        const std::string name = fmt::format("data{}.bin", files_++);
        folder_.write(name, bytes);
        return tag + "Binary\" Seek=\"6\" Endian=\"" + (form_ == Form::kBig ? "Big" : "Little") +
               "\">\n  " + name + "\n</DataItem>";
    }

  private:
    Form form_;
    const testing::TempFolder& folder_;
    int files_ = 0;
};

inline constexpr const char* kFloat64 = R"(NumberType="Float" Precision="8")";
inline constexpr const char* kFloat32 = R"(DataType="Float")";
inline constexpr const char* kInt64 = R"(NumberType="Int" Precision="8")";

inline std::string grid(const std::string& content, const std::string& attributes = "") {
    return "<Grid " + attributes + ">" + content + "</Grid>\n";
}
inline std::string file(const std::string& content) {
    return "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\"><Domain>\n" + content +
           "</Domain></Xdmf>\n";
}
inline std::string attribute(const std::string& name, const std::string& center,
                             const std::string& item) {
    return "<Attribute Name=\"" + name + "\" Center=\"" + center + "\">" + item + "</Attribute>\n";
}

inline std::string points_of(const BlockMesh& mesh, XdmfWriter* writer) {
    return "<Geometry GeometryType=\"XYZ\">" +
           writer->item(kFloat64, std::to_string(mesh.point_count()) + " 3", mesh.points) +
           "</Geometry>\n";
}
inline std::string topology(const std::string& type, size_t cells, const std::string& item) {
    return fmt::format("<Topology TopologyType=\"{}\" NumberOfElements=\"{}\">{}</Topology>\n",
                       type, cells, item);
}
/// Of one type of cells.
inline std::string cells_of(const BlockMesh& mesh, XdmfWriter* writer) {
    const size_t count = mesh.types.size();
    const std::string sizes = fmt::format("{} {}", count, mesh.corners.size() / count);
    const char* type = mesh.types[0] == 10   ? "Tetrahedron"
                       : mesh.types[0] == 12 ? "Hexahedron"
                                             : "Wedge";
    return topology(type, count, writer->item(kInt64, sizes, mesh.corners));
}
inline std::vector<double> field_of(const BlockMesh& mesh) {
    std::vector<double> values;
    for (size_t i = 0; i < mesh.point_count(); ++i)
        values.push_back(linear(mesh.point(i)));
    return values;
}

class XdmfTest : public FieldTest {
  protected:
    /// Checks that the file holds the linear field over the block.
    void expect_linear(const std::string& text) {
        VolumeOptions options;
        options.pitch_mm = 0.21;
        options.field = "E";
        const auto p = converted(folder_.write("m.xdmf", text), options);
        ASSERT_NE(p, nullptr);
        EXPECT_EQ(size(*p), (Vec3i{15, 15, 15}));
        EXPECT_EQ(origin(*p), (Vec3d{-1, 0, 2}));
        int inside = 0;
        each(*p, [&](const Vec3d& at, const float* value) {
            if (at.x > 2 || at.y > 3 || at.z > 5) return;
            ++inside;
            EXPECT_NEAR(*value, linear(at), 2e-6);
        });
        EXPECT_EQ(inside, 14 * 14 * 14);
    }
    std::string message(const std::string& text, const VolumeOptions& options = {}) {
        return trouble(folder_.write("m.xdmf", text), options);
    }
};

}  // namespace openfab::tools

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What PLY files hold in practice: each is carried over, or told.

#include "mesh/read/messages.h"
#include "mesh/read/ply.h"

#include "base/messages.h"
#include "tests/unit/mesh/features.h"

namespace openfab::mesh {
namespace {

constexpr double kHalf = 0.2140411;     // sRGB 0.5 as light
constexpr double kByte128 = 0.2158605;  // sRGB 128 of 255

/// A tetrahedron with more properties; `vertex` and `face` are their values for all.
std::string ply(const std::string& comments, const std::string& vertex_properties,
                const std::string& vertex, const std::string& face_properties = {},
                const std::string& face = {}, const std::string& elements = {},
                const std::string& rest = {}) {
    std::string text = "ply\nformat ascii 1.0\n" + comments +
                       "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n" +
                       vertex_properties +
                       "element face 4\nproperty list uchar int vertex_indices\n" +
                       face_properties + elements + "end_header\n";
    for (const char* p : {"0 0 0 ", "9 0 0 ", "0 9 0 ", "0 0 9 "})
        text += p + vertex + "\n";
    for (const char* f : {"3 0 2 1 ", "3 0 1 3 ", "3 1 2 3 ", "3 0 3 2 "})
        text += f + face + "\n";
    return text + rest;
}

std::string properties(const std::string& type, const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names)
        text += fmt::format("property {} {}\n", type, name);
    return text;
}

TEST(PlyFeatures, AreCarriedOverOrTold) {
    const auto is = [](double value) {
        return [=](const MeshSource& m) {
            return near(value_at(m, "color", 0, 0, 0), value) &&
                   value_at(m, "color", 0, 0, 1) == 0 && look_of(m, 3).vertex_colors &&
                   look_of(m, 3).color == std::array{1.0, 1.0, 1.0} && !look_of(m, 3).is_material;
        };
    };
    const auto shows = [](const std::string& name) {
        return [=](const MeshSource& m) {
            const Look look = look_of(m, 0);
            return look.picture && look.picture->source == name && !look.vertex_colors &&
                   !look.is_material && near(value_at(m, "uv", 0, 0, 0), 0.25) &&
                   near(value_at(m, "uv", 0, 0, 1), 0.75);
        };
    };
    const auto colors = [&](const std::string& type, const std::vector<std::string>& names,
                            const std::string& values) {
        return ply("", properties(type, names), values);
    };
    const std::string picture = "comment TextureFile a.png\n";
    const std::string wedge = "property list uchar float texcoord\n";
    const std::string six = "6 0.25 0.75 0 0 1 1";
    const auto has_faces = [](const MeshSource& m) { return m.mesh.triangles.size() == 4; };
    check_features(
        parse_ply, "m.ply",
        {{"nothing",
          ply("comment a\nobj_info b\n", "", ""),
          {},
          "",
          0,
          [=](const MeshSource& m) { return has_faces(m) && m.looks.empty(); }},
         {"bytes", colors("uchar", {"red", "green", "blue"}, "128 0 0"), {}, "", 0, is(kByte128)},
         {"r g b", colors("uint8", {"r", "g", "b"}, "128 0 0"), {}, "", 0, is(kByte128)},
         {"diffuse",
          colors("uchar", {"diffuse_red", "diffuse_green", "diffuse_blue"}, "128 0 0"),
          {},
          "",
          0,
          is(kByte128)},
         {"16 bits",
          colors("ushort", {"red", "green", "blue"}, "32896 0 0"),
          {},
          "",
          0,
          is(kByte128)},
         {"bytes in larger types",
          colors("int", {"red", "green", "blue"}, "128 0 0"),
          {},
          "",
          0,
          is(kByte128)},
         {"floats", colors("float", {"red", "green", "blue"}, "0.5 0 0"), {}, "", 0, is(kHalf)},
         {"floats of bytes",
          colors("float", {"red", "green", "blue"}, "128 0 0"),
          {},
          "",
          0,
          is(kByte128)},
         {"opaque",
          colors("uchar", {"red", "green", "blue", "alpha"}, "128 0 0 255"),
          {},
          "",
          0,
          is(kByte128)},
         {"transparent",
          colors("uchar", {"red", "green", "blue", "alpha"}, "128 0 0 99"),
          {},
          "`alpha`",
          4,
          is(kByte128)},
         {"of faces",
          ply("", "", "", properties("uchar", {"red", "green", "blue"}), "128 0 0"),
          {},
          "",
          0,
          is(kByte128)},
         {"of faces and vertices",
          ply("", properties("uchar", {"red", "green", "blue"}), "128 0 0",
              properties("uchar", {"red", "green", "blue"}), "0 9 0"),
          {},
          messages::kPropertyLeftOut,
          0,
          is(kByte128)},
         {"picture and s t",
          ply(picture, properties("float", {"s", "t"}), "0.25 0.75"),
          {},
          "",
          0,
          shows("a.png")},
         {"picture and u v",
          ply(picture, properties("float", {"u", "v"}), "0.25 0.75"),
          {},
          "",
          0,
          shows("a.png")},
         {"picture and texture_u",
          ply(picture, properties("float", {"texture_u", "texture_v"}), "0.25 0.75"),
          {},
          "",
          0,
          shows("a.png")},
         {"upper case, blanks, quotes",
          ply("comment TEXTUREFILE \"a b#1.png\"\n", properties("float", {"s", "t"}), "0.25 0.75"),
          {},
          "",
          0,
          shows("a b#1.png")},
         {"wedges", ply(picture, "", "", wedge, six), {}, "", 0, shows("a.png")},
         {"numbers of pictures",
          ply("comment TextureFile b.png\n" + picture, "", "", wedge + "property int texnumber\n",
              six + " 1"),
          {},
          fmt::format(messages::kPictureNotUsed, "b.png"),
          1,
          shows("a.png")},
         {"number of no picture",
          ply(picture, "", "", wedge + "property int texnumber\n", six + " 7"),
          {},
          fmt::format(messages::kPictureBeyondHeader, 1),
          4,
          [](const MeshSource& m) { return look_of(m, 0).name == "none"; }},
         {"faces without a picture",
          ply(picture, properties("uchar", {"red", "green", "blue"}), "128 0 0",
              wedge + "property int texnumber\n", six + " -1"),
          {},
          messages::kPictureNotUsed,
          1,
          is(kByte128)},
         {"picture over colours",
          ply(picture,
              properties("float", {"s", "t"}) + properties("uchar", {"red", "green", "blue"}),
              "0.25 0.75 128 0 0"),
          {},
          "",
          0,
          [=](const MeshSource& m) {
              return is(kByte128)(m) && look_of(m, 0).picture && !look_of(m, 0).tinted;
          }},
         {"picture without coordinates",
          ply(picture, "", ""),
          {},
          fmt::format(messages::kPictureNeedsCoordinates, "a.png"),
          1,
          has_faces},
         {"edges",
          ply("", "", "", "", "", "element edge 2\nproperty int vertex1\n", "0\n1\n"),
          {},
          "`edge`",
          2,
          has_faces},
         {"materials",
          ply("", "", "", "property int material_index\n", "0",
              "element material 1\nproperty uchar red\n", "9\n"),
          {},
          "`material`",
          1,
          has_faces},
         {"byte order mark", "\xEF\xBB\xBF" + ply("", "", ""), {}, "", 0, has_faces},
         {"strips",
          "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty "
          "float z\n"
          "element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n9 0 0\n0 "
          "9 0\n0 0 9\n8 0 2 1 3 -1 0 1 3\n",
          {},
          "",
          0,
          [](const MeshSource& m) {
              return m.mesh.triangles ==
                     std::vector<std::array<int32_t, 3>>{{0, 2, 1}, {1, 2, 3}, {0, 1, 3}};
          }}});
}

TEST(PlyFeatures, RefuseUtf16) {
    const Result<MeshSource> read = parse_ply(std::string("\xFE\xFF\0p\0l\0y", 8), "m.ply");
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().text(),
              "m.ply:1:1: " + fmt::format(openfab::messages::kWideText, "UTF-16") + "; " +
                  openfab::messages::kWideTextHelp);
}

}  // namespace
}  // namespace openfab::mesh

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "base/messages.h"
#include "mesh/read/messages.h"
#include "tests/support/says/says.h"
#include "tests/unit/mesh/mesh_files.h"

namespace openfab::mesh {
namespace {

enum class Kind { kAscii, kLittle, kBig };

/// Writes values in one of the three forms.
class Writer {
  public:
    explicit Writer(Kind kind) : kind_(kind) {}
    template <typename T>
    void add(T value) {
        if (kind_ == Kind::kAscii) {
            text += fmt::format("{} ", value);
        } else {
            append(&text, value, kind_ == Kind::kBig);
        }
    }
    void end_line() {
        if (kind_ == Kind::kAscii) text += "\n";
    }
    std::string text;

  private:
    Kind kind_;
};

constexpr const char* kHead = R"(comment made by a test
element camera 2
property list uchar double path
property short id
element vertex 8
property double x
property float y
property float z
property float nx
property float ny
property float nz
property uchar red
property uchar green
property uchar blue
property float temperature
property int grain_x
property int grain_y
element face 6
property list uchar int vertex_indices
property list uchar float texcoord
property int part
property float weight
property uchar tag_0
property uchar tag_1
end_header
)";

/// A cube of 10 mm made of quads, with every feature of PLY.
std::string cube_ply(Kind kind) {
    Writer w(kind);
    w.text = std::string("ply\nformat ") +
             (kind == Kind::kAscii    ? "ascii"
              : kind == Kind::kLittle ? "binary_little_endian"
                                      : "binary_big_endian") +
             " 1.0\n" + kHead;
    for (int camera = 0; camera < 2; ++camera) {
        w.add(static_cast<uint8_t>(camera + 1));
        for (int i = 0; i <= camera; ++i)
            w.add(0.25);
        w.add(static_cast<int16_t>(-5));
        w.end_line();
    }
    for (int v = 0; v < 8; ++v) {
        w.add(v == 1 || v == 2 || v == 5 || v == 6 ? 10.0 : 0.0);
        w.add(v == 2 || v == 3 || v == 6 || v == 7 ? 10.0f : 0.0f);
        w.add(v >= 4 ? 10.0f : 0.0f);
        w.add(0.0f);
        w.add(0.0f);
        w.add(v >= 4 ? 1.0f : -1.0f);
        w.add(static_cast<uint8_t>(v == 0 ? 255 : 0));
        w.add(static_cast<uint8_t>(128));
        w.add(static_cast<uint8_t>(0));
        w.add(20.5f + static_cast<float>(v));
        w.add(static_cast<int32_t>(v));
        w.add(static_cast<int32_t>(-v));
        w.end_line();
    }
    const int faces[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                             {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
    for (int f = 0; f < 6; ++f) {
        w.add(static_cast<uint8_t>(4));
        for (int v : faces[f])
            w.add(static_cast<int32_t>(v));
        w.add(static_cast<uint8_t>(8));
        for (int i = 0; i < 8; ++i)
            w.add(static_cast<float>(f * 8 + i) / 64);
        w.add(static_cast<int32_t>(f * 100 - 200));
        w.add(static_cast<float>(f) / 2);
        w.add(static_cast<uint8_t>(f));
        w.add(static_cast<uint8_t>(200 + f));
        w.end_line();
    }
    return w.text;
}

TEST(Ply, ReadsAllThreeForms) {
    for (Kind kind : {Kind::kAscii, Kind::kLittle, Kind::kBig}) {
        const Result<LoadedMesh> loaded = parse_bytes(cube_ply(kind), "a.ply");
        ASSERT_TRUE(loaded) << loaded.error().text();
        const Mesh& mesh = loaded->mesh;
        EXPECT_TRUE(loaded->warnings.empty());
        EXPECT_EQ(mesh.triangles.size(), 12u);
        EXPECT_NEAR(testing::signed_volume(mesh), 1000, 1e-9);
        std::vector<std::string> names;
        for (const MeshAttribute& a : mesh.attributes)
            names.push_back(fmt::format("{}{}{}", a.name, a.is_int ? " int" : " ", a.components));
        EXPECT_EQ(names,
                  (std::vector<std::string>{"uv 2", "n 3", "color 3", "temperature 1", "grain 2",
                                            "part int1", "weight 1", "tag int2"}));
        // Triangle 5 is the second half of face 2: corners 0, 5, 4.
        EXPECT_EQ(mesh.triangles[5], (std::array<int32_t, 3>{0, 5, 4}));
        const auto value = [&](const char* name, size_t corner, size_t component) {
            const MeshAttribute& a = *mesh.find(name);
            return a.values[static_cast<size_t>(a.corners[5][corner] * a.components) + component];
        };
        EXPECT_EQ(value("uv", 2, 1), (2 * 8 + 7) / 64.0f);
        EXPECT_EQ(value("n", 1, 2), 1);
        EXPECT_EQ(value("temperature", 1, 0), 25.5f);
        EXPECT_EQ(value("grain", 2, 1), -4);
        EXPECT_EQ(value("color", 0, 0), 1);
        EXPECT_NEAR(value("color", 0, 1), 0.2158605f, 1e-6f);
        EXPECT_EQ(value("weight", 0, 0), 1);
        EXPECT_EQ(mesh.find("part")->faces[5], 0);
        EXPECT_EQ(mesh.find("tag")->faces[10], 2);
        EXPECT_EQ(mesh.find("tag")->faces[11], 202);
    }
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

TEST(Ply, NamesWhatIsWrong) {
    const std::string text = cube_ply(Kind::kAscii);
    EXPECT_EQ(parse_error("plx\n", "a.ply"), std::string("a.ply:1:1: ") + messages::kNotPly);
    EXPECT_EQ(parse_error(replaced(text, "ascii 1.0", "binary 1.0"), "a.ply"),
              "a.ply:2:1: " + fmt::format(messages::kUnknownFormat, "binary"));
    EXPECT_EQ(parse_error(replaced(text, "property double x", "property real x"), "a.ply"),
              "a.ply:8:1: " + fmt::format(messages::kUnknownType, "real"));
    EXPECT_EQ(
        parse_error(replaced(text, "element vertex 8", "element vertex many"), "a.ply"),
        "a.ply:7:1: " + fmt::format(openfab::messages::kNotWholeNumber, "many", 0, 200000000));
    EXPECT_EQ(parse_error(replaced(text, "vertex_indices", "corners"), "a.ply"),
              fmt::format(messages::kFacesWithoutIndices, "a.ply"));
    EXPECT_EQ(parse_error(replaced(text, "0 3 2 1 8", "0 3 2 8 8"), "a.ply"),
              "a.ply:38:1: " + fmt::format(messages::kFaceOfNoVertex, 8, 8));
    EXPECT_EQ(parse_error(replaced(text, "4 0 3 2 1 8", "4 0 3 2 1.5 8"), "a.ply"),
              "a.ply:38:1: " +
                  fmt::format(openfab::messages::kNotWholeNumber, "1.5", -2147483648, 2147483647));
    EXPECT_EQ(parse_error(replaced(text, "element face", "element strip"), "a.ply"),
              fmt::format(messages::kNoSuchElement, "a.ply", "face"));
    const std::string binary = cube_ply(Kind::kLittle);
    EXPECT_EQ(parse_error(binary.substr(0, binary.size() - 3), "a.ply"),
              "a.ply: face 5: the file ends here; it was cut short");
    EXPECT_EQ(parse_error(replaced(binary, "element vertex 8", "element vertex 99999999"), "a.ply")
                  .substr(0, 15),
              "a.ply: vertex 1");
}

/// A tetrahedron with corners alone; the last face has `last` for its last corner.
std::string corners_only(Kind kind, uint8_t corners_of_last = 3, int32_t last = 3) {
    Writer w(kind);
    w.text = std::string("ply\nformat ") +
             (kind == Kind::kAscii    ? "ascii"
              : kind == Kind::kLittle ? "binary_little_endian"
                                      : "binary_big_endian") +
             " 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
             "element face 4\nproperty list uchar int vertex_indices\nend_header\n";
    for (int v = 0; v < 4; ++v) {
        for (int a = 1; a <= 3; ++a)
            w.add(v == a ? 10.25f : 0.0f);
        w.end_line();
    }
    const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    for (int f = 0; f < 4; ++f) {
        w.add(static_cast<uint8_t>(f == 3 ? corners_of_last : 3));
        for (int v : faces[f])
            w.add(static_cast<int32_t>(f == 3 && v == 3 ? last : v));
        w.end_line();
    }
    return w.text;
}

TEST(Ply, ReadsCornersAlone) {
    for (Kind kind : {Kind::kAscii, Kind::kLittle, Kind::kBig}) {
        const Result<LoadedMesh> loaded = parse_bytes(corners_only(kind), "a.ply");
        ASSERT_TRUE(loaded) << loaded.error().text();
        EXPECT_EQ(loaded->mesh.triangles, (std::vector<std::array<int32_t, 3>>{
                                              {0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}));
        EXPECT_EQ(loaded->mesh.positions,
                  (std::vector<Vec3d>{{0, 0, 0}, {10.25, 0, 0}, {0, 10.25, 0}, {0, 0, 10.25}}));
        EXPECT_TRUE(loaded->mesh.attributes.empty());
    }
    const auto little = [](uint8_t corners, int32_t last) {
        return parse_error(corners_only(Kind::kLittle, corners, last), "a.ply");
    };
    EXPECT_EQ(little(3, 4), fmt::format(messages::kFaceNumberOfNoVertex, "a.ply", 3, 4, 4));
    EXPECT_EQ(little(3, -1), fmt::format(messages::kFaceNumberOfNoVertex, "a.ply", 3, "-1", 4));
    EXPECT_EQ(little(4, 3),
              "a.ply: face 3: the file ends before the 4 values of the list `vertex_indices`");
    EXPECT_EQ(little(2, 3), "a.ply: face 3: a face with fewer than 3 corners");
    const std::string whole = corners_only(Kind::kLittle);
    EXPECT_EQ(parse_error(whole.substr(0, whole.size() - 1), "a.ply"),
              "a.ply: face 3: the file ends before the 3 values of the list `vertex_indices`");
    EXPECT_EQ(parse_error(whole.substr(0, whole.size() - 53), "a.ply"),
              "a.ply: vertex 3: the file ends here; it was cut short");
}

TEST(Ply, LeavesOutWhatIsNoAttribute) {
    const std::string text = cube_ply(Kind::kAscii);
    const Result<LoadedMesh> nan = parse_bytes(replaced(text, " 24.5 ", " nan "), "a.ply");
    ASSERT_TRUE(nan) << nan.error().text();
    EXPECT_EQ(nan->mesh.find("temperature"), nullptr);
    EXPECT_EQ(nan->warnings, (std::vector<std::string>{fmt::format(
                                 messages::kPropertyLeftOut, "a.ply", "temperature", "vertex",
                                 fmt::format(messages::kValueTooLargeAt, "vertex", 4))}));
    const Result<LoadedMesh> twice =
        parse_bytes(replaced(text, "float weight", "float temperature"), "a.ply");
    ASSERT_TRUE(twice);
    ASSERT_EQ(twice->warnings.size(), 1u);
    EXPECT_THAT(twice->warnings[0], testing::Says(messages::kNameOfOtherAttribute));
}

/// A truncated list after one of large doubles, which are no valid corners.
TEST(Ply, TakesNoNumbersOfTheListBefore) {
    std::string bytes =
        "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float "
        "y\nproperty float z\nproperty list uchar double far\nelement face 1\nproperty list uchar "
        "int vertex_indices\nend_header\n";
    bytes.append(12, '\0');
    append(&bytes, uint8_t{3});
    for (int i = 0; i < 3; ++i)
        append(&bytes, 1e300);
    append(&bytes, uint8_t{1});
    bytes.append(3, '\0');
    EXPECT_EQ(parse_error(bytes, "a.ply"),
              "a.ply: face 0: the file ends before the 1 values of the list `vertex_indices`");
    // Doubles beyond the floats.
    const std::string far =
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty double x\nproperty double y\nproperty "
        "double z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n1e300 0 0\n";
    EXPECT_THAT(parse_error(far, "a.ply"), testing::Says(openfab::messages::kNotFinite, "1e300"));
}

TEST(Ply, SurvivesDamage) {
    for (Kind kind : {Kind::kAscii, Kind::kLittle, Kind::kBig})
        survive_damage(cube_ply(kind), "a.ply", 400);
}

}  // namespace
}  // namespace openfab::mesh

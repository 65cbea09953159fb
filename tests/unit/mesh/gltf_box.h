// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A box as a glTF file, whose sections a test replaces, and checks of what is read of it.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mesh/read/gltf.h"
#include "tests/unit/mesh/mesh_files.h"

namespace openfab::mesh {

/// Arrays of the files below, by their accessors.
enum : int {
    kPositions,
    kNormals,
    kCoordinates,
    kOtherCoordinates,
    kColours,
    kIndices,
    kMoves,
    kTurns,
    kSizes,
    kShift,
    kClearColours,
    kNoBytes,
    kShortCoordinates,
    kPale,
    kLoose,
    kJoints,
    kShares,
    kInverses,
    kWhite,
};

/// The sections of a file with a box of 1 x 1 x 1.
struct File {
    std::string attributes = R"("POSITION": 0, "TEXCOORD_0": 2)";
    std::string primitive;   ///< more of it
    std::string primitives;  ///< all of them, if more than one
    std::string mesh;        ///< more of it
    std::string materials = R"({"name": "skin"})";
    std::string nodes = R"({"mesh": 0, "name": "box"})";
    std::string scenes = R"({"nodes": [0]})";
    std::string textures = R"({"source": 0})";
    std::string samplers = "{}";
    std::string images = R"({"uri": "a%20b.png"})";
    std::string more;  ///< of the file

    std::string glb() const;
};

inline std::string File::glb() const {
    std::string bytes, views, accessors;
    const auto add = [&]<typename T>(const std::vector<T>& values, const char* shape, int type,
                                     size_t components, const char* rest = "") {
        bytes.resize((bytes.size() + 3) / 4 * 4);
        const size_t view = static_cast<size_t>(std::count(views.begin(), views.end(), '{'));
        views += fmt::format(R"({}{{"buffer": 0, "byteOffset": {}, "byteLength": {}}})",
                             view > 0 ? ", " : "", bytes.size(), values.size() * sizeof(T));
        accessors += fmt::format(
            R"({}{{"bufferView": {}, "componentType": {}, "count": {}, "type": "{}"{}}})",
            view > 0 ? ", " : "", view, type, values.size() / components, shape, rest);
        for (const T& value : values)
            append(&bytes, value);
    };
    std::vector<float> positions, normals, coordinates, others, shift;
    std::vector<uint8_t> colours, clear;
    std::vector<uint16_t> shorts;
    for (int v = 0; v < 8; ++v) {
        const float x = v == 1 || v == 2 || v == 5 || v == 6 ? 1 : 0;
        const float y = v == 2 || v == 3 || v == 6 || v == 7 ? 1 : 0;
        const float z = v >= 4 ? 1 : 0;
        positions.insert(positions.end(), {x, y, z});
        normals.insert(normals.end(), {0, 1, 0});
        coordinates.insert(coordinates.end(), {x, y});
        others.insert(others.end(), {0.25f, 0.5f});
        shift.insert(shift.end(), {0, 2, 0});
        colours.insert(colours.end(), {255, 51, 0, 255});
        clear.insert(clear.end(), {255, 51, 0, 128});
        shorts.insert(shorts.end(), {static_cast<uint16_t>(x * 65535), 0});
    }
    const std::vector<uint16_t> indices = {0, 3, 2, 0, 2, 1, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                           1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7};
    add(positions, "VEC3", 5126, 3);
    add(normals, "VEC3", 5126, 3);
    add(coordinates, "VEC2", 5126, 2);
    add(others, "VEC2", 5126, 2);
    add(colours, "VEC4", 5121, 4, R"(, "normalized": true)");
    add(indices, "SCALAR", 5123, 1);
    add(std::vector<float>{0, 0, 0, 3, 0, 0, 6, 0, 0}, "VEC3", 5126, 3);
    add(std::vector<int16_t>{0, 0, 0, 32767, 0, 0, 32767, 0, 32767, 0, 0, 0}, "VEC4", 5122, 4,
        R"(, "normalized": true)");
    add(std::vector<float>{1, 1, 1, 2, 2, 2, 1, 1, -1}, "VEC3", 5126, 3);
    add(shift, "VEC3", 5126, 3);
    add(clear, "VEC4", 5121, 4, R"(, "normalized": true)");
    accessors += R"(, {"componentType": 5126, "count": 8, "type": "VEC3"})";
    add(shorts, "VEC2", 5123, 2, R"(, "normalized": true)");
    add(std::vector<float>(24, 0.5f), "VEC3", 5126, 3);
    add(std::vector<uint8_t>(32, 51), "VEC4", 5121, 4);
    std::vector<uint8_t> joints;
    std::vector<float> shares, inverses;
    for (int v = 0; v < 8; ++v) {
        joints.insert(joints.end(), {0, 1, 0, 0});
        shares.insert(shares.end(), {0.5f, 0.5f, 0, 0});
    }
    for (const float down : {0.0f, -1.0f})
        inverses.insert(inverses.end(), {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, down, 0, 1});
    add(joints, "VEC4", 5121, 4);
    add(shares, "VEC4", 5126, 4);
    add(inverses, "MAT4", 5126, 16);
    add(std::vector<float>(24, 1.0f), "VEC3", 5126, 3);
    const std::string all =
        primitives.empty()
            ? fmt::format(R"({{"attributes": {{{}}}, "indices": 5, "material": 0{}}})", attributes,
                          primitive)
            : primitives;
    const std::string json = fmt::format(
        R"({{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{}], "nodes": [{}],
 "meshes": [{{"name": "mesh", "primitives": [{}]{}}}], "materials": [{}], "textures": [{}],
 "samplers": [{}], "images": [{}], "accessors": [{}], "bufferViews": [{}],
 "buffers": [{{"byteLength": {}}}]{}}})",
        scenes, nodes, all, mesh, materials, textures, samplers, images, accessors, views,
        bytes.size(), more);
    return mesh::glb(json, bytes);
}

inline File with(std::string File::*section, const std::string& text) {
    File file;
    file.*section = text;
    return file;
}
inline File with_material(const std::string& text) {
    return with(&File::materials, R"({"name": "skin", )" + text + "}");
}
/// A material of a picture at the texture 0, with more of the texture's use.
inline File with_picture(const std::string& use = "", const std::string& material = "") {
    return with_material(fmt::format(
        R"("pbrMetallicRoughness": {{"baseColorTexture": {{"index": 0{}}}}}{})", use, material));
}
inline File with_colours(int accessor, const std::string& material) {
    File file = with_material(material);
    file.attributes = fmt::format(R"("POSITION": 0, "TEXCOORD_0": 2, "COLOR_0": {})", accessor);
    return file;
}
inline File and_more(File file, std::string File::*section, const std::string& text) {
    file.*section = text;
    return file;
}

using Told = std::vector<std::string>;
using Check = std::function<void(const MeshSource&)>;

/// Returns the value of an attribute at the first corner of the first triangle.
inline std::vector<float> first_value(const MeshSource& source, const char* name,
                                      size_t triangle = 0) {
    const MeshAttribute* a = source.mesh.find(name);
    if (a == nullptr || a->corners[triangle][0] < 0) return {};
    const auto n = static_cast<size_t>(a->components);
    const float* at = &a->values[static_cast<size_t>(a->corners[triangle][0]) * n];
    return {at, at + n};
}

inline const Look& look_of(const MeshSource& source, size_t triangle = 0) {
    const auto& group = source.groups[static_cast<size_t>(source.face_groups[triangle])];
    return source.looks.at(static_cast<size_t>(group.look));
}

using Rgb = std::array<double, 3>;

/// The look is of this colour, without a picture.
inline Check is_plain(Rgb colour, double alpha = 1) {
    return [=](const MeshSource& source) {
        const Look& look = look_of(source);
        EXPECT_EQ(look.color, std::optional(colour));
        EXPECT_EQ(look.alpha, alpha);
        EXPECT_FALSE(look.picture);
        EXPECT_FALSE(look.vertex_colors);
        EXPECT_TRUE(look.is_material);
        EXPECT_EQ(look.name, "skin");
    };
}
/// The look has this picture, tinted.
inline Check shows(const std::string& name, Rgb tint = {1, 1, 1}) {
    return [=](const MeshSource& source) {
        const Look& look = look_of(source);
        ASSERT_TRUE(look.picture);
        EXPECT_EQ(look.picture->name, name);
        EXPECT_EQ(look.color, std::optional(tint));
        EXPECT_TRUE(look.tinted);
    };
}
inline Check wraps(PictureWrap u, PictureWrap v) {
    return [=](const MeshSource& source) {
        ASSERT_TRUE(look_of(source).picture);
        EXPECT_EQ(look_of(source).picture->wrap, (std::array{u, v}));
    };
}
inline Check is_covered(PictureUse::Alpha alpha, double of_colour, double from = 0.5) {
    return [=](const MeshSource& source) {
        ASSERT_TRUE(look_of(source).picture);
        EXPECT_EQ(look_of(source).picture->alpha, alpha);
        EXPECT_EQ(look_of(source).alpha, of_colour);
        EXPECT_EQ(look_of(source).picture->mask_from, from);
    };
}
inline Check has_value(const char* attribute, const std::vector<float>& value) {
    return [=](const MeshSource& source) {
        const std::vector<float> found = first_value(source, attribute);
        ASSERT_EQ(found.size(), value.size()) << attribute;
        for (size_t c = 0; c < value.size(); ++c)
            EXPECT_NEAR(found[c], value[c], 1e-6) << attribute << c;
    };
}
inline Check are_bodies(const std::vector<std::string>& names) {
    return [=](const MeshSource& source) {
        std::vector<std::string> found;
        for (const Body& body : source.bodies)
            found.push_back(body.name);
        EXPECT_EQ(found, names);
        EXPECT_EQ(source.mesh.triangles.size(), names.size() * 12);
    };
}
inline Check all_of(const std::vector<Check>& checks) {
    return [=](const MeshSource& source) {
        for (const Check& check : checks)
            check(source);
    };
}

}  // namespace openfab::mesh

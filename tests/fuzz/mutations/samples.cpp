// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/mutations/samples.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/support/meshes/temp_folder.h"
#include "tests/support/meshes/zip_archive.h"

namespace openfab::testing {

namespace {

constexpr const char* kWorld = R"({
  "openfab": 1,
  "printer": "own.printer.json",
  "tray": "center",
  "fablets": {"f": {"source": "f.fl", "fablet": "Skin"}},
  "materials": {
    "white": {"key": "#ffffff", "preview": "#f0f0f0ff", "density_g_cm3": 1.18},
    "black": {"key": "#000000", "preview": "#101010ff", "density_g_cm3": 1.18, "channel": "B"}
  },
  "meshes": {
    "ball": {"sphere": 3},
    "block": {"box": [3, 2, 2]},
    "part": {"file": "part.obj", "unit": "mm"}
  },
  "objects": {
    "ball": {"mesh": "ball", "fablet": "f", "uniforms": {"a": "white", "b": "black"}, "priority": 1},
    "part": {"mesh": "part", "fablet": "f", "uniforms": {"a": "black", "b": "VOID"}, "repair": "winding"},
    "block": {"mesh": "block", "fablet": "f", "uniforms": {"a": "white", "b": "black"}, "max_displacement_mm": 0.5}
  },
  "groups": {
    "pair": [{"object": "ball"}, {"object": "block", "translate_mm": [2, 0, 0], "rotate_deg": [0, 30, 5]}]
  },
  "build": [
    {"group": "pair", "translate_mm": [4, 4], "scale": [1, -1, 1], "uniforms": {"ball.a": "black"}},
    {"object": "part", "grid": {"count": [2, 2], "spacing_mm": 0.5}},
    {"object": "block", "matrix": [1, 0.2, 0, -5, 0, 1, 0, 0, 0, 0, 1, 0]},
    {"object": "ball", "transforms": "places.txt"}
  ]
}
)";

constexpr const char* kPrinter = R"({
  "name": "own", "dpi": [60, 60], "layer_um": 400, "build_volume_mm": [90, 90, 50],
  "max_materials": 6, "native_format": "ofr", "makes_support": true, "layer_time_s": 5,
  "handoff": "nothing",
  "process": {
    "scale": [1.01, 1, 0.99], "about_mm": [1, 2, 0],
    "dead": [{"material": "black", "nozzles": [3, [5, 9]], "substitute": "white", "head": 96,
              "passes": 2, "pass": 1, "jog": 7}],
    "cost": {"currency": "EUR", "price_ml": {"white": 0.3, "*": 0.5}, "waste_ml_swath": 0.01,
             "swath_mm": 60, "passes": 2, "seconds_pass": 3, "seconds_layer": 2}
  }
}
)";

constexpr const char* kPlaces = "-9 -9 0\n# twelve numbers\n1 0 0 9 0 0.5 0 -9 0 0 1 0\n";

constexpr const char* kObj = R"(mtllib part.mtl
v 0 0 0
v 2 0 0
v 2 2 0
v 0 2 0
v 0 0 2
v 2 0 2
v 2 2 2
v 0 2 2
vt 0 0
vt 1 1
vn 0 0 1
g bottom
usemtl red
f 4/1/1 3/2/1 2/1/1 1/2/1
g sides
usemtl green
f 1 2 6 5
f 2 3 7 6
f -6 -5 -1 -2
f 4 1 5 8
g top
f 5//1 6//1 7//1 8//1
)";

constexpr const char* kMtl =
    "newmtl red\nKd 1 0 0\nmap_Kd red.png\nnewmtl green\nKd 0 1 0\nd 0.5\n";

constexpr std::array<std::array<float, 3>, 8> kCorners{
    {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2}, {2, 0, 2}, {2, 2, 2}, {0, 2, 2}}};
constexpr std::array<std::array<int, 3>, 12> kTriangles{{{3, 2, 1},
                                                         {3, 1, 0},
                                                         {4, 5, 6},
                                                         {4, 6, 7},
                                                         {0, 1, 5},
                                                         {0, 5, 4},
                                                         {1, 2, 6},
                                                         {1, 6, 5},
                                                         {2, 3, 7},
                                                         {2, 7, 6},
                                                         {3, 0, 4},
                                                         {3, 4, 7}}};

template <typename T>
void append(std::string* bytes, T value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes->append(raw, sizeof value);
}

std::string stl_text() {
    std::string text = "solid cube\n";
    for (const auto& t : kTriangles) {
        text += "facet normal 0 0 0\nouter loop\n";
        for (int corner : t) {
            const auto& p = kCorners[corner];
            text += fmt::format("vertex {} {} {}\n", p[0], p[1], p[2]);
        }
        text += "endloop\nendfacet\n";
    }
    return text + "endsolid cube\n";
}

std::string stl_binary() {
    std::string bytes(80, ' ');
    append(&bytes, static_cast<uint32_t>(kTriangles.size()));
    for (const auto& t : kTriangles) {
        bytes.append(12, '\0');
        for (int corner : t) {
            for (float x : kCorners[corner])
                append(&bytes, x);
        }
        append(&bytes, uint16_t{0});
    }
    return bytes;
}

std::string ply(bool binary) {
    std::string text = fmt::format(
        "ply\nformat {} 1.0\ncomment a cube\nelement vertex 8\nproperty float x\nproperty float y\n"
        "property float z\nproperty uchar red\nelement face 12\n"
        "property list uchar int vertex_indices\nproperty int part\nend_header\n",
        binary ? "binary_little_endian" : "ascii");
    for (const auto& p : kCorners) {
        if (!binary) {
            text += fmt::format("{} {} {} 200\n", p[0], p[1], p[2]);
            continue;
        }
        for (float x : p)
            append(&text, x);
        append(&text, uint8_t{200});
    }
    for (const auto& t : kTriangles) {
        if (!binary) {
            text += fmt::format("3 {} {} {} 1\n", t[0], t[1], t[2]);
            continue;
        }
        append(&text, uint8_t{3});
        for (int corner : t)
            append(&text, int32_t{corner});
        append(&text, int32_t{1});
    }
    return text;
}

std::string threemf_model() {
    std::string text =
        R"(<?xml version="1.0" encoding="UTF-8"?>
<model unit="millimeter" xml:lang="en-US" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">
<resources><basematerials id="5"><base name="white" displaycolor="#FFFFFF"/><base name="black" displaycolor="#000000FF"/></basematerials>
<object id="1" type="model" pid="5" pindex="0"><mesh><vertices>
)";
    for (const auto& p : kCorners)
        text += fmt::format("<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>\n", p[0], p[1], p[2]);
    text += "</vertices><triangles>\n";
    for (const auto& t : kTriangles)
        text += fmt::format("<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\"/>\n", t[0], t[1], t[2]);
    return text + R"(</triangles></mesh></object>
<object id="2" type="model"><components><component objectid="1"/><component objectid="1" transform="1 0 0 0 1 0 0 0 1 5 0 0"/></components></object>
</resources><build><item objectid="2" transform="1 0 0 0 1 0 0 0 1 1 2 3"/></build></model>
)";
}

std::string package(const std::string& model) {
    return testing::zip_archive(
        {{"_rels/.rels",
          R"(<?xml version="1.0"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="r0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>)"},
         {"3D/3dmodel.model", model}});
}

std::string gltf_buffer() {
    std::string bytes;
    for (const auto& p : kCorners) {
        for (float x : p)
            append(&bytes, x);
    }
    for (const auto& t : kTriangles) {
        for (int corner : t)
            append(&bytes, static_cast<uint16_t>(corner));
    }
    return bytes;
}

std::string gltf(const std::string& buffer) {
    return fmt::format(R"({{
  "asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}],
  "nodes": [{{"mesh": 0, "rotation": [0, 0, 0, 1], "scale": [0.001, 0.001, 0.001], "children": [1]}}, {{"mesh": 0, "translation": [5, 0, 0], "scale": [1, 1, 2]}}],
  "materials": [{{"name": "white", "pbrMetallicRoughness": {{"baseColorFactor": [1, 1, 1, 1]}}}}],
  "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "_HEAT": 2}}, "indices": 1, "material": 0, "mode": 4}}]}}],
  "accessors": [
    {{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [0, 0, 0], "max": [2, 2, 2]}},
    {{"bufferView": 1, "byteOffset": 0, "componentType": 5123, "count": 36, "type": "SCALAR"}},
    {{"bufferView": 0, "componentType": 5126, "count": 8, "type": "SCALAR"}}],
  "bufferViews": [
    {{"buffer": 0, "byteOffset": 0, "byteLength": 96, "byteStride": 12, "target": 34962}},
    {{"buffer": 0, "byteOffset": 96, "byteLength": 72, "target": 34963}}],
  "buffers": [{}]
}}
)",
                       buffer);
}

std::string glb(const std::string& json) {
    std::string text = json;
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const std::string buffer = gltf_buffer();
    std::string out = "glTF";
    append(&out, uint32_t{2});
    append(&out, static_cast<uint32_t>(28 + text.size() + buffer.size()));
    append(&out, static_cast<uint32_t>(text.size()));
    out += "JSON" + text;
    append(&out, static_cast<uint32_t>(buffer.size()));
    return out + std::string("BIN\0", 4) + buffer;
}

bool write_picture(const std::string& file) {
    const auto out = OIIO::ImageOutput::create(file);
    if (out == nullptr) return false;
    const OIIO::ImageSpec spec(7, 5, 3,
                               file.ends_with(".exr") || file.ends_with(".hdr")
                                   ? OIIO::TypeDesc::FLOAT
                                   : OIIO::TypeDesc::UINT8);
    std::array<uint8_t, 7 * 5 * 3> pixels{};
    for (size_t i = 0; i < pixels.size(); ++i)
        pixels[i] = static_cast<uint8_t>(i * 37);
    return out->open(file, spec) && out->write_image(OIIO::TypeDesc::UINT8, pixels.data()) &&
           out->close();
}

/// A picture of 7 x 5 pixels in the format of the name. Written by another process: OpenImageIO
/// starts threads, for which a process that forks later would wait forever.
std::string picture(const std::string& name) {
    const testing::TempFolder folder;
    const std::string file = (folder.path() / name).string();
    const pid_t child = ::fork();
    if (child == 0) ::_exit(write_picture(file) ? 0 : 1);
    int status = 0;
    ::waitpid(child, &status, 0);
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::string npy() {
    std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (3, 2, 2), }";
    header.resize(117, ' ');
    header += '\n';
    std::string out = "\x93NUMPY\x01";
    out += '\0';
    append(&out, static_cast<uint16_t>(header.size()));
    out += header;
    for (int i = 0; i < 12; ++i)
        append(&out, 0.1F * static_cast<float>(i));
    return out;
}

constexpr const char* kNrrd =
    "NRRD0004\ntype: float\ndimension: 3\nsizes: 2 2 2\nencoding: ascii\nspacings: 1 2 0.5\n\n0 1 "
    "2 "
    "3\n4 5 6 7\n";

constexpr const char* kCube =
    "TITLE \"mix\"\nLUT_3D_SIZE 2\nDOMAIN_MIN 0 0 0\nDOMAIN_MAX 1 1 1\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n"
    "0 0 1\n1 0 1\n0 1 1\n1 1 1\n";

}  // namespace

std::vector<std::pair<std::string, std::string>> sound_files() {
    return {
        {"f.fl", "fablet Skin {}\n"}, {"world.fab.json", kWorld}, {"own.printer.json", kPrinter},
        {"places.txt", kPlaces},      {"part.obj", kObj},         {"part.mtl", kMtl}};
}

std::vector<Sample> samples() {
    using Kind = Sample::Kind;
    // The base64 of the cube's buffer is too long to be worth damaging; a separate file is used.
    const std::string buffer = R"({"byteLength": 168, "uri": "cube.bin"})";
    std::vector<Sample> all{
        {"world.fab.json", Kind::kWorld, true, kWorld, {}, {}},
        {"own.printer.json", Kind::kPart, true, kPrinter, {}, "world.fab.json"},
        {"places.txt", Kind::kPart, true, kPlaces, {}, "world.fab.json"},
        {"part.mtl", Kind::kPart, true, kMtl, {}, "part.obj"},
        {"part.obj", Kind::kMesh, true, kObj, {}, {}},
        {"text.stl", Kind::kMesh, true, stl_text(), {}, {}},
        {"binary.stl", Kind::kMesh, false, stl_binary(), {}, {}},
        {"text.ply", Kind::kMesh, true, ply(false), {}, {}},
        {"binary.ply", Kind::kMesh, false, ply(true), {}, {}},
        {"model.3mf", Kind::kMesh, true, threemf_model(), package, {}},
        {"bytes.3mf", Kind::kMesh, false, package(threemf_model()), {}, {}},
        {"cube.gltf", Kind::kMesh, true, gltf(buffer), {}, {}},
        {"cube.bin", Kind::kPart, false, gltf_buffer(), {}, "cube.gltf"},
        {"model.glb", Kind::kMesh, true, gltf(R"({"byteLength": 168})"), glb, {}},
        {"bytes.glb", Kind::kMesh, false, glb(gltf(R"({"byteLength": 168})")), {}, {}},
        {"v.npy", Kind::kVolume, false, npy(), {}, {}},
        {"v.nrrd", Kind::kVolume, true, kNrrd, {}, {}},
        {"v.cube", Kind::kVolume, true, kCube, {}, {}},
    };
    for (const char* name : {"i.png", "i.jpg", "i.tif", "i.exr", "i.hdr", "i.ppm"})
        all.push_back({name, Kind::kImage, false, picture(name), {}, {}});
    return all;
}

}  // namespace openfab::testing

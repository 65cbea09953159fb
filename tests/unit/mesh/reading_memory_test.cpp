// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Small files with large claims: memory and time of reading stay below their limits, whether the
// file is read or refused.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "base/caret.h"
#include "base/messages.h"
#include "base/xml.h"
#include "mesh/model/messages.h"
#include "mesh/read/messages.h"
#include "tests/support/memory/meter.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/meshes/zip_archive.h"
#include "tests/support/says/says.h"
#include "tests/unit/mesh/ball_mesh.h"
#include "tests/unit/mesh/mesh_files.h"

namespace openfab::mesh {
namespace {

constexpr int64_t kMegabyte = 1'000'000;

/// Returns the error for a file; memory must stay below the limit.
std::string refusal(const std::string& bytes, const std::string& file,
                    int64_t memory_bytes = 50 * kMegabyte) {
    const testing::TempFolder folder;
    const std::filesystem::path path = folder.write(file, bytes);
    MeshOptions options;
    options.name = "part";
    options.memory_bytes = memory_bytes;
    const testing::Meter meter;
    std::string message;
    {
        const Result<LoadedMesh> loaded = load_mesh(path, options);
        message = loaded ? "no error" : loaded.error().text();
    }
    EXPECT_LE(meter.peak_bytes(), memory_bytes + 2 * kMegabyte) << file;
    EXPECT_LT(meter.seconds(), testing::kHangSeconds) << file;
    return message;
}

#define EXPECT_SAYS(text, ...) EXPECT_THAT(text, testing::Says(__VA_ARGS__))

std::string threemf(const std::string& resources, const std::string& build) {
    return testing::zip_archive(
        {{"_rels/.rels",
          R"(<Relationships><Relationship Target="/3D/3dmodel.model" Id="r0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>)"},
         {"3D/3dmodel.model",
          R"(<model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources>)" +
              resources + "</resources><build>" + build + "</build></model>"}});
}

std::string tetrahedra(int count) {
    std::string vertices, triangles;
    for (int i = 0; i < count; ++i) {
        for (const char* p : {R"(x="0" y="0" z="0")", R"(x="9" y="0" z="0")",
                              R"(x="0" y="9" z="0")", R"(x="0" y="0" z="9")"})
            vertices += fmt::format("<vertex {}/>", p);
        for (const auto& t : {std::array{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}})
            triangles += fmt::format(R"(<triangle v1="{}" v2="{}" v3="{}"/>)", 4 * i + t[0],
                                     4 * i + t[1], 4 * i + t[2]);
    }
    return "<mesh><vertices>" + vertices + "</vertices><triangles>" + triangles +
           "</triangles></mesh>";
}

std::string components(int object, int count) {
    std::string text = "<components>";
    for (int i = 0; i < count; ++i)
        text += fmt::format(R"(<component objectid="{}"/>)", object);
    return text + "</components>";
}

TEST(ReadingMemory, CountsComponentsOf3mfBeforeItMakesThem) {
    // 40 x 40 x 40 placements of 500 tetrahedra: 128 million triangles.
    const std::string nested = R"(<object id="1">)" + tetrahedra(500) + "</object>" +
                               R"(<object id="2">)" + components(1, 40) + "</object>" +
                               R"(<object id="3">)" + components(2, 40) + "</object>" +
                               R"(<object id="4">)" + components(3, 40) + "</object>";
    EXPECT_SAYS(refusal(threemf(nested, R"(<item objectid="4"/>)"), "a.3mf"),
                messages::kBuildTooManyTriangles);
    EXPECT_SAYS(refusal(threemf(nested, R"(<item objectid="3"/>)"), "a.3mf"),
                messages::kTooLargeToRead, "*", 3200000);
    EXPECT_SAYS(refusal(threemf(nested, R"(<item objectid="3"/>)"), "a.3mf"), "`--memory 4GB`");
    const std::string laughs = R"(<object id="1">)" + tetrahedra(1) + "</object>" + [] {
        std::string text;
        for (int i = 2; i < 12; ++i)
            text += fmt::format(R"(<object id="{}">)", i) + components(i - 1, 20) + "</object>";
        return text;
    }();
    EXPECT_SAYS(refusal(threemf(laughs, R"(<item objectid="11"/>)"), "a.3mf"),
                fmt::format(messages::kTooManyObjects, 100000));
}

TEST(ReadingMemory, BoundsWhatA3mfUnpacksTo) {
    EXPECT_SAYS(refusal(threemf(std::string(60'000'000, ' '), ""), "a.3mf"),
                messages::kEntryTakesTooMuch, 61, 49);
    // Within the memory, but with a compression ratio of no legitimate file.
    EXPECT_SAYS(refusal(threemf(std::string(60'000'000, ' '), ""), "a.3mf", 400 * kMegabyte),
                messages::kEntryUnpacksTooFar);
    // Elements without a mesh.
    std::string picks = R"(<multiproperties id="1" pids="2">)";
    for (int64_t i = 0; i < 500'000; ++i)
        picks += fmt::format(R"(<multi pindices="{}"/>)", i * 7919 % 65536);
    EXPECT_SAYS(refusal(threemf(picks + "</multiproperties>", ""), "a.3mf"),
                messages::kModelTakesTooMuch);
}

TEST(ReadingMemory, LimitsLayersOfMultiproperties) {
    std::string pids;
    for (int i = 0; i < 100'000; ++i)
        pids += "2 ";
    const std::string many = R"(<colorgroup id="2"><color color="#ff0000"/></colorgroup>)"
                             R"(<multiproperties id="5" pids=")" +
                             pids + R"("><multi pindices="0"/></multiproperties>)" +
                             R"(<object id="1" pid="5" pindex="0">)" + tetrahedra(5000) +
                             "</object>";
    EXPECT_SAYS(refusal(threemf(many, R"(<item objectid="1"/>)"), "a.3mf"),
                fmt::format(messages::kTooManyMultiproperties, 100000) + "; " +
                    fmt::format(messages::kAtMost, 16));
}

TEST(ReadingMemory, LimitsTagsOfXml) {
    class Nothing : public XmlHandler {
        Complaint start(std::string_view, const XmlAttributes&) override { return {}; }
        void end(std::string_view) override {}
    } nothing;
    // White space between tags is not a tag.
    EXPECT_TRUE(parse_xml("<a>" + std::string(80'000'000, ' ') + "<b/></a>", "x", &nothing));
    const testing::Meter meter;
    std::string tag = "<a>\n<b c=\"";
    tag.resize(120'000'000, 'c');
    const Result<void> parsed = parse_xml(tag + "\"/></a>", "x", &nothing);
    ASSERT_FALSE(parsed);
    EXPECT_EQ(parsed.error().text(), "x:2:1: " + fmt::format(openfab::messages::kLongToken, 32));
    EXPECT_LT(meter.seconds(), testing::kHangSeconds);
}

TEST(ReadingMemory, LimitsNamesOf3mf) {
    // A name is copied for each object that contains it.
    std::string nested = R"(<object id="1">)" + tetrahedra(1) + "</object>";
    for (int i = 2; i < 25'000; ++i)
        nested += fmt::format(
            R"(<object id="{}" name="{}{}"><components><component objectid="1"/></components></object>)",
            i, i, std::string(990, 'x'));
    std::string build;
    for (int i = 2; i < 25'000; ++i)
        build += fmt::format(R"(<item objectid="{}"/>)", i);
    EXPECT_SAYS(refusal(threemf(nested, build), "a.3mf", 90 * kMegabyte),
                messages::kAllowMoreMemory);
    EXPECT_SAYS(refusal(threemf(R"(<object id="1" name=")" + std::string(2000, 'x') + R"("/>)", ""),
                        "a.3mf"),
                fmt::format(messages::kNameTooLong, 2000, 1000));
}

/// `nodes` nodes of one mesh: `primitives` times a square of `quads` quads.
std::string gltf(int nodes, int primitives, int quads, const std::string& more = "") {
    const int side = quads + 1;
    std::string bytes;
    for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
            for (const int v : {x, y, 0})
                append(&bytes, static_cast<float>(v));
        }
    }
    const size_t positions = bytes.size();
    for (int y = 0; y < quads; ++y) {
        for (int x = 0; x < quads; ++x) {
            const int a = y * side + x;
            for (const int v : {a, a + 1, a + side, a + 1, a + side + 1, a + side})
                append(&bytes, static_cast<uint16_t>(v));
        }
    }
    std::string json = R"({"asset":{"version":"2.0"},"nodes":[)";
    for (int i = 0; i < nodes; ++i)
        json += fmt::format(R"({}{{"mesh":0}})", i > 0 ? "," : "");
    json += R"(],"meshes":[{"primitives":[)";
    for (int i = 0; i < primitives; ++i)
        json += fmt::format(R"({}{{"attributes":{{"POSITION":0}},"indices":1{}}})",
                            i > 0 ? "," : "", more);
    json += fmt::format(
        R"(]}}],"accessors":[{{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3"}},)"
        R"({{"bufferView":1,"componentType":5123,"count":{},"type":"SCALAR"}}],)"
        R"("bufferViews":[{{"buffer":0,"byteLength":{}}},{{"buffer":0,"byteOffset":{},"byteLength":{}}}],)"
        R"("buffers":[{{"byteLength":{}}}]}})",
        side * side, quads * quads * 6, positions, positions, bytes.size() - positions,
        bytes.size());
    return mesh::glb(json, bytes);
}

/// Long names of nested objects, and an object of many materials, placed many times.
std::string named_materials(int materials, int placed) {
    constexpr int kDeep = 30;
    std::string resources = R"(<basematerials id="1">)";
    for (int i = 0; i < materials; ++i)
        resources += fmt::format(R"(<base name="m{}" displaycolor="#ffffff"/>)", i);
    resources += R"(</basematerials><object id="2"><mesh><vertices>)";
    for (const char* p : {R"(x="0" y="0" z="0")", R"(x="9" y="0" z="0")", R"(x="0" y="9" z="0")"})
        resources += fmt::format("<vertex {}/>", p);
    resources += "</vertices><triangles>";
    for (int i = 0; i < materials; ++i)
        resources += fmt::format(R"(<triangle v1="0" v2="1" v3="2" pid="1" p1="{}"/>)", i);
    resources += "</triangles></mesh></object>";
    for (int i = 0; i < kDeep; ++i)
        resources += fmt::format(
            R"(<object id="{}" name="{}{}"><components><component objectid="{}"/></components></object>)",
            i + 3, std::string(990, 'x'), i, i + 2);
    std::string build;
    for (int i = 0; i < placed; ++i)
        build += fmt::format(R"(<item objectid="{}"/>)", kDeep + 2);
    return threemf(resources, build);
}

TEST(ReadingMemory, GoesThroughNamesOf3mfOnceAPlacement) {
    EXPECT_SAYS(refusal(named_materials(5, 500), "a.3mf", 400 * kMegabyte), "open edges");
    EXPECT_SAYS(refusal(named_materials(400, 2000), "a.3mf", 400 * kMegabyte),
                messages::kAllowMoreMemory);
}

TEST(ReadingMemory, LimitsExtensionsOf3mf) {
    std::string prefixes, attributes;
    for (int i = 0; i < 100'000; ++i)
        prefixes += "m ";
    for (int i = 0; i < 20'000; ++i)
        attributes += fmt::format(R"( xmlns:a{}="http://x/material/")", i);
    const std::string model =
        R"(<model xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" )" +
        attributes + R"( xmlns:m="http://x/material/" requiredextensions=")" + prefixes +
        R"("><resources/><build/></model>)";
    EXPECT_SAYS(
        refusal(
            testing::zip_archive(
                {{"_rels/.rels",
                  R"(<Relationships><Relationship Target="/m.model" Id="r0" Type="x/3dmodel"/></Relationships>)"},
                 {"m.model", model}}),
            "a.3mf"),
        fmt::format(messages::kTooManyExtensions, 100000, 64));
}

/// Returns `archive` with `count` more directory entries, all for the data of the last one.
std::string overlapping(std::string archive, int count) {
    const size_t end = archive.size() - 22;
    uint32_t directory = 0;
    std::memcpy(&directory, archive.data() + end + 16, 4);
    size_t last = archive.rfind(std::string("PK\1\2"), end);
    const std::string entry = archive.substr(last, end - last);
    std::string out = archive.substr(0, end);
    for (int i = 0; i < count; ++i) {
        std::string again = entry;
        const std::string number = fmt::format("{:05}", i);
        std::copy(number.begin(), number.end(), again.begin() + 46);  // its name
        out += again;
    }
    std::string tail = archive.substr(end);
    uint16_t entries = 0;
    std::memcpy(&entries, tail.data() + 10, 2);
    entries = static_cast<uint16_t>(entries + count);
    std::memcpy(tail.data() + 8, &entries, 2);
    std::memcpy(tail.data() + 10, &entries, 2);
    const auto size = static_cast<uint32_t>(out.size() - directory);
    std::memcpy(tail.data() + 12, &size, 4);
    return out + tail;
}

TEST(ReadingMemory, RefusesEntriesOf3mfThatLieOverEachOther) {
    constexpr int kParts = 3000;
    std::string build;
    for (int i = 0; i < kParts; ++i)
        build += fmt::format(R"(<item objectid="1" p:path="/{:05}.model"/>)", i);
    const auto archive = [&](const std::string& blanks) {
        return testing::zip_archive(
            {{"_rels/.rels",
              R"(<Relationships><Relationship Target="/3d.model" Id="r0" Type="x/3dmodel"/></Relationships>)"},
             {"3d.model",
              R"(<model xmlns="c" xmlns:p="p"><resources/><build>)" + build + "</build></model>"},
             {"part0.model", "<model xmlns=\"c\"><resources><object id=\"1\"/>" + blanks +
                                 "</resources><build/></model>"}});
    };
    EXPECT_SAYS(refusal(overlapping(archive(std::string(20'000'000, ' ')), kParts), "a.3mf"),
                messages::kEntriesTooLarge);
    // Without overlap this is legitimate: 60 times 9 MB in 600 kB.
    std::vector<std::pair<std::string, std::string>> parts = {{"stored", ""}};
    for (int i = 0; i < 60; ++i)
        parts.emplace_back(fmt::format("{}.model", i), std::string(9'000'000, ' '));
    EXPECT_SAYS(refusal(testing::zip_archive(parts), "a.3mf"), messages::kArchiveUnpacksTooFar);
}

TEST(ReadingMemory, CountsInstancesOfGltfBeforeItMakesThem) {
    EXPECT_SAYS(refusal(gltf(3000, 1, 60), "a.glb"), messages::kTooLargeToRead, "*", 21600000);
    EXPECT_SAYS(refusal(gltf(9000, 1, 60), "a.glb"), messages::kTooManyTrianglesOfNodes);
    // Work without any triangle.
    EXPECT_SAYS(refusal(gltf(3000, 3000, 0), "a.glb"), messages::kTooManyPrimitives, 1000000);
}

TEST(ReadingMemory, CountsWhatGltfPlacesByInstancing) {
    // One node of a few hundred bytes, and as many bodies as it says.
    const auto instances = [](int64_t count, size_t name) {
        return fmt::format(
            R"({{"asset":{{"version":"2.0"}},"nodes":[{{"mesh":0,"name":"{}","extensions":)"
            R"({{"EXT_mesh_gpu_instancing":{{"attributes":{{"TRANSLATION":1}}}}}}}}],)"
            R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"accessors":[)"
            R"({{"componentType":5126,"count":6000,"type":"VEC3"}},)"
            R"({{"componentType":5126,"count":{},"type":"VEC3"}}]}})",
            std::string(name, 'x'), count);
    };
    EXPECT_SAYS(refusal(instances(4'000'000'000, 1), "a.gltf"), messages::kTooManyPrimitives,
                1000000);
    EXPECT_SAYS(refusal(instances(30'000, 1), "a.gltf"), messages::kTooManyTrianglesOfNodes);
    EXPECT_SAYS(refusal(instances(2'000, 1), "a.gltf"), messages::kTooLargeToRead, "*", 4000000);
    std::string few = instances(60'000, 1000);
    few.replace(few.find("6000,"), 5, "3,");
    EXPECT_SAYS(refusal(few, "a.gltf", 150 * kMegabyte), messages::kGltfNamesTakeTooMuch);
}

TEST(ReadingMemory, FindsMembersOfGltfAmongManyAtOnce) {
    std::string json = R"({"asset":{"version":"2.0"})";
    for (int i = 0; i < 250'000; ++i)
        json += fmt::format(R"(,"k{}":0)", i);
    json += R"(,"nodes":[{"children":[1]})";
    for (int i = 1; i < 120'000; ++i)
        json += i + 1 < 120'000 ? fmt::format(R"(,{{"children":[{}]}})", i + 1) : ",{}";
    EXPECT_SAYS(refusal(json + "]}", "a.gltf", 2000 * kMegabyte), messages::kMeshNoFaces);
}

TEST(ReadingMemory, LimitsWhatGltfRepeatsWithANode) {
    // Names are copied with each node.
    std::string json = R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0})";
    for (int i = 0; i < 100'000; ++i)
        json += R"(,{"mesh":0})";
    EXPECT_SAYS(refusal(json + R"(],"meshes":[{"primitives":[],"name":")" +
                            std::string(1'000'000, 'x') + R"("}]})",
                        "a.gltf", 400 * kMegabyte),
                fmt::format(messages::kNameTooLong, 1000000, 1000));
    // 100,000 times a million sparse values that replace the one of an accessor.
    EXPECT_SAYS(
        refusal(
            json +
                R"(],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{"componentType":5126,"count":1,"type":"VEC3","sparse":{"count":1000000,"indices":{"bufferView":0,"componentType":5121},"values":{"bufferView":1}}}],)"
                R"("bufferViews":[{"buffer":0,"byteLength":1000000},{"buffer":0,"byteLength":12000000}],"buffers":[{"byteLength":12000000,"uri":"data:;base64,)" +
                std::string(16'000'000, 'A') + R"("}]})",
            "a.gltf", 400 * kMegabyte),
        fmt::format(messages::kSparseTooMany, 1000000, 1));
}

TEST(ReadingMemory, GoesThroughGroupsOfObjOnce) {
    // Two alternating materials of faces in 4,000 groups; and one with a long name, alternating
    // between two groups.
    std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\ng";
    for (int i = 0; i < 4000; ++i)
        obj += fmt::format(" group_with_a_long_name_{}", i);
    for (int i = 0; i < 200'000; ++i)
        obj += i % 2 == 0 ? "\nusemtl a\nf 1 2 3" : "\nusemtl b\nf 1 2 3";
    obj += "\nusemtl " + std::string(300'000, 'x');
    for (int i = 0; i < 100'000; ++i)
        obj += i % 2 == 0 ? "\ng a\nf 1 2 3" : "\ng b\nf 1 2 3";
    EXPECT_NE(refusal(obj, "a.obj", 400 * kMegabyte), "no error");
}

TEST(ReadingMemory, CountsWhatTextsBecome) {
    std::string obj;
    for (int i = 0; i < 800'000; ++i)
        obj += "v 1 2 3\n";
    EXPECT_SAYS(refusal(obj, "a.obj"), messages::kTooLargeToRead);
    obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (int i = 0; i < 500'000; ++i)
        obj += "f 1 2 3\n";
    EXPECT_SAYS(refusal(obj, "a.obj"), messages::kTooLargeToRead);
    // A long list of groups that many materials have in common.
    obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\ng";
    for (int i = 0; i < 4000; ++i)
        obj += fmt::format(" group_with_a_long_name_{}", i);
    for (int i = 0; i < 20'000; ++i)
        obj += fmt::format("\nusemtl m{}\nf 1 2 3", i);
    EXPECT_SAYS(refusal(obj, "a.obj"), messages::kTooLargeToRead);
    EXPECT_SAYS(refusal(
                    "g" +
                        [] {
                            std::string many;
                            for (int i = 0; i < 1'000'000; ++i)
                                many += " a";
                            return many;
                        }(),
                    "a.obj"),
                fmt::format(messages::kFaceInTooManyGroups, 4096));
    std::string stl = "solid a\n";
    for (int i = 0; i < 200'000; ++i)
        stl +=
            "facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop "
            "endfacet\n";
    EXPECT_SAYS(refusal(stl, "a.stl"), messages::kTooLargeToRead);
    std::string binary(80, ' ');
    append(&binary, uint32_t{400'000});
    binary.resize(84 + 50 * 400'000);
    EXPECT_SAYS(refusal(binary, "a.stl"), messages::kTooLargeToRead, "*", 400000);
}

TEST(ReadingMemory, CountsWhatPropertiesOfPlyBecome) {
    std::string head = "ply\nformat binary_little_endian 1.0\nelement vertex 40000\n";
    for (const char* axis : {"x", "y", "z"})
        head += fmt::format("property float {}\n", axis);
    for (int i = 0; i < 300; ++i)
        head += fmt::format("property uchar p{}\n", i);
    const std::string faces =
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    EXPECT_SAYS(refusal(head + faces + std::string(40'000 * 312 + 13, '\0'), "a.ply"),
                messages::kTooLargeToRead);
    // One list of many values.
    head =
        "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty "
        "float y\nproperty float z\nproperty list int uchar more\n" +
        faces + std::string(12, '\0');
    append(&head, int32_t{10'000'000});
    EXPECT_SAYS(refusal(head + std::string(10'000'000, '\0'), "a.ply"),
                fmt::format(messages::kListTakesTooMuch, "more", 10000000));
    // Each face is three bytes.
    head =
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty "
        "float y\nproperty float z\nelement face 1000000\nproperty list uchar uchar "
        "vertex_indices\nend_header\n" +
        std::string(36, '\0');
    for (int i = 0; i < 1'000'000; ++i)
        head += std::string("\3\0\1\2", 4);
    EXPECT_SAYS(refusal(head, "a.ply"), messages::kTooLargeToRead);
}

TEST(ReadingMemory, EstimatesWhatPreparingTakes) {
    struct Case {
        const char* what;
        bool stl, open, shells;
    };
    for (const Case& c : {Case{"welded", false, false, false}, Case{"soup", true, false, false},
                          Case{"open", true, true, false}, Case{"shells", true, false, true}}) {
        const std::string bytes = ball(220, c.stl, c.open, c.shells);
        MeshOptions options;
        options.name = "part";
        options.repair = c.open;
        const testing::TempFolder folder;
        const auto file = folder.write(c.stl ? "a.stl" : "a.obj", bytes);
        const testing::Meter meter;
        Result<LoadedMesh> loaded = load_mesh(file, options);
        ASSERT_TRUE(loaded) << loaded.error().text();
        const double share =
            static_cast<double>(meter.peak_bytes()) /
            static_cast<double>(loaded->peak_bytes + static_cast<int64_t>(bytes.size()));
        fmt::print("{}: {} triangles, {:.1f} MB, {:.2f} of the estimate\n", c.what,
                   loaded->mesh.triangles.size(), static_cast<double>(meter.peak_bytes()) / 1e6,
                   share);
        EXPECT_LE(share, 1) << c.what;
        EXPECT_GE(share, 0.3) << c.what << ": more is refused than need be";
    }
}

#ifndef OPENFAB_SANITIZED  // is about work: it reads nothing that others do not read
TEST(ReadingMemory, EndsWithManyShellsBehindEachOther) {
    std::string obj;
    for (int i = 0; i < 40'000; ++i)
        obj += fmt::format(
            "v {0} 0 0\nv {1} 0 0\nv {0} 1 0\nv {0} 0 1\nf -4 -2 -3\nf -4 -3 -1\nf -4 -1 -2\nf -3 "
            "-2 -1\n",
            i, i + 0.5);
    EXPECT_SAYS(refusal(obj, "a.obj", 600 * kMegabyte), messages::kTooManyShells);
}
#endif

TEST(ReadingMemory, ShowsALineWithoutKeepingALongerOne) {
    const testing::TempFolder folder;
    const std::string file =
        folder.write("w.json", std::string(20'000'000, 'x') + "\n\nshort\n").string();
    const testing::Meter meter;
    const auto shown = [&](int32_t line) {
        return render_error(error_at({file, line, 1}, "it is wrong")).substr(file.size());
    };
    EXPECT_EQ(shown(1), ":1:1: error: it is wrong\n");
    EXPECT_EQ(shown(2), ":2:1: error: it is wrong\n 2 | \n   | ^\n");
    EXPECT_EQ(shown(3), ":3:1: error: it is wrong\n 3 | short\n   | ^~~~~\n");
    EXPECT_EQ(shown(4), ":4:1: error: it is wrong\n");
    EXPECT_LT(meter.peak_bytes(), kMegabyte);
}

}  // namespace
}  // namespace openfab::mesh

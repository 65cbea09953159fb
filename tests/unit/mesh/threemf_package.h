// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Small 3MF packages for tests.

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "mesh/read/threemf.h"
#include "tests/support/meshes/zip_archive.h"
#include "tests/unit/mesh/features.h"
#include "tests/unit/mesh/mesh_files.h"

namespace openfab::mesh {

using PackageFiles = std::vector<std::pair<std::string, std::string>>;

constexpr const char* kThreemfRelationships =
    R"(<?xml version="1.0"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/Metadata/thumbnail.png" Id="r1" Type="http://schemas.openxmlformats.org/package/2006/relationships/metadata/thumbnail"/>
<Relationship Target="/3D/3dmodel.model" Id="r0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>)";

inline std::string threemf_package(const std::string& model, const PackageFiles& more = {}) {
    PackageFiles files = {{"[Content_Types].xml", "<Types/>"},
                          {"_rels/.rels", kThreemfRelationships},
                          {"3D/3dmodel.model", model}};
    files.insert(files.end(), more.begin(), more.end());
    return testing::zip_archive(files);
}

/// A model with these resources and build items, in millimetres.
inline std::string threemf_model(const std::string& resources, const std::string& build,
                                 const std::string& attributes = "") {
    return R"(<?xml version="1.0" encoding="UTF-8"?>
<model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
 xmlns:m="http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
 xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
 xmlns:s="http://schemas.microsoft.com/3dmanufacturing/slice/2015/07"
 xmlns:bo="http://schemas.3mf.io/3dmanufacturing/booleanoperations/2023/07"
 xmlns:x="http://example.org/extension/2026" )" +
           attributes + "><resources>" + resources + "</resources><build>" + build +
           "</build></model>";
}

/// The mesh of a cube from `low` to `high`; `faces` are the attributes of its triangles, the last
/// one of all others.
inline std::string threemf_cube(double low, double high,
                                const std::vector<std::string>& faces = {}) {
    std::string text = "<mesh><vertices>";
    for (int v = 0; v < 8; ++v) {
        const auto at = [&](int bit) { return (v & bit) != 0 ? high : low; };
        text += fmt::format(R"(<vertex x="{}" y="{}" z="{}"/>)", at(1), at(2), at(4));
    }
    text += "</vertices><triangles>";
    constexpr int kFaces[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6},
                                   {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                   {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    for (size_t f = 0; f < 12; ++f) {
        const std::string more = faces.empty() ? "" : " " + faces[std::min(f, faces.size() - 1)];
        text += fmt::format(R"(<triangle v1="{}" v2="{}" v3="{}"{}/>)", kFaces[f][0], kFaces[f][1],
                            kFaces[f][2], more);
    }
    return text + "</triangles></mesh>";
}

inline MeshSource read_source(const std::string& package) {
    Result<MeshSource> source = parse_threemf(package, "a.3mf");
    EXPECT_TRUE(source) << source.error().text();
    return source ? std::move(*source) : MeshSource{};
}

inline const Body& body_of(const MeshSource& source, size_t triangle) {
    return source.bodies[source.groups[source.face_groups[triangle]].body];
}

/// The values of an attribute at a triangle's corner; empty if it has none.
inline std::vector<float> value_of(const MeshSource& source, const char* name, size_t triangle,
                                   size_t corner) {
    const MeshAttribute* a = source.mesh.find(name);
    const int32_t at = a != nullptr ? a->corners[triangle][corner] : -1;
    if (at < 0) return {};
    const auto first = a->values.begin() + static_cast<ptrdiff_t>(at) * a->components;
    return {first, first + a->components};
}

inline std::string told_line(const std::string& what, const std::string& count_and_place,
                             const std::string& remedy) {
    return what + " (" + count_and_place + "); " + remedy + "\n";
}

/// What is left out, one a line: `WHAT (COUNT, PLACE); REMEDY`.
inline std::string told(const MeshSource& source) {
    std::string text;
    for (const LeftOut& one : source.left_out)
        text += told_line(one.what, fmt::format("{}, {}", one.count, one.place), one.remedy);
    return text;
}

}  // namespace openfab::mesh

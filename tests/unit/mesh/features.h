// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Shared by the tables of what formats can hold: each feature is carried over, or told.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "mesh/model/mesh_source.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/says/says.h"

namespace openfab::mesh {

using Read = Result<MeshSource> (*)(std::string_view bytes, const std::string& file,
                                    int64_t memory_bytes);

/// A mesh with a feature, and files beside it.
struct Feature {
    const char* name;
    std::string mesh;
    std::vector<std::pair<std::string, std::string>> beside;
    /// The message that must be told, and how often; empty: nothing is told.
    std::string told;
    int64_t count = 0;
    /// Whether it was carried over.
    std::function<bool(const MeshSource&)> carried;
};

inline std::string all_told(const MeshSource& source) {
    std::string text;
    for (const LeftOut& left : source.left_out)
        text += fmt::format("{} ({} at {}; {})\n", left.what, left.count, left.place, left.remedy);
    for (const std::string& warning : source.warnings)
        text += warning + "\n";
    return text;
}

inline void check_features(Read read, const std::string& name,
                           const std::vector<Feature>& features) {
    for (const Feature& feature : features) {
        SCOPED_TRACE(feature.name);
        const testing::TempFolder folder;
        for (const auto& [file, text] : feature.beside)
            folder.write(file, text);
        const Result<MeshSource> source =
            read(feature.mesh, (folder.path() / name).string(), kDefaultReadingBytes);
        if (!source) {
            ADD_FAILURE() << source.error().text();
            continue;
        }
        const std::string told = all_told(*source);
        if (feature.told.empty()) {
            EXPECT_EQ(told, "");
        } else {
            EXPECT_THAT(told, testing::Says(feature.told));
        }
        for (const LeftOut& left : source->left_out) {
            EXPECT_FALSE(left.what.empty() || left.place.empty() || left.remedy.empty()) << told;
            if (testing::says(left.what, feature.told) && feature.count > 0) {
                EXPECT_EQ(left.count, feature.count) << told;
            }
        }
        EXPECT_TRUE(!feature.carried || feature.carried(*source)) << told;
    }
}

/// The value of an attribute at a corner; -1 if it has none.
inline double value_at(const MeshSource& source, const char* name, size_t triangle, size_t corner,
                       size_t component) {
    const MeshAttribute* a = source.mesh.find(name);
    if (a == nullptr || a->corners.size() <= triangle || a->corners[triangle][corner] < 0)
        return -1;
    return static_cast<double>(
        a->values[static_cast<size_t>(a->corners[triangle][corner] * a->components) + component]);
}

/// The look of a triangle; a look named `none` if it has none.
inline Look look_of(const MeshSource& source, size_t triangle) {
    Look none;
    none.name = "none";
    if (source.face_groups.size() <= triangle) return none;
    const int32_t look = source.groups[source.face_groups[triangle]].look;
    return look < 0 ? none : source.looks[look];
}

inline std::string bodies_of(const MeshSource& source) {
    std::string text;
    for (const Body& body : source.bodies)
        text += (text.empty() ? "" : ", ") + body.name;
    return text;
}

inline bool near(double a, double b) {
    return a > b - 1e-4 && a < b + 1e-4;
}

}  // namespace openfab::mesh

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Shared by the tests of mesh formats: files made in memory, and damaged copies.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "mesh/check/mesh_check.h"
#include "mesh/load/load_mesh.h"
#include "tests/support/meshes/meshes.h"

namespace openfab::mesh {

inline Result<LoadedMesh> parse_bytes(const std::string& bytes, const std::string& file,
                                      MeshOptions options = {}) {
    if (options.name.empty()) options.name = "part";
    return parse_mesh(bytes, file, options);
}

inline std::string parse_error(const std::string& bytes, const std::string& file) {
    const Result<LoadedMesh> loaded = parse_bytes(bytes, file);
    return loaded ? "no error" : loaded.error().text();
}

template <typename T>
void append(std::string* bytes, T value, bool big_endian = false) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    if (big_endian) std::reverse(raw, raw + sizeof value);
    bytes->append(raw, sizeof value);
}

/// Returns the container of a glTF file and its binary chunk, both padded to 4 bytes.
inline std::string glb(std::string json, std::string binary) {
    while (json.size() % 4 != 0)
        json += ' ';
    binary.resize((binary.size() + 3) / 4 * 4);
    std::string out = "glTF";
    append(&out, uint32_t{2});
    append(&out, static_cast<uint32_t>(28 + json.size() + binary.size()));
    append(&out, static_cast<uint32_t>(json.size()));
    out += "JSON" + json;
    append(&out, static_cast<uint32_t>(binary.size()));
    return out + std::string("BIN\0", 4) + binary;
}

/// Loads `count` damaged forms of a file: bytes changed, set to extremes, removed, duplicated, or
/// truncated. Any result but a crash is accepted; a mesh must be valid.
inline void survive_damage(const std::string& bytes, const std::string& file, int count) {
    std::mt19937 random(7);
    size_t meshes = 0;
    for (int i = 0; i < count; ++i) {
        std::string damaged = bytes;
        const auto offset = [&] { return random() % damaged.size(); };
        for (unsigned k = 0; k < 1 + random() % 4; ++k) {
            switch (random() % 5) {
                case 0:
                    damaged[offset()] = static_cast<char>(random());
                    break;
                case 1:
                    damaged[offset()] = "\x00\xff\x7f\x80-9"[random() % 6];
                    break;
                case 2:
                    damaged.erase(offset(), 1 + random() % 8);
                    break;
                case 3:
                    damaged.insert(offset(), damaged.substr(offset(), random() % 40));
                    break;
                default:
                    if (random() % 4 == 0) damaged.resize(offset());
            }
            if (damaged.empty()) damaged = "x";
        }
        const Result<LoadedMesh> loaded = parse_bytes(damaged, file);
        if (!loaded) {
            EXPECT_FALSE(loaded.error().text().empty());
            continue;
        }
        ++meshes;
        EXPECT_TRUE(count_edges(loaded->mesh).fine());
        for (const MeshAttribute& a : loaded->mesh.attributes) {
            const size_t triangles = loaded->mesh.triangles.size();
            if (a.is_int) {
                EXPECT_EQ(a.faces.size(), triangles * static_cast<size_t>(a.components));
                continue;
            }
            ASSERT_EQ(a.corners.size(), triangles);
            for (const auto& corners : a.corners) {
                for (int32_t c : corners)
                    ASSERT_LT(static_cast<size_t>(c) * static_cast<size_t>(a.components),
                              a.values.size());
            }
        }
    }
    // If nothing survived, only the first check would be tested.
    EXPECT_GT(meshes, 0u) << file;
}

}  // namespace openfab::mesh

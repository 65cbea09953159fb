// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What tests of files with fields share: a field that is linear in space, a block of cells, and what
// comes of a file.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <filesystem>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "base/vec.h"
#include "tests/support/meshes/temp_folder.h"
#include "texture/volume.h"
#include "tools/texture/convert_volume.h"
#include "tools/texture/messages.h"

namespace openfab::tools {

using texture::Pyramid;
using texture::VolumeOptions;

inline double linear(const Vec3d& p) {
    return 3 + 0.5 * p.x - 2 * p.y + 0.25 * p.z;
}

struct BlockMesh {
    std::vector<double> points;
    std::vector<int64_t> corners, ends;
    std::vector<uint8_t> types;

    void add(uint8_t type, const std::vector<int64_t>& cell) {
        corners.insert(corners.end(), cell.begin(), cell.end());
        ends.push_back(static_cast<int64_t>(corners.size()));
        types.push_back(type);
    }
    Vec3d point(size_t i) const { return {points[3 * i], points[3 * i + 1], points[3 * i + 2]}; }
    size_t point_count() const { return points.size() / 3; }
};

/// A block of 3 x 3 x 3 cubes of 1 mm from (-1, 0, 2) on, its inner points moved about, each cube as
/// cells of one type.
inline BlockMesh block(int type) {
    BlockMesh mesh;
    std::mt19937 random(7);
    std::uniform_real_distribution<double> moved(-0.2, 0.2);
    const auto index = [](int x, int y, int z) { return int64_t{z} * 16 + y * 4 + x; };
    for (int z = 0; z < 4; ++z) {
        for (int y = 0; y < 4; ++y) {
            for (int x = 0; x < 4; ++x) {
                const auto at = [&](int i) {
                    return i + (i > 0 && i < 3 && type != 11 ? moved(random) : 0.0);
                };
                mesh.points.insert(mesh.points.end(), {at(x) - 1, at(y), at(z) + 2});
            }
        }
    }
    for (int z = 0; z < 3; ++z) {
        for (int y = 0; y < 3; ++y) {
            for (int x = 0; x < 3; ++x) {
                std::array<int64_t, 8> c{};
                for (int k = 0; k < 8; ++k)
                    c[static_cast<size_t>(k)] = index(x + (k & 1), y + (k >> 1 & 1), z + (k >> 2));
                if (type == 10) {  // six tetrahedra about the diagonal from 0 to 7
                    for (const auto& [a, b] : std::vector<std::pair<size_t, size_t>>{
                             {1, 3}, {3, 2}, {2, 6}, {6, 4}, {4, 5}, {5, 1}})
                        mesh.add(10, {c[0], c[a], c[b], c[7]});
                } else if (type == 11) {
                    mesh.add(11, {c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7]});
                } else if (type == 12) {
                    mesh.add(12, {c[0], c[1], c[3], c[2], c[4], c[5], c[7], c[6]});
                } else {
                    mesh.add(13, {c[0], c[1], c[3], c[4], c[5], c[7]});
                    mesh.add(13, {c[0], c[3], c[2], c[4], c[7], c[6]});
                }
            }
        }
    }
    return mesh;
}

/// Converts files in a folder of its own.
class FieldTest : public ::testing::Test {
  protected:
    std::shared_ptr<const Pyramid> converted(const std::filesystem::path& file,
                                             const VolumeOptions& options = {}) {
        const std::filesystem::path out = folder_.path() / "out.oftx";
        const Result<void> made = make_volume_file(file, out, options);
        EXPECT_TRUE(made) << made.error().text();
        if (!made) return nullptr;
        const auto opened = Pyramid::open(out, 0, 0);
        EXPECT_TRUE(opened) << opened.error().text();
        return opened ? *opened : nullptr;
    }
    std::string trouble(const std::filesystem::path& file, const VolumeOptions& options = {},
                        const texture::ReadLimits& limits = {}) {
        const Result<void> made =
            make_volume_file(file, folder_.path() / "out.oftx", options, limits);
        if (made) return "no error";
        const std::string start = fmt::format(messages::kCannotReadBefore, file.string());
        EXPECT_TRUE(made.error().text().starts_with(start)) << made.error().text();
        return made.error().text().substr(start.size());
    }
    static Vec3i size(const Pyramid& p) { return {p.info()[15], p.info()[16], p.info()[17]}; }
    static Vec3d origin(const Pyramid& p) {
        const auto at = [&](size_t k) { return double(std::bit_cast<float>(p.info()[8 + k])); };
        return {at(0), at(1), at(2)};
    }
    static Vec3d extent(const Pyramid& p) {
        const auto at = [&](size_t k) { return double(std::bit_cast<float>(p.info()[11 + k])); };
        return {at(0), at(1), at(2)};
    }
    static Vec3d pitch(const Pyramid& p) {
        const Vec3d whole = extent(p);
        return {whole.x / size(p).x, whole.y / size(p).y, whole.z / size(p).z};
    }
    static std::vector<float> level0(const Pyramid& p) {
        const Vec3i n = size(p);
        return {p.texels().begin(), p.texels().begin() + int64_t{n.x} * n.y * n.z * p.channels()};
    }
    /// Origin, then extent.
    static std::vector<float> domain(const Pyramid& p) {
        std::vector<float> out;
        for (size_t k = 8; k < 14; ++k)
            out.push_back(std::bit_cast<float>(p.info()[k]));
        return out;
    }
    /// Calls use(centre, values) for each texel.
    static void each(const Pyramid& p, const std::function<void(const Vec3d&, const float*)>& use) {
        const Vec3i n = size(p);
        const Vec3d from = origin(p), step = pitch(p);
        const float* at = p.texels().data();
        for (int z = 0; z < n.z; ++z) {
            for (int y = 0; y < n.y; ++y) {
                for (int x = 0; x < n.x; ++x, at += p.channels())
                    use({from.x + (x + 0.5) * step.x, from.y + (y + 0.5) * step.y,
                         from.z + (z + 0.5) * step.z},
                        at);
            }
        }
    }

    testing::TempFolder folder_;
};

}  // namespace openfab::tools

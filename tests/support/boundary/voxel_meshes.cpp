// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/boundary/voxel_meshes.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

namespace openfab::testing {

namespace {

using Triangle = std::array<Vec3i, 3>;

int64_t cross2(int64_t ax, int64_t ay, int64_t bx, int64_t by) {
    return ax * by - ay * bx;
}

Vec3<int64_t> doubled_area(const Triangle& t) {
    const auto a = vec_cast<int64_t>(t[1] - t[0]), b = vec_cast<int64_t>(t[2] - t[0]);
    return cross(a, b);
}

Triangle corners(const CollectedMesh& mesh, const std::array<uint32_t, 3>& triangle) {
    return {mesh.points[triangle[0]], mesh.points[triangle[1]], mesh.points[triangle[2]]};
}

std::string text(const Vec3i& p) {
    return fmt::format("({}, {}, {})", p.x, p.y, p.z);
}

/// From its lowest corner on, so that the same triangle is the same key.
std::array<std::array<int32_t, 3>, 3> key_of(const Triangle& t) {
    std::array<std::array<int32_t, 3>, 3> key{};
    for (size_t i = 0; i < 3; ++i)
        key[i] = {t[i].x, t[i].y, t[i].z};
    std::rotate(key.begin(), std::min_element(key.begin(), key.end()), key.end());
    return key;
}

/// Places on each unit face where triangles are counted; off all lines between half voxels.
constexpr std::array<std::array<int64_t, 2>, 3> kSamples{
    {{401'113, 1'201'741}, {1'490'003, 700'867}, {1'000'213, 1'900'081}}};
constexpr int64_t kScale = 1'048'576;  // of half a voxel

/// How often each sample of each face is covered, by triangles that face up and down its axis.
class Coverage {
  public:
    explicit Coverage(Vec3i size) : size_(size) {
        counts_.resize(3 * kSamples.size() * static_cast<size_t>(size.x + 1) *
                       static_cast<size_t>(size.y + 1) * static_cast<size_t>(size.z + 1));
    }

    std::string add(const Triangle& t) {
        const Vec3<int64_t> area = doubled_area(t);
        int axis = 0;
        while (axis < 3 && area[axis] == 0)
            ++axis;
        if (axis == 3) return "a triangle has no area";
        if (area[(axis + 1) % 3] != 0 || area[(axis + 2) % 3] != 0 || t[0][axis] % 2 != 0)
            return fmt::format("a triangle at {} lies in no plane of faces", text(t[0]));
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        const auto range = [&](int a) {
            const auto [lo, hi] = std::minmax({t[0][a], t[1][a], t[2][a]});
            return std::pair(lo / 2, (hi + 1) / 2);
        };
        const auto [u0, u1] = range(u);
        const auto [v0, v1] = range(v);
        for (int32_t cu = u0; cu < u1; ++cu) {
            for (int32_t cv = v0; cv < v1; ++cv) {
                Vec3i face;
                face[axis] = t[0][axis] / 2;
                face[u] = cu;
                face[v] = cv;
                for (size_t s = 0; s < kSamples.size(); ++s) {
                    const int64_t pu = 2 * cu * kScale + kSamples[s][0];
                    const int64_t pv = 2 * cv * kScale + kSamples[s][1];
                    if (inside(t, u, v, pu, pv, area[axis] > 0))
                        ++counts_[index(face, axis, s)][area[axis] > 0 ? 0 : 1];
                }
            }
        }
        return {};
    }

    std::array<int32_t, 2> count(const Vec3i& face, int axis, size_t sample) const {
        return counts_[index(face, axis, sample)];
    }

  private:
    static bool inside(const Triangle& t, int u, int v, int64_t pu, int64_t pv, bool positive) {
        for (size_t i = 0; i < 3; ++i) {
            const Vec3i &a = t[i], &b = t[(i + 1) % 3];
            const int64_t side =
                cross2(b[u] - a[u], b[v] - a[v], pu - a[u] * kScale, pv - a[v] * kScale);
            if (positive ? side <= 0 : side >= 0) return false;
        }
        return true;
    }

    size_t index(const Vec3i& f, int axis, size_t sample) const {
        const auto point = (static_cast<size_t>(f.z) * static_cast<size_t>(size_.y + 1) +
                            static_cast<size_t>(f.y)) *
                               static_cast<size_t>(size_.x + 1) +
                           static_cast<size_t>(f.x);
        return (point * 3 + static_cast<size_t>(axis)) * kSamples.size() + sample;
    }

    Vec3i size_;
    std::vector<std::array<int32_t, 2>> counts_;
};

/// Calls visit(face, axis, low, high) for each place between two voxels or at the block's border.
template <typename Visit>
void for_each_face(const VoxelBlock& block, Visit visit) {
    for (int axis = 0; axis < 3; ++axis) {
        Vec3i end = block.size;
        ++end[axis];
        for (int32_t z = 0; z < end.z; ++z) {
            for (int32_t y = 0; y < end.y; ++y) {
                for (int32_t x = 0; x < end.x; ++x) {
                    Vec3i low{x, y, z};
                    --low[axis];
                    visit(Vec3i{x, y, z}, axis, block.code(low), block.code({x, y, z}));
                }
            }
        }
    }
}

std::string check_faces(const VoxelBlock& block, uint8_t code, const CollectedMesh& mesh) {
    Coverage coverage(block.size);
    for (const auto& triangle : mesh.triangles) {
        if (std::string wrong = coverage.add(corners(mesh, triangle)); !wrong.empty()) return wrong;
    }
    std::string wrong;
    for_each_face(block, [&](const Vec3i& face, int axis, uint8_t low, uint8_t high) {
        const std::array<int32_t, 2> expected{low == code && high != code ? 1 : 0,
                                              high == code && low != code ? 1 : 0};
        for (size_t s = 0; s < kSamples.size() && wrong.empty(); ++s) {
            const std::array<int32_t, 2> found = coverage.count(face, axis, s);
            if (found == expected) continue;
            wrong = fmt::format("face {} across axis {} is covered {} and {} times, not {} and {}",
                                text(face), axis, found[0], found[1], expected[0], expected[1]);
        }
    });
    return wrong;
}

/// Triangles that are not in another mesh too, turned, must be those towards the void.
std::string check_interfaces(const VoxelBlock& block, const CollectedMeshes& meshes) {
    using Key = std::array<std::array<int32_t, 3>, 3>;
    std::map<Key, int> all;
    for (const auto& [code, mesh] : meshes) {
        for (const auto& triangle : mesh.triangles) {
            if (++all[key_of(corners(mesh, triangle))] > 1) return "a triangle is there twice";
        }
    }
    int64_t single = 0, outer = 0;
    for (const auto& [key, count] : all) {
        const Key turned{key[0], key[2], key[1]};
        if (all.count(turned) != 0) continue;
        Triangle t;
        for (size_t i = 0; i < 3; ++i)
            t[i] = {key[i][0], key[i][1], key[i][2]};
        const Vec3<int64_t> area = doubled_area(t);
        single += std::abs(area.x) + std::abs(area.y) + std::abs(area.z);
    }
    for_each_face(block, [&](const Vec3i&, int, uint8_t low, uint8_t high) {
        if ((low == 0) != (high == 0)) outer += 8;
    });
    if (single == outer) return {};
    return fmt::format("an area of {} eighths is not shared by two meshes, of {} towards the void",
                       single, outer);
}

}  // namespace

uint8_t VoxelBlock::code(Vec3i v) const {
    for (int a = 0; a < 3; ++a) {
        if (v[a] < 0 || v[a] >= size[a]) return 0;
    }
    return const_cast<VoxelBlock*>(this)->at(v);
}

int64_t VoxelBlock::count(uint8_t code) const {
    return std::count(codes.begin(), codes.end(), code);
}

Result<void> Collector::take_vertices(uint8_t code, std::span<const Vec3i> points) {
    CollectedMesh& mesh = meshes[code];
    mesh.points.insert(mesh.points.end(), points.begin(), points.end());
    return {};
}

Result<void> Collector::take_triangles(uint8_t code,
                                       std::span<const boundary::MeshTriangle> triangles) {
    CollectedMesh& mesh = meshes[code];
    for (const boundary::MeshTriangle& t : triangles) {
        mesh.triangles.push_back({t[0].vertex, t[1].vertex, t[2].vertex});
        taken_[code].push_back(t);
    }
    return {};
}

void Collector::check_corners() {
    for (const auto& [code, triangles] : taken_) {
        const std::vector<Vec3i>& points = meshes[code].points;
        for (const boundary::MeshTriangle& t : triangles) {
            for (const boundary::MeshCorner& c : t)
                corners_fit =
                    corners_fit && c.vertex < points.size() && points[c.vertex] == c.point;
        }
    }
}

CollectedMeshes mesh_block(const VoxelBlock& block) {
    Collector collector;
    boundary::Mesher mesher(block.size.x, block.size.y, 0, &collector);
    const auto row = static_cast<size_t>(block.size.x);
    for (int32_t z = 0; z < block.size.z; ++z) {
        const backends::SliceView slice{
            z,
            block.codes.data() + static_cast<size_t>(z) * row * static_cast<size_t>(block.size.y),
            row, block.size.x, block.size.y};
        if (!mesher.add(slice, 8)) return {};
    }
    if (!mesher.finish()) return {};
    collector.check_corners();
    return collector.corners_fit ? collector.meshes : CollectedMeshes();
}

std::string check_manifold(const CollectedMesh& mesh) {
    std::map<std::pair<uint32_t, uint32_t>, int> edges;
    std::vector<std::vector<std::pair<uint32_t, uint32_t>>> around(mesh.points.size());
    for (const auto& t : mesh.triangles) {
        for (size_t i = 0; i < 3; ++i) {
            if (t[i] >= mesh.points.size()) return "a triangle asks for a vertex that is not there";
            const uint32_t a = t[i], b = t[(i + 1) % 3], c = t[(i + 2) % 3];
            if (++edges[{a, b}] > 1) {
                return fmt::format("the edge from {} to {} is passed twice", text(mesh.points[a]),
                                   text(mesh.points[b]));
            }
            around[a].push_back({b, c});
        }
        if (doubled_area(corners(mesh, t)) == Vec3<int64_t>{}) return "a triangle has no area";
    }
    for (const auto& [edge, count] : edges) {
        if (edges.count({edge.second, edge.first}) == 0) {
            return fmt::format("the edge from {} to {} is open", text(mesh.points[edge.first]),
                               text(mesh.points[edge.second]));
        }
    }
    for (size_t v = 0; v < around.size(); ++v) {
        const std::map<uint32_t, uint32_t> next(around[v].begin(), around[v].end());
        if (next.empty()) return fmt::format("no triangle has vertex {}", v);
        size_t steps = 0;
        uint32_t at = next.begin()->first;
        do {
            at = next.at(at);
            ++steps;
        } while (at != next.begin()->first);
        if (steps != around[v].size())
            return fmt::format("several fans share the vertex at {}", text(mesh.points[v]));
    }
    return {};
}

int64_t six_volumes(const CollectedMesh& mesh) {
    int64_t sum = 0;
    for (const auto& triangle : mesh.triangles) {
        const Triangle t = corners(mesh, triangle);
        sum +=
            dot(vec_cast<int64_t>(t[0]), cross(vec_cast<int64_t>(t[1]), vec_cast<int64_t>(t[2])));
    }
    return sum;
}

std::string check_meshes(const VoxelBlock& block, const CollectedMeshes& meshes) {
    std::set<uint8_t> codes(block.codes.begin(), block.codes.end());
    codes.erase(0);
    if (codes.size() != meshes.size())
        return fmt::format("{} meshes of {} materials", meshes.size(), codes.size());
    for (const auto& [code, mesh] : meshes) {
        std::string wrong = check_manifold(mesh);
        if (wrong.empty() && six_volumes(mesh) != 48 * block.count(code)) {
            wrong =
                fmt::format("a volume of {}/48 voxels of {}", six_volumes(mesh), block.count(code));
        }
        if (wrong.empty()) wrong = check_faces(block, code, mesh);
        if (!wrong.empty()) return fmt::format("material {}: {}", code, wrong);
    }
    return check_interfaces(block, meshes);
}

}  // namespace openfab::testing

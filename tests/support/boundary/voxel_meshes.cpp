// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/boundary/voxel_meshes.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "tests/support/boundary/mesh_triangles.h"

namespace openfab::testing {

namespace {

/// Rotated to its lowest corner, so that equal triangles have equal keys.
std::array<std::array<int32_t, 3>, 3> key_of(const Triangle& t) {
    std::array<std::array<int32_t, 3>, 3> key{};
    for (size_t i = 0; i < 3; ++i)
        key[i] = {t[i].x, t[i].y, t[i].z};
    std::rotate(key.begin(), std::min_element(key.begin(), key.end()), key.end());
    return key;
}

/// Sample points on each unit face where triangles are counted; off all lines between half voxels.
constexpr std::array<std::array<int64_t, 2>, 3> kSamples{
    {{401'113, 1'201'741}, {1'490'003, 700'867}, {1'000'213, 1'900'081}}};
constexpr int64_t kScale = 1'048'576;  // of half a voxel

/// How often each sample of each face is covered, by triangles that face up and down its axis.
/// Coordinates have `unit` to a voxel.
class Coverage {
  public:
    Coverage(Vec3i size, int32_t unit) : size_(size), unit_(unit) {
        counts_.resize(3 * kSamples.size() * static_cast<size_t>(size.x + 1) *
                       static_cast<size_t>(size.y + 1) * static_cast<size_t>(size.z + 1));
    }

    std::string add(const Triangle& t) {
        const Vec3<int64_t> area = doubled_area(t);
        int axis = 0;
        for (int a = 1; a < 3; ++a)
            axis = std::abs(area[a]) > std::abs(area[axis]) ? a : axis;
        if (area[axis] == 0) return "a triangle has no area";
        const int32_t plane = (t[0][axis] + unit_ / 2) / unit_;
        for (const Vec3i& p : t) {
            // In half voxels vertices are on the plane; in steps they may be off by one.
            if (std::abs(p[axis] - plane * unit_) > (unit_ == 2 ? 0 : 1))
                return fmt::format("a triangle at {} lies in no plane of faces", text(t[0]));
        }
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        const auto range = [&](int a) {
            const auto [lo, hi] = std::minmax({t[0][a], t[1][a], t[2][a]});
            return std::pair(lo / unit_, (hi + unit_ - 1) / unit_);
        };
        const auto [u0, u1] = range(u);
        const auto [v0, v1] = range(v);
        for (int32_t cu = u0; cu < u1; ++cu) {
            for (int32_t cv = v0; cv < v1; ++cv) {
                Vec3i face;
                face[axis] = plane;
                face[u] = cu;
                face[v] = cv;
                for (size_t s = 0; s < kSamples.size(); ++s) {
                    const int64_t pu = cu * unit_ * kScale + kSamples[s][0] * (unit_ / 2);
                    const int64_t pv = cv * unit_ * kScale + kSamples[s][1] * (unit_ / 2);
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
    int32_t unit_;
    std::vector<std::array<int32_t, 2>> counts_;
};

/// Calls visit(face, axis, low, high) for each face between two voxels or at the block's border.
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

std::string check_faces(const VoxelBlock& block, uint8_t code, const CollectedMesh& mesh,
                        int32_t unit) {
    Coverage coverage(block.size, unit);
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

/// Receives meshes by position.
class PlaceCollector : public boundary::MeshReceiver {
  public:
    CollectedMeshes meshes;

    bool identifies_by_position() const override { return true; }
    Result<void> take_vertices(uint8_t, std::span<const Vec3i>) override { return {}; }
    Result<void> take_triangles(uint8_t code,
                                std::span<const boundary::MeshTriangle> triangles) override {
        CollectedMesh& mesh = meshes[code];
        for (const boundary::MeshTriangle& t : triangles) {
            std::array<uint32_t, 3>& out = mesh.triangles.emplace_back();
            for (size_t i = 0; i < 3; ++i) {
                Vec3i p = t[i].point * (boundary::kSteps / 2);
                for (int a = 0; a < 3; ++a)
                    p[a] += t[i].off[a];
                const auto number = static_cast<uint32_t>(mesh.points.size());
                const auto [at, fresh] = numbers_[code].try_emplace({p.x, p.y, p.z}, number);
                if (fresh) mesh.points.push_back(p);
                out[i] = at->second;
            }
        }
        return {};
    }

  private:
    std::map<uint8_t, std::map<std::array<int32_t, 3>, uint32_t>> numbers_;
};

class TogetherCollector : public boundary::MeshReceiver {
  public:
    PaintedMesh painted;
    std::vector<boundary::MeshTriangle> taken;

    bool numbers_together() const override { return true; }
    Result<void> take_vertices(uint8_t code, std::span<const Vec3i> points) override {
        if (code != 0) return internal_error("a vertex of one material");
        std::vector<Vec3i>* all = &painted.mesh.points;
        all->insert(all->end(), points.begin(), points.end());
        return {};
    }
    Result<void> take_triangles(uint8_t code,
                                std::span<const boundary::MeshTriangle> triangles) override {
        for (const boundary::MeshTriangle& t : triangles)
            painted.mesh.triangles.push_back({t[0].vertex, t[1].vertex, t[2].vertex});
        painted.codes.resize(painted.mesh.triangles.size(), code);
        taken.insert(taken.end(), triangles.begin(), triangles.end());
        return {};
    }
};

Result<void> send(const VoxelBlock& block, boundary::MeshReceiver* receiver) {
    boundary::Mesher mesher(block.size.x, block.size.y, 0, receiver);
    const auto row = static_cast<size_t>(block.size.x);
    for (int32_t z = 0; z < block.size.z; ++z) {
        const pipeline::SliceView slice{
            z,
            block.codes.data() + static_cast<size_t>(z) * row * static_cast<size_t>(block.size.y),
            row, block.size.x, block.size.y};
        if (Result<void> added = mesher.add(slice, 8); !added) return added;
    }
    return mesher.finish();
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
    if (!send(block, &collector)) return {};
    collector.check_corners();
    return collector.corners_fit ? collector.meshes : CollectedMeshes();
}

CollectedMeshes mesh_block_by_position(const VoxelBlock& block) {
    PlaceCollector collector;
    return send(block, &collector) ? collector.meshes : CollectedMeshes();
}

PaintedMesh mesh_block_together(const VoxelBlock& block) {
    TogetherCollector collector;
    if (!send(block, &collector)) return {};
    for (const boundary::MeshTriangle& t : collector.taken) {
        for (const boundary::MeshCorner& c : t) {
            const std::vector<Vec3i>& points = collector.painted.mesh.points;
            if (c.vertex >= points.size() || points[c.vertex] != c.point) return {};
        }
    }
    return collector.painted;
}

std::string check_painted(const VoxelBlock& block, const PaintedMesh& painted) {
    const CollectedMesh& mesh = painted.mesh;
    if (std::string wrong = check_manifold(mesh); !wrong.empty()) return wrong;
    const auto voxels = static_cast<int64_t>(block.codes.size()) - block.count(0);
    if (six_volumes(mesh) != 48 * voxels)
        return fmt::format("a volume of {}/48 voxels of {}", six_volumes(mesh), voxels);
    std::map<uint8_t, CollectedMesh> parts;
    for (const uint8_t code : block.codes) {
        if (code != 0) parts[code].points = mesh.points;
    }
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto part = parts.find(painted.codes[t]);
        if (part == parts.end()) return "a triangle has a material that is not there";
        part->second.triangles.push_back(mesh.triangles[t]);
    }
    for (const auto& [code, part] : parts) {
        std::string wrong = check_faces(block, code, part, 2);
        if (!wrong.empty()) return fmt::format("material {}: {}", code, wrong);
    }
    return {};
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
        if (wrong.empty()) wrong = check_faces(block, code, mesh, 2);
        if (!wrong.empty()) return fmt::format("material {}: {}", code, wrong);
    }
    return check_interfaces(block, meshes);
}

std::string check_meshes_by_position(const VoxelBlock& block, const CollectedMeshes& meshes,
                                     Crossings crossings) {
    constexpr int64_t kUnit = boundary::kSteps;
    std::set<uint8_t> codes(block.codes.begin(), block.codes.end());
    codes.erase(0);
    if (codes.size() != meshes.size())
        return fmt::format("{} meshes of {} materials", meshes.size(), codes.size());
    for (const auto& [code, mesh] : meshes) {
        int64_t faces = 0;
        for_each_face(block, [&, code = code](const Vec3i&, int, uint8_t low, uint8_t high) {
            faces += (low == code) != (high == code) ? 1 : 0;
        });
        std::string wrong = check_manifold(mesh);
        const int64_t lost = 6 * kUnit * kUnit * kUnit * block.count(code) - six_volumes(mesh);
        if (wrong.empty() && std::abs(lost) > 6 * kUnit * kUnit * faces)
            wrong = fmt::format("it lacks {} of {} voxels",
                                static_cast<double>(lost) / (6.0 * kUnit * kUnit * kUnit),
                                block.count(code));
        if (wrong.empty()) wrong = check_faces(block, code, mesh, boundary::kSteps);
        const bool look = crossings == Crossings::kLookedFor;
        if (wrong.empty() && look) wrong = check_crossings(mesh);
        for (const auto& [other, behind] : meshes) {
            if (!wrong.empty() || other == code || !look) continue;
            wrong = check_crossings(mesh, behind);
        }
        if (!wrong.empty()) return fmt::format("material {}: {}", code, wrong);
    }
    return {};
}

}  // namespace openfab::testing

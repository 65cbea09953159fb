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
                        int32_t unit, boundary::Faces faces = boundary::Faces::kOfEachMaterial) {
    Coverage coverage(block.size, unit);
    for (const auto& triangle : mesh.triangles) {
        if (std::string wrong = coverage.add(corners(mesh, triangle)); !wrong.empty()) return wrong;
    }
    std::string wrong;
    for_each_face(block, [&](const Vec3i& face, int axis, uint8_t low, uint8_t high) {
        const auto bounds = [&](uint8_t other) {
            return faces == boundary::Faces::kOfTheSolid ? other == 0 : other != code;
        };
        const std::array<int32_t, 2> expected{low == code && bounds(high) ? 1 : 0,
                                              high == code && bounds(low) ? 1 : 0};
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

class SolidCollector : public boundary::MeshReceiver {
  public:
    PaintedMesh painted;
    std::vector<boundary::MeshTriangle> taken;

    boundary::Faces faces() const override { return boundary::Faces::kOfTheSolid; }
    Result<void> take_vertices(uint8_t code, std::span<const Vec3i> points) override {
        if (code != 1) return internal_error("a vertex of another mesh");
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

/// Six times the volume of the tetrahedron, above 0 where d sees a, b, c clockwise.
int64_t side_of(const Vec3i& a, const Vec3i& b, const Vec3i& c, const Vec3i& d) {
    const auto v = [&](const Vec3i& p) { return vec_cast<int64_t>(p - a); };
    return dot(cross(v(b), v(c)), v(d));
}

int sign(int64_t x) {
    return x > 0 ? 1 : x < 0 ? -1 : 0;
}

/// Returns the two axes of the projection with the largest area.
std::array<int, 2> axes_of(const Triangle& t) {
    const Vec3<int64_t> area = doubled_area(t);
    int axis = 0;
    for (int a = 1; a < 3; ++a)
        axis = std::abs(area[a]) > std::abs(area[axis]) ? a : axis;
    return {(axis + 1) % 3, (axis + 2) % 3};
}

/// Returns whether a triangle and a segment, which share no vertex, meet.
bool meets(const Triangle& t, const Vec3i& p, const Vec3i& q) {
    const int sp = sign(side_of(t[0], t[1], t[2], p)), sq = sign(side_of(t[0], t[1], t[2], q));
    if (sp * sq > 0) return false;
    if (sp != 0 || sq != 0) {
        const int s0 = sign(side_of(p, q, t[0], t[1])), s1 = sign(side_of(p, q, t[1], t[2])),
                  s2 = sign(side_of(p, q, t[2], t[0]));
        return (s0 >= 0 && s1 >= 0 && s2 >= 0) || (s0 <= 0 && s1 <= 0 && s2 <= 0);
    }
    const auto [u, v] = axes_of(t);
    const auto turn = [u = u, v = v](const Vec3i& a, const Vec3i& b, const Vec3i& c) {
        return sign(cross2(b[u] - a[u], b[v] - a[v], c[u] - a[u], c[v] - a[v]));
    };
    // Coplanar: they meet unless a side of the triangle, or the segment, separates them.
    for (size_t i = 0; i < 3; ++i) {
        const Vec3i &a = t[i], &b = t[(i + 1) % 3], &c = t[(i + 2) % 3];
        const int inner = turn(a, b, c);
        if (turn(a, b, p) * inner < 0 && turn(a, b, q) * inner < 0) return false;
    }
    const int s0 = turn(p, q, t[0]), s1 = turn(p, q, t[1]), s2 = turn(p, q, t[2]);
    return !((s0 > 0 && s1 > 0 && s2 > 0) || (s0 < 0 && s1 < 0 && s2 < 0));
}

/// Returns whether a segment from a triangle's first vertex runs in its plane and between its other
/// two.
bool runs_inside(const Triangle& t, const Vec3i& q) {
    if (side_of(t[0], t[1], t[2], q) != 0) return false;
    const auto [u, v] = axes_of(t);
    const auto turn = [&, u = u, v = v](const Vec3i& b, const Vec3i& c) {
        return sign(cross2(b[u] - t[0][u], b[v] - t[0][v], c[u] - t[0][u], c[v] - t[0][v]));
    };
    const int inner = turn(t[1], t[2]);
    return turn(t[1], q) * inner >= 0 && turn(q, t[2]) * inner >= 0;
}

/// Returns whether a side of one triangle goes through another, not only up to it.
bool goes_through(const Triangle& from, const Triangle& t) {
    for (size_t i = 0; i < 3; ++i) {
        const Vec3i &p = from[i], &q = from[(i + 1) % 3];
        const int sp = sign(side_of(t[0], t[1], t[2], p)), sq = sign(side_of(t[0], t[1], t[2], q));
        if (sp * sq >= 0) continue;
        const int s0 = sign(side_of(p, q, t[0], t[1])), s1 = sign(side_of(p, q, t[1], t[2])),
                  s2 = sign(side_of(p, q, t[2], t[0]));
        if (s0 != 0 && s0 == s1 && s1 == s2) return true;
    }
    return false;
}

bool boxes_meet(const Triangle& a, const Triangle& b) {
    for (int axis = 0; axis < 3; ++axis) {
        const auto [alo, ahi] = std::minmax({a[0][axis], a[1][axis], a[2][axis]});
        const auto [blo, bhi] = std::minmax({b[0][axis], b[1][axis], b[2][axis]});
        if (ahi < blo || bhi < alo) return false;
    }
    return true;
}

/// Returns whether a side of the triangle `from` meets the triangle `with` where it must not.
bool pierces(const CollectedMesh& mesh, const std::array<uint32_t, 3>& from,
             const std::array<uint32_t, 3>& with) {
    for (size_t i = 0; i < 3; ++i) {
        uint32_t p = from[i], q = from[(i + 1) % 3];
        const auto position_of = [&](uint32_t v) { return std::find(with.begin(), with.end(), v); };
        if (position_of(p) == with.end()) std::swap(p, q);
        const auto shared = position_of(p);
        if (shared == with.end()) {
            if (meets(corners(mesh, with), mesh.points[p], mesh.points[q])) return true;
        } else if (position_of(q) == with.end()) {
            std::array<uint32_t, 3> turned = with;
            std::rotate(turned.begin(), turned.begin() + (shared - with.begin()), turned.end());
            if (runs_inside(corners(mesh, turned), mesh.points[q])) return true;
        }
    }
    return false;
}

/// Returns the first pair of triangles of two meshes whose boxes meet and that are `wrong`.
template <typename Wrong>
std::string check_pairs(const CollectedMesh& one, const CollectedMesh& two, const Wrong& wrong) {
    Box3i box;
    for (const Vec3i& p : one.points)
        box.add(p);
    const Vec3i size = box.hi - box.lo;
    const int along = size.x >= std::max(size.y, size.z) ? 0 : size.y >= size.z ? 1 : 2;
    const auto low = [&](const CollectedMesh& mesh, const std::array<uint32_t, 3>& t) {
        const Triangle c = corners(mesh, t);
        return std::min({c[0][along], c[1][along], c[2][along]});
    };
    std::vector<std::array<uint32_t, 3>> sorted = two.triangles;
    std::sort(sorted.begin(), sorted.end(),
              [&](const auto& a, const auto& b) { return low(two, a) < low(two, b); });
    for (const std::array<uint32_t, 3>& t : one.triangles) {
        const Triangle a = corners(one, t);
        const int32_t high = std::max({a[0][along], a[1][along], a[2][along]});
        for (const std::array<uint32_t, 3>& other : sorted) {
            if (low(two, other) > high) break;
            const Triangle b = corners(two, other);
            if (boxes_meet(a, b) && wrong(t, other))
                return fmt::format("the triangles at {} and {} cross", text(a[0]), text(b[0]));
        }
    }
    return {};
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

PaintedMesh mesh_block_as_solid(const VoxelBlock& block) {
    SolidCollector collector;
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
        std::string wrong = check_faces(block, code, part, 2, boundary::Faces::kOfTheSolid);
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

std::string check_crossings(const CollectedMesh& mesh) {
    return check_pairs(mesh, mesh,
                       [&](const auto& a, const auto& b) { return a != b && pierces(mesh, a, b); });
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
            wrong = check_pairs(mesh, behind,
                                [&, &mesh = mesh, &behind = behind](const auto& a, const auto& b) {
                                    return goes_through(corners(mesh, a), corners(behind, b));
                                });
        }
        if (!wrong.empty()) return fmt::format("material {}: {}", code, wrong);
    }
    return {};
}

}  // namespace openfab::testing

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/figures/polygonise.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <unordered_map>

namespace openfab::figures {

namespace {

/// The corners of a cube by bits x, y, z; each tetrahedron follows a path from corner 0 to corner 7
/// along the axes in one of the six orders, listed so that all have a positive volume.
constexpr int kTetrahedra[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7},
                                   {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};

class Marcher {
  public:
    Marcher(const Shape& shape, const Box3d& box, double cell) : shape_(shape), box_(box) {
        for (int a = 0; a < 3; ++a)
            count_[a] = static_cast<int32_t>(std::ceil(box.size()[a] / cell)) + 1;
        cell_ = cell;
        values_.reserve(static_cast<size_t>(count_.x) * static_cast<size_t>(count_.y) *
                        static_cast<size_t>(count_.z));
        for (int32_t z = 0; z < count_.z; ++z) {
            for (int32_t y = 0; y < count_.y; ++y) {
                for (int32_t x = 0; x < count_.x; ++x) {
                    // Grid points exactly on the surface would give triangles without area.
                    const double value = shape.value(position({x, y, z}));
                    values_.push_back(value == 0 ? 1e-9 : value);
                }
            }
        }
    }

    TriangleMesh run() {
        for (int32_t z = 0; z + 1 < count_.z; ++z) {
            for (int32_t y = 0; y + 1 < count_.y; ++y) {
                for (int32_t x = 0; x + 1 < count_.x; ++x) {
                    cube({x, y, z});
                }
            }
        }
        return std::move(mesh_);
    }

  private:
    Vec3d position(Vec3i at) const { return box_.lo + vec_cast<double>(at) * cell_; }
    int64_t index(Vec3i at) const {
        return (static_cast<int64_t>(at.z) * count_.y + at.y) * count_.x + at.x;
    }
    double value(int64_t i) const { return values_[i]; }

    void cube(Vec3i at) {
        std::array<Vec3i, 8> corners;
        int inside = 0;
        for (int c = 0; c < 8; ++c) {
            corners[c] = at + Vec3i{c & 1, (c >> 1) & 1, c >> 2};
            if (value(index(corners[c])) < 0) ++inside;
        }
        if (inside == 0 || inside == 8) return;
        for (const auto& row : kTetrahedra) {
            std::array<Vec3i, 4> tetrahedron;
            for (size_t k = 0; k < 4; ++k)
                tetrahedron[k] = corners[row[k]];
            cut(tetrahedron);
        }
    }

    /// The tetrahedron's orientation decides that of its triangles; their own would be unreliable
    /// for slivers.
    void cut(const std::array<Vec3i, 4>& t) {
        std::array<size_t, 4> order{};
        size_t ins = 0;
        for (size_t k = 0; k < 4; ++k) {
            if (value(index(t[k])) < 0) order[ins++] = k;
        }
        if (ins == 0 || ins == 4) return;
        size_t next = ins;
        for (size_t k = 0; k < 4; ++k) {
            if (value(index(t[k])) >= 0) order[next++] = k;
        }
        bool odd = false;
        for (size_t i = 0; i < 4; ++i) {
            for (size_t j = i + 1; j < 4; ++j)
                odd ^= order[i] > order[j];
        }
        const auto edge = [&](size_t a, size_t b) { return crossing(t[order[a]], t[order[b]]); };
        if (ins == 1) {
            add(edge(0, 1), edge(0, 2), edge(0, 3), odd);
        } else if (ins == 3) {
            add(edge(0, 3), edge(1, 3), edge(2, 3), odd);
        } else {
            const int32_t a = edge(0, 2);
            const int32_t b = edge(0, 3);
            const int32_t c = edge(1, 3);
            const int32_t d = edge(1, 2);
            add(a, b, c, odd);
            add(a, c, d, odd);
        }
    }

    int32_t crossing(Vec3i a, Vec3i b) {
        int64_t ia = index(a);
        int64_t ib = index(b);
        if (ia > ib) {
            std::swap(ia, ib);
            std::swap(a, b);
        }
        const int64_t key = ia * 8 + (b.x - a.x) + 2 * (b.y - a.y) + 4 * (b.z - a.z);
        const auto found = points_.find(key);
        if (found != points_.end()) return found->second;
        const double t = value(ia) / (value(ia) - value(ib));
        const Vec3d from = position(a);
        const auto id = static_cast<int32_t>(mesh_.points.size());
        mesh_.points.push_back(from + (position(b) - from) * t);
        points_.emplace(key, id);
        return id;
    }

    void add(int32_t a, int32_t b, int32_t c, bool turned) {
        if (turned) std::swap(b, c);
        mesh_.triangles.push_back({a, b, c});
    }

    const Shape& shape_;
    Box3d box_;
    Vec3i count_;
    double cell_ = 1;
    std::vector<double> values_;
    std::unordered_map<int64_t, int32_t> points_;
    TriangleMesh mesh_;
};

Vec3d unit(Vec3d v) {
    const double n = length(v);
    return n > 0 ? v * (1 / n) : Vec3d{0, 0, 1};
}

/// A Newton step towards the surface, at most a quarter of a cell long.
Vec3d towards_surface(const Shape& shape, Vec3d p, Vec3d slope, double cell) {
    const double steepness = dot(slope, slope);
    if (steepness < 1e-6) return p;
    const Vec3d move = slope * (-shape.value(p) / steepness);
    const double far = length(move);
    return p + (far > cell / 4 ? move * (cell / 4 / far) : move);
}

void relax(const Shape& shape, double cell, TriangleMesh* mesh) {
    std::vector<Vec3d> sum(mesh->points.size());
    std::vector<double> count(mesh->points.size());
    constexpr int kRounds = 7;
    for (int round = 0; round < kRounds; ++round) {
        std::fill(sum.begin(), sum.end(), Vec3d{});
        std::fill(count.begin(), count.end(), 0.0);
        for (const auto& triangle : mesh->triangles) {
            for (size_t k = 0; k < 3; ++k) {
                const auto self = static_cast<size_t>(triangle[k]);
                const auto next = static_cast<size_t>(triangle[(k + 1) % 3]);
                sum[self] = sum[self] + mesh->points[next];
                count[self] += 1;
            }
        }
        // The last rounds only return to the surface.
        const double pace = round < kRounds - 2 ? 0.6 : 0;
        for (size_t i = 0; i < mesh->points.size(); ++i) {
            const Vec3d p = mesh->points[i];
            const Vec3d slope = shape.gradient(p);
            const Vec3d n = unit(slope);
            const Vec3d pull = sum[i] * (1 / count[i]) - p;
            mesh->points[i] =
                towards_surface(shape, p + (pull - n * dot(pull, n)) * pace, slope, cell);
        }
    }
}

}  // namespace

TriangleMesh polygonise(const Shape& shape, const Box3d& box, double cell_mm) {
    TriangleMesh mesh = Marcher(shape, box, cell_mm).run();
    relax(shape, cell_mm, &mesh);
    for (const Vec3d& p : mesh.points) {
        mesh.normals.push_back(unit(shape.gradient(p)));
        mesh.box.add(p);
    }
    return mesh;
}

std::string write_obj(const TriangleMesh& mesh, const std::string& name, double cell_mm) {
    std::string text = fmt::format(
        "# {}: made by openfab-figures (tools/figures), cell {} mm; millimetres, z up, looks along "
        "+x\n",
        name, cell_mm);
    auto out = std::back_inserter(text);
    const Vec3d size = mesh.box.size();
    for (const Vec3d& p : mesh.points)
        fmt::format_to(out, "v {:.4f} {:.4f} {:.4f}\n", p.x, p.y, p.z);
    for (const Vec3d& p : mesh.points) {
        fmt::format_to(out, "vt {:.5f} {:.5f}\n", (p.x - mesh.box.lo.x) / size.x,
                       (p.z - mesh.box.lo.z) / size.z);
    }
    for (const Vec3d& n : mesh.normals)
        fmt::format_to(out, "vn {:.4f} {:.4f} {:.4f}\n", n.x, n.y, n.z);
    for (const auto& t : mesh.triangles) {
        fmt::format_to(out, "f {0}/{0}/{0} {1}/{1}/{1} {2}/{2}/{2}\n", t[0] + 1, t[1] + 1,
                       t[2] + 1);
    }
    return text;
}

}  // namespace openfab::figures

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Plain triangle meshes behind the Surface interface, and the meshes that tests and benchmarks of
// nearest queries share.

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <map>
#include <memory>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "runtime/nearest/engine.h"
#include "runtime/surface/surface.h"
#include "simd/isa.h"

namespace openfab::testing {

inline const char* name_of(simd::Isa set) {
    return set == simd::Isa::kAvx512 ? "AVX-512" : set == simd::Isa::kAvx2Fma ? "AVX2" : "SSE4.1";
}

struct TriangleMesh {
    std::vector<Vec3f> positions;
    std::vector<std::array<int32_t, 3>> triangles;

    int32_t add(const Vec3f& p) {
        positions.push_back(p);
        return static_cast<int32_t>(positions.size()) - 1;
    }
    Box3f box() const {
        Box3f b;
        for (const Vec3f& p : positions)
            b.add(p);
        return b;
    }
};

/// A mesh as a Surface. With `per_patch` 0 each triangle is an identity patch; else that many
/// consecutive triangles form one patch that is diced on demand, with a box that is `loose_mm` too
/// large. Attributes: uv-like (x, y) / 10 and one int, the triangle's index in the mesh.
class MeshSurface final : public surface::Surface {
  public:
    explicit MeshSurface(TriangleMesh mesh, int32_t per_patch = 0, float loose_mm = 0)
        : mesh_(std::move(mesh)),
          per_patch_(per_patch == 0 ? 1 : per_patch),
          identity_(per_patch == 0) {
        const auto count = static_cast<int32_t>(mesh_.triangles.size());
        ranges_.float_components = 2;
        ranges_.int_components = 1;
        for (int32_t first = 0; first < count; first += per_patch_) {
            surface::Patch patch;
            patch.kind =
                per_patch == 0 ? surface::PatchKind::kIdentity : surface::PatchKind::kLattice;
            patch.triangle = first;
            const int32_t end = std::min(count, first + per_patch_);
            for (int32_t t = first; t < end; ++t) {
                for (const int32_t v : mesh_.triangles[t]) {
                    patch.bounds.add(mesh_.positions[v]);
                }
            }
            for (int a = 0; a < 2; ++a) {
                ranges_.float_lo.push_back(patch.bounds.lo[a] / 10);
                ranges_.float_hi.push_back(patch.bounds.hi[a] / 10);
            }
            for (int a = 0; a < 3; ++a) {
                patch.bounds.lo[a] -= loose_mm;
                patch.bounds.hi[a] += loose_mm;
            }
            ranges_.int_lo.push_back(first);
            ranges_.int_hi.push_back(end - 1);
            patches_.push_back(patch);
        }
    }

    const TriangleMesh& mesh() const { return mesh_; }
    const std::vector<surface::Patch>& patches() const override { return patches_; }
    const surface::PatchRanges& ranges() const override { return ranges_; }
    bool identity() const override { return identity_; }
    std::shared_ptr<const surface::MicroMesh> micro(int32_t patch) const override {
        auto out = std::make_shared<surface::MicroMesh>();
        if (stopped_ && !identity_) return out;
        ++made_;
        const size_t first = static_cast<size_t>(patch) * static_cast<size_t>(per_patch_);
        const size_t end =
            std::min(mesh_.triangles.size(), first + static_cast<size_t>(per_patch_));
        for (size_t t = first; t < end; ++t) {
            const auto base = static_cast<int32_t>(out->positions.size());
            for (const int32_t v : mesh_.triangles[t]) {
                const Vec3f& p = mesh_.positions[v];
                out->positions.push_back(p);
                out->vertex_attributes.push_back(p.x / 10);
                out->vertex_attributes.push_back(p.y / 10);
            }
            out->triangles.push_back({base, base + 1, base + 2});
            out->triangle_attributes.push_back(static_cast<uint32_t>(t));
        }
        return out;
    }
    bool identity_corners(int32_t patch, std::array<Vec3f, 3>* out) const override {
        for (size_t k = 0; k < 3; ++k) {
            const int32_t v = mesh_.triangles[patch][k];
            (*out)[k] = mesh_.positions[v];
        }
        return true;
    }
    void displacement_bounds(int32_t patch,
                             std::vector<surface::GrownPolygon>* out) const override {
        const Box3f& bounds = patches_[patch].bounds;
        surface::GrownPolygon all;
        all.add({0, 0, 0});
        all.grow = {vec_cast<double>(bounds.lo), vec_cast<double>(bounds.hi)};
        out->push_back(all);
    }
    Box3d exact_box(const Affine3d& map) const override {
        Box3d box;
        for (const Vec3f& p : mesh_.positions)
            box.add(map.apply(vec_cast<double>(p)));
        return box;
    }
    surface::SurfaceCounts counts() const override { return {}; }
    Result<void> status() const override { return {}; }
    int64_t times_made() const { return made_; }
    /// From now on dicing returns empty patches, as when a print is stopped.
    void stop() { stopped_ = true; }

  private:
    TriangleMesh mesh_;
    int32_t per_patch_;
    bool identity_;
    std::vector<surface::Patch> patches_;
    surface::PatchRanges ranges_;
    mutable std::atomic<int64_t> made_{0};
    bool stopped_ = false;
};

/// Returns the frame of an unrotated part whose voxel (0, 0, 0) has its center half a pitch from
/// `origin`.
inline std::array<float, OPENFAB_FRAME_COUNT> make_test_frame(const Vec3f& pitch,
                                                              const Vec3f& origin) {
    std::array<float, OPENFAB_FRAME_COUNT> f{};
    f[OPENFAB_FRAME_STEP_I] = pitch.x;
    f[OPENFAB_FRAME_STEP_J + 1] = pitch.y;
    f[OPENFAB_FRAME_STEP_K + 2] = pitch.z;
    for (int a = 0; a < 3; ++a) {
        f[static_cast<size_t>(OPENFAB_FRAME_ORIGIN + a)] = origin[a];
        f[static_cast<size_t>(OPENFAB_FRAME_VOXEL_SIZE + a)] = pitch[a];
    }
    return f;
}

/// Makes random triangles in a cube of +-`reach`, some of them needles, some without area, some
/// duplicated.
inline TriangleMesh make_soup(uint32_t seed, int count, float reach, float size) {
    std::mt19937 random(seed);
    const auto uniform = [&](float r) {
        return (static_cast<float>(random() >> 8) * 0x1p-24f * 2 - 1) * r;
    };
    const auto point = [&](float r) {
        const float x = uniform(r), y = uniform(r), z = uniform(r);
        return Vec3f{x, y, z};
    };
    TriangleMesh m;
    for (int i = 0; i < count; ++i) {
        const Vec3f c = point(reach);
        const Vec3f a = c + point(size);
        Vec3f b = c + point(size);
        if (i % 11 == 3) b = c + (a - c) * 0.5f + point(size * 1e-5f);
        if (i % 13 == 5) b = c + (a - c) * 0.5f;
        const int32_t v = m.add(c);
        m.add(a);
        m.add(b);
        m.triangles.push_back({v, v + 1, v + 2});
        if (i % 17 == 7) m.triangles.push_back({v + 1, v + 2, v});
    }
    return m;
}

/// Makes a closed surface from a map of (u, v) in [0, 1]², `nu` by `nv` quads, both directions
/// periodic.
template <typename Map>
TriangleMesh make_periodic(int nu, int nv, const Map& map) {
    TriangleMesh m;
    for (int j = 0; j < nv; ++j) {
        for (int i = 0; i < nu; ++i)
            m.add(map(static_cast<double>(i) / nu, static_cast<double>(j) / nv));
    }
    for (int j = 0; j < nv; ++j) {
        for (int i = 0; i < nu; ++i) {
            const int i1 = (i + 1) % nu, j1 = (j + 1) % nv;
            m.triangles.push_back({j * nu + i, j * nu + i1, j1 * nu + i1});
            m.triangles.push_back({j * nu + i, j1 * nu + i1, j1 * nu + i});
        }
    }
    return m;
}

inline TriangleMesh make_torus(int nu, int nv, double large, double small) {
    return make_periodic(nu, nv, [&](double u, double v) {
        const double a = u * 2 * M_PI, b = v * 2 * M_PI, r = large + small * std::cos(b);
        return vec_cast<float>(Vec3d{r * std::cos(a), r * std::sin(a), small * std::sin(b)});
    });
}

/// Projects a cube's faces, `n` by `n` quads each, onto a sphere: closed, 12 n² triangles.
/// `radius_at` takes a unit vector.
template <typename Radius>
TriangleMesh make_ball(int n, const Radius& radius_at) {
    TriangleMesh m;
    std::vector<int32_t> at(
        static_cast<size_t>(n + 1) * static_cast<size_t>(n + 1) * static_cast<size_t>(n + 1), -1);
    const auto vertex = [&](const Vec3i& g) {
        const auto s = static_cast<size_t>(n + 1);
        int32_t& v = at[(static_cast<size_t>(g.x) * s + static_cast<size_t>(g.y)) * s +
                        static_cast<size_t>(g.z)];
        if (v < 0) {
            Vec3d d;
            for (int a = 0; a < 3; ++a)
                d[a] = std::tan((static_cast<double>(g[a]) / n * 2 - 1) * M_PI / 4);
            d = d * (1.0 / length(d));
            v = m.add(vec_cast<float>(d * radius_at(d)));
        }
        return v;
    };
    for (int axis = 0; axis < 3; ++axis) {
        for (int side = 0; side < 2; ++side) {
            for (int j = 0; j < n; ++j) {
                for (int i = 0; i < n; ++i) {
                    int32_t q[4];
                    for (int k = 0; k < 4; ++k) {
                        Vec3i g;
                        g[axis] = side * n;
                        g[(axis + 1) % 3] = i + (k == 1 || k == 2 ? 1 : 0);
                        g[(axis + 2) % 3] = j + (k >= 2 ? 1 : 0);
                        q[k] = vertex(g);
                    }
                    if (side == 0) std::swap(q[1], q[3]);
                    m.triangles.push_back({q[0], q[1], q[2]});
                    m.triangles.push_back({q[0], q[2], q[3]});
                }
            }
        }
    }
    return m;
}

/// Makes the boundary of a union of unit cells of a grid (1 = full): reflex edges, vertices on the
/// grid, ties everywhere.
inline TriangleMesh make_cells(const std::vector<Vec3i>& cells, float size) {
    TriangleMesh m;
    const auto full = [&](const Vec3i& c) {
        for (const Vec3i& other : cells) {
            if (other == c) return true;
        }
        return false;
    };
    for (const Vec3i& cell : cells) {
        for (int axis = 0; axis < 3; ++axis) {
            for (int side = 0; side < 2; ++side) {
                Vec3i next = cell;
                next[axis] += side == 1 ? 1 : -1;
                if (full(next)) continue;
                int32_t q[4];
                for (int k = 0; k < 4; ++k) {
                    Vec3i g = cell;
                    g[axis] += side;
                    g[(axis + 1) % 3] += k == 1 || k == 2 ? 1 : 0;
                    g[(axis + 2) % 3] += k >= 2 ? 1 : 0;
                    q[k] = m.add(vec_cast<float>(g) * size);
                }
                if (side == 0) std::swap(q[1], q[3]);
                m.triangles.push_back({q[0], q[1], q[2]});
                m.triangles.push_back({q[0], q[2], q[3]});
            }
        }
    }
    return m;
}

/// Reads the triangles of an OBJ file, rotated from y up to z up, centered and scaled to a height
/// of `height_mm`; empty if the file does not exist.
inline TriangleMesh read_obj(const std::string& path, double height_mm) {
    TriangleMesh m;
    std::ifstream in(path);
    std::vector<Vec3d> p;
    std::string line, word;
    while (std::getline(in, line)) {
        std::istringstream words(line);
        words >> word;
        if (word == "v") {
            Vec3d v;
            words >> v.x >> v.z >> v.y;
            v.y = -v.y;
            p.push_back(v);
        } else if (word == "f") {
            std::vector<int32_t> face;
            while (words >> word)
                face.push_back(std::stoi(word) - 1);
            for (size_t k = 2; k < face.size(); ++k)
                m.triangles.push_back({face[0], face[k - 1], face[k]});
        }
        word.clear();
    }
    Box3d box;
    for (const Vec3d& v : p)
        box.add(v);
    for (const Vec3d& v : p)
        m.add(vec_cast<float>((v - box.center()) * (height_mm / box.size().z)));
    return m;
}

/// Splits each triangle into n², with n segments along each edge; neighbours share their vertices.
inline TriangleMesh subdivide(const TriangleMesh& m, int32_t n) {
    TriangleMesh out;
    out.positions = m.positions;
    const auto between = [n](const Vec3f& a, const Vec3f& b, int32_t k) {
        return a + (b - a) * (static_cast<float>(k) / static_cast<float>(n));
    };
    std::map<std::pair<int32_t, int32_t>, int32_t> first_on_edge;
    // Returns vertex k of n from corner a to corner b.
    const auto on_edge = [&](int32_t a, int32_t b, int32_t k) {
        if (k == 0) return a;
        if (k == n) return b;
        const auto [low, high] = std::minmax(a, b);
        const auto next = static_cast<int32_t>(out.positions.size());
        const auto [at, fresh] = first_on_edge.try_emplace({low, high}, next);
        for (int32_t i = 1; fresh && i < n; ++i) {
            out.add(between(m.positions[low], m.positions[high], i));
        }
        return at->second + (a == low ? k : n - k) - 1;
    };
    for (const auto& t : m.triangles) {
        // Row r has r + 1 vertices, from edge (0, 1) to edge (0, 2).
        std::vector<int32_t> above, row;
        for (int32_t r = 0; r <= n; ++r, std::swap(above, row)) {
            row.clear();
            const int32_t left = on_edge(t[0], t[1], r), right = on_edge(t[0], t[2], r);
            for (int32_t k = 0; k <= r; ++k) {
                if (r == n) {
                    row.push_back(on_edge(t[1], t[2], k));
                } else if (k == 0 || k == r) {
                    row.push_back(k == 0 ? left : right);
                } else {
                    const Vec3f a = out.positions[left], b = out.positions[right];
                    row.push_back(
                        out.add(a + (b - a) * (static_cast<float>(k) / static_cast<float>(r))));
                }
            }
            for (size_t k = 0; k + 1 < row.size(); ++k) {
                out.triangles.push_back({above[k], row[k], row[k + 1]});
                if (k + 1 < above.size())
                    out.triangles.push_back({above[k], row[k + 1], above[k + 1]});
            }
        }
    }
    return out;
}

}  // namespace openfab::testing

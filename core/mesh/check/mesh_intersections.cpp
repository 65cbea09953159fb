// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/check/mesh_intersections.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <utility>

#include "mesh/check/mesh_edges.h"
#include "mesh/check/triangle_tree.h"

namespace openfab::mesh {
namespace {

constexpr int64_t kMaxFound = 100'000;
constexpr int64_t kMaxTests = 20'000'000;
constexpr int64_t kMaxBoxes = 400'000'000;
/// Parts of the search, which threads share.
constexpr size_t kParts = 256;

/// A plane through three points, to classify others by side.
class Plane {
  public:
    Plane(const Vec3d& a, const Vec3d& b, const Vec3d& c) : a_(a) {
        const Vec3d u = b - a;
        const Vec3d v = c - a;
        const auto minor = [](double p, double q, double r, double s, double* size) {
            const double first = p * q, second = r * s;
            *size = std::fabs(first) + std::fabs(second);
            return first - second;
        };
        normal_.x = minor(u.y, v.z, u.z, v.y, &size_.x);
        normal_.y = minor(u.z, v.x, u.x, v.z, &size_.y);
        normal_.z = minor(u.x, v.y, u.y, v.x, &size_.z);
    }

    /// Returns the side of `p` if rounding cannot have changed it, else 0 (Shewchuk 1997: the error
    /// is below 7.8e-16 of the sum of absolute products).
    int side(const Vec3d& p) const {
        const Vec3d w = p - a_;
        const double volume = w.x * normal_.x + w.y * normal_.y + w.z * normal_.z;
        const double size =
            std::fabs(w.x) * size_.x + std::fabs(w.y) * size_.y + std::fabs(w.z) * size_.z;
        constexpr double kError = 1e-15;
        return volume > kError * size ? 1 : volume < -kError * size ? -1 : 0;
    }

  private:
    Vec3d a_;
    Vec3d normal_;
    Vec3d size_;  ///< sums of the magnitudes whose difference the normal is
};

using Corners = std::array<Vec3d, 3>;

/// What a search found, and the work it took.
struct Found {
    Intersections out;
    int64_t tests = 0, boxes = 0;

    bool within_limits() const {
        return out.all && tests <= kMaxTests && boxes <= kMaxBoxes && out.pairs < kMaxFound;
    }
    void add(const Intersections& other) {
        out.pairs += other.pairs;
        out.all = out.all && other.all;
        const bool lower = out.first < 0 ||
                           std::pair(other.first, other.second) < std::pair(out.first, out.second);
        if (other.first < 0 || !lower) return;
        out.first = other.first;
        out.second = other.second;
        out.point = other.point;
    }
};

/// The only other triangle at each edge of a mesh, if it uses it in the opposite direction; else -1.
/// Found when first asked for.
class Neighbours {
  public:
    explicit Neighbours(const Mesh& mesh) : mesh_(mesh) {}

    int32_t at(int32_t triangle, size_t edge) {
        // Isolated: a thread that waits in here must not begin another part of the search, which
        // might wait for this.
        std::call_once(once_, [&] { tbb::this_task_arena::isolate([&] { find(); }); });
        return neighbours_[triangle][edge];
    }

  private:
    void find() {
        neighbours_.assign(mesh_.triangles.size(), {-1, -1, -1});
        const std::vector<Edge> edges = sorted_edges(mesh_);
        const auto neighbour = [&](const Edge& e) -> int32_t& {
            const auto t = static_cast<size_t>(e.triangle);
            size_t i = 0;
            while (mesh_.triangles[t][i] != (e.forward ? e.a : e.b) ||
                   mesh_.triangles[t][(i + 1) % 3] != (e.forward ? e.b : e.a))
                ++i;
            return neighbours_[t][i];
        };
        for_each_edge(edges, [&](const Edge* first, const Edge* last) {
            if (last - first != 2 || first[0].forward == first[1].forward) return;
            neighbour(first[0]) = first[1].triangle;
            neighbour(first[1]) = first[0].triangle;
        });
    }

    const Mesh& mesh_;
    std::once_flag once_;
    std::vector<std::array<int32_t, 3>> neighbours_;
};

/// Searches a part of the tree on one thread.
class Search {
  public:
    Search(const Mesh& mesh, const TriangleTree& tree, Neighbours* neighbours)
        : mesh_(mesh), tree_(tree), neighbours_(*neighbours) {}

    /// Ends early at a limit, or where `stop` is set.
    Found run(const TriangleTree::NodePair& part, const std::atomic<bool>& stop) {
        tree_.for_each_pair(part, [&](int32_t t, int32_t other) {
            if (++found_.boxes > kMaxBoxes) found_.out.all = false;
            if (cross(t, other)) found(t, other);
            return found_.out.all && !stop.load(std::memory_order_relaxed);
        });
        return found_;
    }

  private:
    void found(int32_t t, int32_t other) {
        found_.add({1, found_.out.pairs + 1 < kMaxFound, t, other, point_});
    }

    Corners corners(int32_t t) const {
        const auto& v = mesh_.triangles[t];
        return {mesh_.positions[v[0]], mesh_.positions[v[1]], mesh_.positions[v[2]]};
    }

    /// Skips neighbours over an edge, which touch along it.
    bool cross(int32_t a, int32_t b) {
        const auto& va = mesh_.triangles[a];
        const auto& vb = mesh_.triangles[b];
        int shared = 0;
        size_t at_a = 0;
        size_t at_b = 0;
        for (size_t i = 0; i < 3; ++i) {
            for (size_t j = 0; j < 3; ++j) {
                if (va[i] != vb[j]) continue;
                ++shared;
                at_a = i;
                at_b = j;
            }
        }
        if (shared > 1) return false;
        if (++found_.tests > kMaxTests) {
            found_.out.all = false;
            return false;
        }
        const Corners of_a = corners(a);
        const Corners of_b = corners(b);
        const Sides sides_a = sides(of_b, of_a);
        if (on_one(sides_a, shared == 1 ? at_a : 3)) return false;
        const Sides sides_b = sides(of_a, of_b);
        if (on_one(sides_b, shared == 1 ? at_b : 3)) return false;
        if (shared == 1) {
            return edge_through(of_a, sides_a, (at_a + 1) % 3, b, of_b) ||
                   edge_through(of_b, sides_b, (at_b + 1) % 3, a, of_a);
        }
        for (size_t i = 0; i < 3; ++i) {
            if (edge_through(of_a, sides_a, i, b, of_b) || edge_through(of_b, sides_b, i, a, of_a))
                return true;
        }
        return false;
    }

    /// Returns the sides of a triangle's plane on which three points certainly are.
    using Sides = std::array<int, 3>;
    static Sides sides(const Corners& t, const Corners& points) {
        const Plane plane(t[0], t[1], t[2]);
        return {plane.side(points[0]), plane.side(points[1]), plane.side(points[2])};
    }
    /// Returns whether all corners, except a shared one, are certainly on one side.
    static bool on_one(const Sides& sides, size_t shared) {
        const int side = sides[shared == 0 ? 1 : 0];
        for (size_t i = 0; i < 3; ++i) {
            if (i != shared && sides[i] != side) return false;
        }
        return side != 0;
    }

    /// Returns whether edge `edge` of the triangle `from`, whose corners are on these sides of
    /// triangle `t`, passes through it.
    bool edge_through(const Corners& from, const Sides& at, size_t edge, int32_t t,
                      const Corners& triangle) {
        const int before = at[edge];
        if (before == 0 || at[(edge + 1) % 3] != -before) return false;
        const Vec3d& p = from[edge];
        const Vec3d& q = from[(edge + 1) % 3];
        int passed = 0;
        int unsure = 0;
        size_t border = 0;
        for (size_t i = 0; i < 3; ++i) {
            const int side = Plane(p, triangle[i], triangle[(i + 1) % 3]).side(q);
            passed |= side > 0 ? 1 : side < 0 ? 2 : 0;
            if (side != 0) continue;
            ++unsure;
            border = i;
        }
        if (passed == 3 || unsure > 1) return false;
        // Passes through the triangle's border within rounding: a crossing if it passes through the
        // neighbour's plane in the same direction, else a touch.
        if (unsure == 1) {
            const int32_t neighbour = neighbours_.at(t, border);
            if (neighbour < 0 || goes_through_plane(p, q, corners(neighbour)) != before)
                return false;
        }
        const Vec3d n = openfab::cross(triangle[1] - triangle[0], triangle[2] - triangle[0]);
        point_ = p + (q - p) * (dot(n, triangle[0] - p) / dot(n, q - p));
        return true;
    }

    /// Returns the side of p if q is certainly on the other one; else 0.
    static int goes_through_plane(const Vec3d& p, const Vec3d& q, const Corners& t) {
        const Plane plane(t[0], t[1], t[2]);
        const int side = plane.side(p);
        return side != 0 && plane.side(q) == -side ? side : 0;
    }

    const Mesh& mesh_;
    const TriangleTree& tree_;
    Neighbours& neighbours_;
    Found found_;
    Vec3d point_;
};

}  // namespace

Intersections find_intersections(const Mesh& mesh) {
    const TriangleTree tree(mesh);
    Neighbours neighbours(mesh);
    std::atomic<bool> stop{false};
    Found all;
    std::mutex mutex;
    const std::vector<TriangleTree::NodePair> parts = tree.parts_of_search(kParts);
    tbb::parallel_for(size_t{0}, parts.size(), [&](size_t i) {
        if (stop.load(std::memory_order_relaxed)) return;
        const Found found = Search(mesh, tree, &neighbours).run(parts[i], stop);
        const std::lock_guard lock(mutex);
        all.add(found.out);
        all.tests += found.tests;
        all.boxes += found.boxes;
        if (!all.within_limits()) stop.store(true, std::memory_order_relaxed);
    });
    if (all.within_limits()) return all.out;
    // Where a limit ends the search depends on its order: in that of one thread.
    stop.store(false);
    return Search(mesh, tree, &neighbours).run({}, stop).out;
}

}  // namespace openfab::mesh

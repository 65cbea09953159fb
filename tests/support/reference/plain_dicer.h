// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Dices a part triangle by triangle, the twin of runtime/surface.

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "tests/support/reference/dice.h"

namespace openfab::reference {

using Key = std::array<double, 3>;  // a position, ordered by x, y, z

/// A micro-vertex of a base triangle: a corner, point i of a side counted from its lower end, or a
/// lattice point.
struct Point {
    enum { kCorner, kSide, kInner } kind;
    int32_t number;  ///< corner or side, 0..2
    int32_t i;       ///< side
    int32_t a, b;    ///< inner
};

struct Vertex {
    Vec3f position;
    std::vector<float> floats;
    std::vector<uint32_t> ints;
};

class PlainDicer {
  public:
    PlainDicer(const part::Part& part, double s, const std::vector<uint8_t>& identity,
               const EvaluateMicro& evaluate)
        : part_(part), mesh_(*part.mesh), s_(s), identity_(identity), evaluate_(evaluate) {
        for (int32_t t = 0; t < triangles(); ++t) {
            if (dropped(t)) continue;
            for (int32_t c = 0; c < 3; ++c) {
                at_vertex_[key(t, c)].push_back({t, c});
                on_edge_[{std::min(key(t, c), key(t, c + 1)), std::max(key(t, c), key(t, c + 1))}]
                    .push_back({t, c});
            }
        }
    }
    std::vector<DicedTriangle> run();

  private:
    using Corner = std::array<int32_t, 2>;  // triangle, corner (or side)

    int32_t triangles() const { return static_cast<int32_t>(mesh_.triangles.size()); }
    const Vec3d& position(int32_t t, int32_t c) const {
        return mesh_.positions[static_cast<size_t>(mesh_.triangles[t][static_cast<size_t>(c % 3)])];
    }
    Key key(int32_t t, int32_t c) const {
        const Vec3d& p = position(t, c);
        return {p.x + 0.0, p.y + 0.0, p.z + 0.0};
    }
    bool dropped(int32_t t) const {
        return key(t, 0) == key(t, 1) || key(t, 1) == key(t, 2) || key(t, 2) == key(t, 0);
    }
    bool displaced(int32_t t) const { return !dropped(t) && identity_[t] == 0; }
    bool up(int32_t t, int32_t side) const { return key(t, side) < key(t, side + 1); }
    int32_t factor(int32_t t, int32_t side) const {
        const Vec3d &a = position(t, side), &b = position(t, side + 1);
        const double x = b.x - a.x, y = b.y - a.y, z = b.z - a.z;
        return static_cast<int32_t>(
            std::max(1.0, std::ceil(std::sqrt((x * x + y * y) + z * z) / s_)));
    }
    int32_t steps(int32_t t) const { return std::max({factor(t, 0), factor(t, 1), factor(t, 2)}); }
    const std::vector<Corner>& edge(int32_t t, int32_t side) const {
        return on_edge_.at(
            {std::min(key(t, side), key(t, side + 1)), std::max(key(t, side), key(t, side + 1))});
    }
    bool divided(int32_t t, int32_t side) const {
        for (const Corner& other : edge(t, side)) {
            if (displaced(other[0])) return true;
        }
        return false;
    }
    std::optional<Corner> partner(int32_t t, int32_t side) const;
    std::vector<uint32_t> input_bits(int32_t t, int32_t c) const;
    int32_t corner_evaluator(int32_t t, int32_t c) const;
    int32_t side_evaluator(int32_t t, int32_t side) const;

    Point classify(int32_t t, int32_t a, int32_t b) const;
    Point side_point(int32_t t, int32_t side, int32_t i) const;
    Vec3d undisplaced(int32_t t, const Point& point) const;
    float value(int32_t t, const Point& point, const std::array<float, 3>& corners) const;
    std::array<float, 3> corners_of(const part::PartAttribute& attribute, int32_t t,
                                    int32_t component) const;
    MicroInputs inputs(int32_t t, const Point& point) const;
    void frame(int32_t t, MicroInputs* in) const;
    Vertex vertex(int32_t t, const Point& point) const;

    void begin_patch() { ++patch_, in_patch_ = 0; }
    void add(const Vertex& a, const Vertex& b, const Vertex& c, const std::vector<uint32_t>& ints,
             bool query, bool coverage);
    void do_identity(int32_t t);
    void do_displaced(int32_t t);
    void do_strip(const Corner& forward, const Corner& backward);
    void do_vertex(const std::vector<Corner>& corners);

    const part::Part& part_;
    const part::PartMesh& mesh_;
    const double s_;
    const std::vector<uint8_t>& identity_;
    const EvaluateMicro& evaluate_;
    std::map<Key, std::vector<Corner>> at_vertex_;
    std::map<std::pair<Key, Key>, std::vector<Corner>> on_edge_;
    int32_t patch_ = -1, in_patch_ = 0;
    std::vector<DicedTriangle> out_;
};

}  // namespace openfab::reference

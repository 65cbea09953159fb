// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/process_beams.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace openfab::program {

namespace {

using mesh::Beam;
using mesh::BeamEnd;
using mesh::Beams;

constexpr Vec3d kAxes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

class Mover {
  public:
    Mover(const Beams& from, const MovePlace& move) : from_(from), move_(move) {
        out_.beams.nodes.resize(from.nodes.size());
        for (size_t i = 0; i < from.nodes.size(); ++i)
            out_.beams.nodes[i] = moved(from.nodes[i]);
        out_.beams.attributes = from.attributes;
        for (mesh::BeamAttribute& attribute : out_.beams.attributes)
            attribute.ints.clear();
    }

    /// Adds a beam in up to `pieces`. Those of a round one join in balls. A cone that is cut across keeps
    /// its ends; the pieces between are round, with balls that touch its side from within.
    void add(size_t index, size_t pieces) {
        const Beam& beam = from_.beams[index];
        const Vec3d along = from_.nodes[node(beam, 1)] - from_.nodes[node(beam, 0)];
        const std::array<Vec3d, 2> across = directions_across(along);
        const bool ball = beam.nodes[0] == beam.nodes[1];
        const bool round = beam.ends[0] == BeamEnd::kBall && beam.ends[1] == BeamEnd::kBall;
        if (!round) pieces = std::min(pieces, most_cut_pieces(beam, length(along)));
        const float inscribed = round ? 1 : share_inscribed(beam, length(along));
        int32_t last = beam.nodes[0];
        float last_radius = ball ? ball_radius(beam) : radius_at(beam, 0, across);
        for (size_t k = 1; k <= pieces; ++k) {
            const bool whole = k == pieces;
            const double t = static_cast<double>(k) / static_cast<double>(pieces);
            const int32_t next = whole ? beam.nodes[1] : new_node(beam, t);
            const float radius = ball ? last_radius : radius_at(beam, t, across);
            if (round || (k > 1 && !whole)) {
                push({{last, next}, {inscribed * last_radius, inscribed * radius}}, index);
            } else {
                push({{last, next},
                      {last_radius, radius},
                      {k == 1 ? beam.ends[0] : BeamEnd::kFlat,
                       whole ? beam.ends[1] : BeamEnd::kFlat}},
                     index);
            }
            if (!round && pieces == 2 && !whole)
                push({{next, next}, {inscribed * radius, inscribed * radius}}, index);
            last = next;
            last_radius = radius;
        }
    }

    MovedBeams take() { return std::move(out_); }

  private:
    static size_t node(const Beam& beam, size_t end) {
        return static_cast<size_t>(beam.nodes[end]);
    }

    Vec3d moved(const Vec3d& p) {
        const std::optional<Vec3d> to = move_(p);
        if (!to) out_.lost = p;
        return to.value_or(p);
    }
    static std::array<Vec3d, 2> directions_across(const Vec3d& along) {
        size_t least = 0;
        for (size_t a = 1; a < 3; ++a) {
            if (std::fabs(along[static_cast<int>(a)]) < std::fabs(along[static_cast<int>(least)]))
                least = a;
        }
        const Vec3d u = cross(along, kAxes[least]);
        const double of_u = length(u);
        if (!(of_u > 0)) return {kAxes[0], kAxes[1]};
        const Vec3d v = cross(along, u);
        return {u * (1 / of_u), v * (1 / length(v))};
    }
    Vec3d place(const Beam& beam, double t) const {
        const Vec3d &a = from_.nodes[node(beam, 0)], &b = from_.nodes[node(beam, 1)];
        return a + (b - a) * t;
    }
    /// Returns half the mean of how far opposite places, so far from the middle, are apart.
    template <size_t N>
    float mean_reach(const Vec3d& middle, double radius, const std::array<Vec3d, N>& directions) {
        double sum = 0;
        for (const Vec3d& d : directions)
            sum += length(moved(middle + d * radius) - moved(middle - d * radius));
        return static_cast<float>(sum / (2 * static_cast<double>(N)));
    }
    float radius_at(const Beam& beam, double t, const std::array<Vec3d, 2>& across) {
        const double r0 = static_cast<double>(beam.radii[0]);
        const double radius = r0 + (static_cast<double>(beam.radii[1]) - r0) * t;
        return radius > 0 ? mean_reach(place(beam, t), radius, across) : 0;
    }
    float ball_radius(const Beam& beam) {
        return mean_reach(from_.nodes[node(beam, 0)], static_cast<double>(beam.radii[0]),
                          std::array<Vec3d, 3>{kAxes[0], kAxes[1], kAxes[2]});
    }
    int32_t new_node(const Beam& beam, double t) {
        Beams& out = out_.beams;
        out.nodes.push_back(moved(place(beam, t)));
        for (mesh::BeamAttribute& attribute : out.attributes) {
            if (attribute.is_int) continue;
            const auto n = static_cast<size_t>(attribute.components);
            for (size_t c = 0; c < n; ++c) {
                const float v0 = attribute.values[node(beam, 0) * n + c];
                const float v1 = attribute.values[node(beam, 1) * n + c];
                attribute.values.push_back(v0 + static_cast<float>(t) * (v1 - v0));
            }
        }
        return static_cast<int32_t>(out.nodes.size() - 1);
    }
    void push(const Beam& beam, size_t index) {
        out_.beams.beams.push_back(beam);
        for (size_t i = 0; i < from_.attributes.size(); ++i) {
            const mesh::BeamAttribute& from = from_.attributes[i];
            if (!from.is_int) continue;
            const auto n = static_cast<size_t>(from.components);
            const int32_t* values = &from.ints[index * n];
            std::vector<int32_t>& ints = out_.beams.attributes[i].ints;
            ints.insert(ints.end(), values, values + n);
        }
    }
    /// Balls at the joints do not reach beyond the ends.
    static size_t most_cut_pieces(const Beam& beam, double whole) {
        const double radius = static_cast<double>(std::max(beam.radii[0], beam.radii[1]));
        if (!(radius > 0)) return 1;
        return std::max<size_t>(1, static_cast<size_t>(whole / (1.5 * radius)));
    }
    /// Returns the radius of a ball that touches the side of a cone from within, of the cone's there.
    static float share_inscribed(const Beam& beam, double whole) {
        const double rise = static_cast<double>(beam.radii[1] - beam.radii[0]) / whole;
        return static_cast<float>(1 / std::sqrt(1 + rise * rise));
    }

    const Beams& from_;
    const MovePlace& move_;
    MovedBeams out_;
};

}  // namespace

MovedBeams move_beams(const Beams& from, double longest_mm, size_t most_beams,
                      const std::function<double(const Vec3d& a, const Vec3d& b)>& length_mm,
                      const MovePlace& move) {
    std::vector<size_t> pieces;
    double all = 0;
    for (const Beam& beam : from.beams) {
        const double length = length_mm(from.nodes[static_cast<size_t>(beam.nodes[0])],
                                        from.nodes[static_cast<size_t>(beam.nodes[1])]);
        const double count = std::max(1.0, std::ceil(length / longest_mm - 1e-9));
        all += count;
        if (all > static_cast<double>(most_beams)) {
            MovedBeams none;
            none.too_many = true;
            return none;
        }
        pieces.push_back(static_cast<size_t>(count));
    }
    Mover mover(from, move);
    for (size_t i = 0; i < from.beams.size(); ++i)
        mover.add(i, pieces[i]);
    return mover.take();
}

}  // namespace openfab::program

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/part/stresses.h"

#include <algorithm>
#include <cmath>

#include "mechanics/part/eigen.h"
#include "mechanics/solver/parallel.h"
#include "mechanics/solver/strain.h"

namespace openfab::mechanics {

double von_mises_of(const std::array<double, 6>& s) {
    const double a = s[0] - s[1], b = s[1] - s[2], c = s[2] - s[0];
    return std::sqrt((a * a + b * b + c * c) / 2 + 3 * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5]));
}

namespace {

using Strain = std::array<float, 6>;
using Place = std::array<int32_t, 3>;

/// Of an element at a surface: how its strain changes from one side to the other, and how far from its middle
/// each side is, in elements: the surface, or half an element where a neighbour follows.
struct Slope {
    std::array<Strain, 3> by{};
    std::array<std::array<float, 2>, 3> reach{};
};

class Stresses {
  public:
    Stresses(const PartProblem& p, Field<double, kElastic>* moved)
        : p_(p), g_(p.grid), v_(p.voxels), kind_(p.elements.kind), moved_(*moved) {}

    PartFields run();

  private:
    template <typename F>
    void for_solid(const F& f) const {
        for_each_index(g_.elements[2], [&](int32_t z) {
            for (int32_t y = 0; y < g_.elements[1]; ++y)
                for (int32_t x = 0; x < g_.elements[0]; ++x) {
                    const size_t e = g_.element(x, y, z);
                    if (kind_[e] == kSolid) f(Place{x, y, z}, e);
                }
        });
    }
    /// The element there; -1 beyond the grid.
    int64_t at(const Place& p) const {
        for (size_t a = 0; a < 3; ++a)
            if (p[a] < 0 || p[a] >= g_.elements[a]) return -1;
        return static_cast<int64_t>(g_.element(p[0], p[1], p[2]));
    }
    float stiffness(size_t e) const { return v_.mu[e] / v_.solid[e]; }
    /// Whether two solid elements are of one material: strains go on from one to the other.
    bool alike(size_t e, size_t other) const {
        constexpr float kJump = 1.5F;
        if (kind_[other] != kSolid || v_.code[e] != v_.code[other]) return false;
        const float a = stiffness(e), b = stiffness(other);
        return a < kJump * b && b < kJump * a;
    }
    bool is_inside(const Place& p, size_t e) const;
    Slope slope_of(const Place& p, size_t e) const;
    /// Where no neighbour is alike along an axis: what its own corners say.
    Strain own_slope(const Place& p, size_t e, size_t axis) const;
    void set_reach(const Place& p, size_t e, size_t axis, bool alone, Slope* out) const;
    std::array<double, 6> strain_at(const Place& p, size_t e, int corner) const;
    /// In the middle of a face.
    std::array<double, 6> strain_on(size_t e, int face) const;
    void store(size_t e, const std::array<double, 6>& strain);

    const PartProblem& p_;
    const Grid& g_;
    const Voxels& v_;
    std::span<const uint8_t> kind_;
    Field<double, kElastic>& moved_;
    PartFields out_;
    std::vector<Strain> centre_;
    std::vector<int32_t> slot_;  ///< of an element's slope; -1: inside
    std::vector<Slope> slopes_;
};

bool Stresses::is_inside(const Place& p, size_t e) const {
    for (int32_t z = -1; z <= 1; ++z)
        for (int32_t y = -1; y <= 1; ++y)
            for (int32_t x = -1; x <= 1; ++x) {
                const int64_t other = at({p[0] + x, p[1] + y, p[2] + z});
                if (other < 0 || !alike(e, static_cast<size_t>(other))) return false;
            }
    return true;
}

Strain Stresses::own_slope(const Place& p, size_t e, size_t axis) const {
    // Derivatives at the two faces across the axis, by displacements of their corners.
    const size_t b = (axis + 1) % 3, c = (axis + 2) % 3;
    double d[3][3] = {};  // [component][along b or c], of the far face less the near one
    for (int k = 0; k < 8; ++k) {
        const int bit[3] = {k & 1, k >> 1 & 1, k >> 2};
        for (size_t i = 0; i < 3; ++i) {
            const double u =
                moved_.row(static_cast<int>(i), p[1] + bit[1], p[2] + bit[2])[p[0] + bit[0]];
            for (const size_t j : {b, c})
                d[i][j] += (bit[axis] ? u : -u) * (bit[j] ? 1 : -1) / (2 * g_.pitch_mm[j]);
        }
    }
    // Shears by number of the axis that they lack: yz, xz, xy. Those along the axis vanish at both faces, as
    // the normal stress does.
    Strain out{};
    out[b] = static_cast<float>(d[b][b]);
    out[c] = static_cast<float>(d[c][c]);
    out[3 + axis] = static_cast<float>(d[b][c] + d[c][b]);
    const double lambda = static_cast<double>(v_.lambda[e]), mu = static_cast<double>(v_.mu[e]);
    out[axis] = static_cast<float>(-lambda / (lambda + 2 * mu) * (d[b][b] + d[c][c]));
    return out;
}

void Stresses::set_reach(const Place& p, size_t e, size_t axis, bool alone, Slope* out) const {
    const float own = v_.solid[e];
    float rim[2] = {};
    bool open[2] = {};
    for (size_t side = 0; side < 2; ++side) {
        Place q = p;
        q[axis] += side == 1 ? 1 : -1;
        const int64_t other = at(q);
        const uint8_t kind = other < 0 ? uint8_t{kNothing} : kind_[static_cast<size_t>(other)];
        open[side] = kind != kSolid;
        if (kind == kRim) rim[side] = v_.solid[static_cast<size_t>(other)];
    }
    for (size_t side = 0; side < 2; ++side)
        out->reach[axis][side] = !open[side] ? 0.5F
                                 : alone && open[1 - side]
                                     ? 0.5F * std::min(own + rim[0] + rim[1], 2.F)
                                     : own - 0.5F + rim[side];
}

Slope Stresses::slope_of(const Place& p, size_t e) const {
    Slope out;
    // Elements alike around it.
    int64_t around[27];
    for (int o = 0; o < 27; ++o) {
        const int64_t other = at({p[0] + o % 3 - 1, p[1] + o / 3 % 3 - 1, p[2] + o / 9 - 1});
        around[o] = other >= 0 && alike(e, static_cast<size_t>(other)) ? other : -1;
    }
    constexpr int kStride[3] = {1, 3, 9};
    for (size_t axis = 0; axis < 3; ++axis) {
        std::array<double, 6> sum{};
        double weight = 0;
        for (int o = 0; o < 27; ++o) {
            const int place[3] = {o % 3, o / 3 % 3, o / 9};
            if (place[axis] == 2) continue;
            const int64_t a = around[o], b = around[o + kStride[axis]];
            if (a < 0 || b < 0) continue;
            // What is beside counts less.
            double w = 1;
            for (size_t other = 0; other < 3; ++other)
                if (other != axis && place[other] == 1) w *= 4;
            weight += w;
            for (size_t i = 0; i < 6; ++i)
                sum[i] += w * static_cast<double>(centre_[static_cast<size_t>(b)][i] -
                                                  centre_[static_cast<size_t>(a)][i]);
        }
        if (weight > 0)
            for (size_t i = 0; i < 6; ++i)
                out.by[axis][i] = static_cast<float>(sum[i] / weight);
        else
            out.by[axis] = own_slope(p, e, axis);
        set_reach(p, e, axis, !(weight > 0), &out);
    }
    return out;
}

std::array<double, 6> Stresses::strain_at(const Place& p, size_t e, int corner) const {
    std::array<double, 6> sum{};
    std::array<std::pair<size_t, int>, 8> found;  // elements that have this node, as which corner
    size_t number = 0;
    for (int k = 0; k < 8; ++k) {
        const int64_t other =
            at({p[0] + (corner & 1) - (k & 1), p[1] + (corner >> 1 & 1) - (k >> 1 & 1),
                p[2] + (corner >> 2) - (k >> 2)});
        if (other < 0 || !alike(e, static_cast<size_t>(other))) continue;
        found[number++] = {static_cast<size_t>(other), k};
        for (size_t i = 0; i < 6; ++i)
            sum[i] += static_cast<double>(centre_[static_cast<size_t>(other)][i]);
    }
    // Among eight, slopes cancel each other; if there are fewer, each has one.
    for (size_t j = 0; number < 8 && j < number; ++j) {
        const auto& [other, k] = found[j];
        if (slot_[other] < 0) continue;
        const Slope& s = slopes_[static_cast<size_t>(slot_[other])];
        for (size_t axis = 0; axis < 3; ++axis) {
            const bool far = (k >> axis & 1) != 0;
            const double reach = static_cast<double>(s.reach[axis][far ? 1 : 0]) * (far ? 1 : -1);
            for (size_t i = 0; i < 6; ++i)
                sum[i] += reach * static_cast<double>(s.by[axis][i]);
        }
    }
    for (double& v : sum)
        v /= static_cast<double>(number);
    return sum;
}

std::array<double, 6> Stresses::strain_on(size_t e, int face) const {
    const Slope& s = slopes_[static_cast<size_t>(slot_[e])];
    const auto axis = static_cast<size_t>(face / 2), side = static_cast<size_t>(face % 2);
    const double reach = static_cast<double>(s.reach[axis][side]) * (side == 1 ? 1 : -1);
    std::array<double, 6> out;
    for (size_t i = 0; i < 6; ++i)
        out[i] = static_cast<double>(centre_[e][i]) + reach * static_cast<double>(s.by[axis][i]);
    return out;
}

void Stresses::store(size_t e, const std::array<double, 6>& strain) {
    const double share = static_cast<double>(v_.solid[e]);
    const auto s = stress_of(strain, static_cast<double>(v_.lambda[e]) / share,
                             static_cast<double>(v_.mu[e]) / share);
    const std::array<double, 3> principal = principal_of(s);
    out_.von_mises_MPa[e] = std::max(out_.von_mises_MPa[e], static_cast<float>(von_mises_of(s)));
    out_.tension_MPa[e] = std::max(out_.tension_MPa[e], static_cast<float>(principal[2]));
    out_.compression_MPa[e] = std::min(out_.compression_MPa[e], static_cast<float>(principal[0]));
}

PartFields Stresses::run() {
    const auto n = static_cast<size_t>(g_.element_count());
    constexpr float kLowest = -3e38F;
    out_.von_mises_MPa.resize(n);
    out_.safety.resize(n);
    out_.tension_MPa.resize(n);
    out_.compression_MPa.resize(n);
    centre_.resize(n);
    slot_.assign(n, -1);
    for_solid([&](const Place& p, size_t e) {
        const auto s = strain_of(centre_gradient(moved_, g_, p[0], p[1], p[2]));
        for (size_t i = 0; i < 6; ++i)
            centre_[e][i] = static_cast<float>(s[i]);
        if (!is_inside(p, e)) slot_[e] = 0;
        out_.tension_MPa[e] = kLowest;
        out_.compression_MPa[e] = -kLowest;
    });
    int32_t count = 0;
    for (int32_t& slot : slot_)
        if (slot == 0) slot = count++;
    slopes_.resize(static_cast<size_t>(count));
    for_solid([&](const Place& p, size_t e) {
        if (slot_[e] >= 0) slopes_[static_cast<size_t>(slot_[e])] = slope_of(p, e);
    });
    for_solid([&](const Place& p, size_t e) {
        if (slot_[e] < 0) {
            std::array<double, 6> strain;
            for (size_t i = 0; i < 6; ++i)
                strain[i] = static_cast<double>(centre_[e][i]);
            store(e, strain);
        } else {
            for (int corner = 0; corner < 8; ++corner)
                store(e, strain_at(p, e, corner));
            for (int face = 0; face < 6; ++face)
                store(e, strain_on(e, face));
        }
        // So that a file of safety factors has no infinities.
        constexpr double kMost = 1e6;
        if (v_.strength[e] > 0)
            out_.safety[e] = static_cast<float>(
                std::min(kMost, static_cast<double>(v_.strength[e]) /
                                    std::max(static_cast<double>(out_.von_mises_MPa[e]), 1e-30)));
    });
    return std::move(out_);
}

}  // namespace

PartFields fields_of(const PartProblem& problem, Field<double, kElastic>* moved) {
    return Stresses(problem, moved).run();
}

}  // namespace openfab::mechanics

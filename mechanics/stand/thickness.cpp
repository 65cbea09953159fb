// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/stand/thickness.h"

#include <algorithm>
#include <cmath>

#include "mechanics/solver/parallel.h"

namespace openfab::mechanics {

namespace {

constexpr double kFar = 1e30;

/// out[i] = min over j of f[j] + (h (i - j))^2, of n values.
class Parabolas {
  public:
    explicit Parabolas(int32_t n)
        : n_(n), v_(static_cast<size_t>(n)), z_(static_cast<size_t>(n) + 1) {}

    void run(const std::vector<double>& f, double h, std::vector<double>* out) {
        size_t k = 0;
        bool any = false;
        for (int32_t q = 0; q < n_; ++q) {
            if (f[static_cast<size_t>(q)] >= kFar) continue;
            if (!any) {
                v_[0] = q;
                z_[0] = -kFar;
                z_[1] = kFar;
                any = true;
                continue;
            }
            double s = meet(f, h, q, v_[k]);
            while (k > 0 && s <= z_[k])
                s = meet(f, h, q, v_[--k]);
            if (s <= z_[k]) {
                v_[k] = q;
                z_[k] = -kFar;
                z_[k + 1] = kFar;
                continue;
            }
            v_[++k] = q;
            z_[k] = s;
            z_[k + 1] = kFar;
        }
        if (!any) {
            std::fill(out->begin(), out->end(), kFar);
            return;
        }
        size_t at = 0;
        for (int32_t q = 0; q < n_; ++q) {
            while (z_[at + 1] < q)
                ++at;
            const double d = h * (q - v_[at]);
            (*out)[static_cast<size_t>(q)] = d * d + f[static_cast<size_t>(v_[at])];
        }
    }

  private:
    double meet(const std::vector<double>& f, double h, int32_t q, int32_t v) const {
        return ((f[static_cast<size_t>(q)] + h * h * q * q) -
                (f[static_cast<size_t>(v)] + h * h * v * v)) /
               (2 * h * h * (q - v));
    }
    int32_t n_;
    std::vector<int32_t> v_;
    std::vector<double> z_;
};

}  // namespace

std::vector<float> squared_depth(const Grid& g, std::span<const uint8_t> kind) {
    // With a border of void, so that the grid's faces are surface. Distances are to middles of elements
    // that are void, whose surface is half an element nearer.
    std::vector<float> out(kind.size());
    for (size_t e = 0; e < kind.size(); ++e)
        out[e] = kind[e] == kSolid ? static_cast<float>(kFar) : 0.F;
    const size_t stride[3] = {
        1, static_cast<size_t>(g.elements[0]),
        static_cast<size_t>(g.elements[0]) * static_cast<size_t>(g.elements[1])};
    for (size_t axis = 0; axis < 3; ++axis) {
        const int32_t n = g.elements[axis];
        const size_t a = (axis + 1) % 3, b = (axis + 2) % 3;
        for_each_index(g.elements[b], [&](int32_t j) {
            Parabolas parabolas(n + 2);
            std::vector<double> f(static_cast<size_t>(n) + 2), d(f.size());
            for (int32_t i = 0; i < g.elements[a]; ++i) {
                const size_t begin =
                    static_cast<size_t>(i) * stride[a] + static_cast<size_t>(j) * stride[b];
                f.front() = f.back() = 0;
                for (size_t k = 0; k < static_cast<size_t>(n); ++k)
                    f[k + 1] = static_cast<double>(out[begin + k * stride[axis]]);
                parabolas.run(f, g.pitch_mm[axis], &d);
                for (size_t k = 0; k < static_cast<size_t>(n); ++k)
                    out[begin + k * stride[axis]] = static_cast<float>(std::min(d[k + 1], kFar));
            }
        });
    }
    return out;
}

std::vector<ThinPlace> thinnest(const Grid& g, const Voxels& v, std::span<const uint8_t> kind,
                                size_t most) {
    const std::vector<float> depth = squared_depth(g, kind);
    const double pitch = *std::ranges::min_element(g.pitch_mm);
    std::vector<std::pair<float, int64_t>> ridges;
    for (int64_t e = 0; e < g.element_count(); ++e) {
        const float d = depth[static_cast<size_t>(e)];
        if (!(d > 0)) continue;
        const std::array<int32_t, 3> p = place_of(g, e);
        // A middle: along some axis the neighbours on both sides are nearer to the surface, or those of a
        // pair of equals are, in walls of an even number of elements; and none is deeper by as much as
        // a step away from a wall is.
        const double own = std::sqrt(static_cast<double>(d));
        const auto at = [&](size_t axis, int step) {
            std::array<int32_t, 3> q = p;
            q[axis] += step;
            return q[axis] < 0 || q[axis] >= g.elements[axis]
                       ? 0
                       : std::sqrt(static_cast<double>(depth[g.element(q[0], q[1], q[2])]));
        };
        bool across = false, deeper = false;
        double thickness = 1e300;
        for (size_t a = 0; a < 3; ++a) {
            const double low = at(a, -1), high = at(a, 1);
            deeper = deeper || std::max(low, high) > own + 0.3 * g.pitch_mm[a];
            const bool odd = low < own && high < own;
            const bool even = (low < own && high == own && at(a, 2) < own) ||
                              (high < own && low == own && at(a, -2) < own);
            if (!odd && !even) continue;
            across = true;
            thickness = std::min(thickness, 2 * own - (odd ? g.pitch_mm[a] : 0));
        }
        if (across && !deeper) ridges.emplace_back(static_cast<float>(thickness), e);
    }
    std::ranges::sort(ridges);
    double longest = 0;
    for (size_t a = 0; a < 3; ++a)
        longest = std::max(longest, g.elements[a] * g.pitch_mm[a]);
    const double apart = std::max(4 * pitch, 0.1 * longest);
    std::vector<ThinPlace> out;
    for (const auto& [thickness, e] : ridges) {
        if (out.size() == most) break;
        const std::array<int32_t, 3> p = place_of(g, e);
        ThinPlace place;
        bool far = true;
        for (size_t a = 0; a < 3; ++a)
            place.at_mm[a] = v.origin_mm[a] + (p[a] + 0.5) * g.pitch_mm[a];
        for (const ThinPlace& other : out)
            far =
                far && std::hypot(place.at_mm[0] - other.at_mm[0], place.at_mm[1] - other.at_mm[1],
                                  place.at_mm[2] - other.at_mm[2]) >= apart;
        if (!far) continue;
        place.thickness_mm = static_cast<double>(thickness);
        place.material = v.code[static_cast<size_t>(e)];
        out.push_back(place);
    }
    return out;
}

}  // namespace openfab::mechanics

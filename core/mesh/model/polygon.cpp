// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/model/polygon.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

#include "base/check.h"

namespace openfab::mesh {
namespace {

/// Twice the area vector (Newell).
Vec3d area_vector(const std::vector<Vec3d>& p) {
    Vec3d sum;
    for (size_t i = 1; i + 1 < p.size(); ++i)
        sum = sum + cross(p[i] - p[0], p[i + 1] - p[0]);
    return sum;
}

double turn(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& normal) {
    return dot(cross(b - a, c - a), normal);
}

/// The remaining corners of a polygon, and which of them are ears: convex ones without another
/// corner in their triangle. The result for a corner stays valid until one of its neighbours is
/// removed, or the corner in its triangle.
class Ring {
  public:
    Ring(const std::vector<Vec3d>& corners, const Vec3d& normal)
        : p_(corners), normal_(normal), left_(corners.size()), found_(corners.size()) {
        std::iota(left_.begin(), left_.end(), 0);
        gone_.resize(corners.size());
        sort_along();
    }

    size_t size() const { return left_.size(); }
    int32_t at(size_t i) const { return left_[i % left_.size()]; }

    bool is_ear(size_t i, int64_t* effort) {
        const int32_t own = at(i);
        const int32_t before = at(i + left_.size() - 1);
        const int32_t after = at(i + 1);
        Found& found = found_[own];
        if (found.before != before || found.after != after) {
            found = {before, after, 0, false};
            found.reflex = !(turn(corner(before), corner(own), corner(after), normal_) > 0);
            found.next = first_along(before, own, after);
        }
        if (found.reflex) return false;
        const Vec3d& a = corner(before);
        const Vec3d& b = corner(own);
        const Vec3d& c = corner(after);
        const double most = std::max({along(before), along(own), along(after)}) + slack_;
        for (; found.next < order_.size(); ++found.next) {
            const int32_t k = order_[found.next];
            if (along(k) > most) break;
            if (gone_[k]) continue;
            --*effort;
            const Vec3d& q = corner(k);
            if (q == a || q == b || q == c) continue;
            if (turn(a, b, q, normal_) >= 0 && turn(b, c, q, normal_) >= 0 &&
                turn(c, a, q, normal_) >= 0)
                return false;  // and tested first again, until it is removed
        }
        return true;
    }

    void cut(size_t i) {
        gone_[left_[i]] = true;
        left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(i));
    }

  private:
    struct Found {
        int32_t before = -1, after = -1;  ///< the neighbours that this is valid for
        size_t next = 0;                  ///< in order_: those before it are not in the triangle
        bool reflex = false;              ///< not convex
    };

    const Vec3d& corner(int32_t c) const { return p_[c]; }
    double along(int32_t c) const { return along_[c]; }

    /// Orders the corners along the longer of the two axes nearest to the polygon's plane: corners
    /// in a triangle are between its ends.
    void sort_along() {
        double longest = -1;
        for (int axis = 0; axis < 3; ++axis) {
            Vec3d e;
            e[axis] = 1;
            e = e - normal_ * (normal_[axis] / dot(normal_, normal_));
            std::vector<double> offsets;
            for (const Vec3d& q : p_)
                offsets.push_back(dot(q, e));
            const auto [lo, hi] = std::minmax_element(offsets.begin(), offsets.end());
            if (!(*hi - *lo > longest)) continue;
            longest = *hi - *lo;
            slack_ = 1e-9 * std::max({longest, std::fabs(*lo), std::fabs(*hi)});
            along_ = std::move(offsets);
        }
        along_.resize(p_.size());
        order_ = left_;
        std::sort(order_.begin(), order_.end(), [&](int32_t x, int32_t y) {
            return std::pair(along(x), x) < std::pair(along(y), y);
        });
    }
    size_t first_along(int32_t a, int32_t b, int32_t c) const {
        const double least = std::min({along(a), along(b), along(c)}) - slack_;
        return static_cast<size_t>(
            std::partition_point(order_.begin(), order_.end(),
                                 [&](int32_t k) { return along(k) < least; }) -
            order_.begin());
    }

    const std::vector<Vec3d>& p_;
    Vec3d normal_;
    std::vector<int32_t> left_;
    std::vector<Found> found_;   ///< by corner
    std::vector<bool> gone_;     ///< by corner
    std::vector<double> along_;  ///< by corner
    double slack_ = 0;           ///< bounds the rounding error of along_
    std::vector<int32_t> order_;
};

}  // namespace

std::vector<std::array<int32_t, 3>> triangulate(const std::vector<Vec3d>& corners,
                                                int64_t* effort) {
    const size_t n = corners.size();
    OPENFAB_CHECK_GE(n, 3u);
    std::vector<std::array<int32_t, 3>> out;
    const Vec3d normal = area_vector(corners);
    bool convex = true;
    for (size_t i = 0; i < n && n > 3; ++i) {
        convex =
            convex && turn(corners[i], corners[(i + 1) % n], corners[(i + 2) % n], normal) >= 0;
    }
    if (convex || normal == Vec3d{}) {
        for (size_t i = 1; i + 1 < n; ++i) {
            out.push_back({0, static_cast<int32_t>(i), static_cast<int32_t>(i + 1)});
        }
        return out;
    }
    Ring ring(corners, normal);
    while (ring.size() > 3) {
        size_t ear = 0;
        while (ear < ring.size() && *effort > 0 && !ring.is_ear(ear, effort))
            ++ear;
        *effort -= static_cast<int64_t>(ear / 4);  // corners that needed no new test
        if (*effort <= 0) return {};
        // A polygon that crosses itself may have none left; any cut keeps the mesh closed.
        if (ear == ring.size()) ear = 0;
        out.push_back({ring.at(ear + ring.size() - 1), ring.at(ear), ring.at(ear + 1)});
        ring.cut(ear);
    }
    out.push_back({ring.at(0), ring.at(1), ring.at(2)});
    return out;
}

}  // namespace openfab::mesh

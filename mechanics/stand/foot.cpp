// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/stand/foot.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

namespace openfab::mechanics {

namespace {

using FootPoint = std::array<double, 2>;

/// How far something reaches from the centre of mass along a direction, at the middles of the lowest layers.
struct Reach {
    FootPoint along;
    std::vector<double> out, back;  ///< mm; `back` against the direction
};

/// A straight line through values at the middles of layers, over a function of their heights in layers.
struct Fit {
    double ground = 0, slope = 0;
    double at(double x) const { return ground + slope * x; }
};
template <typename Y, typename X>
Fit fit(size_t n, const Y& y, const X& x_of) {
    double mean_x = 0, mean_y = 0, xx = 0, xy = 0;
    const auto x = [&](size_t k) { return x_of(static_cast<double>(k) + 0.5); };
    for (size_t k = 0; k < n; ++k) {
        mean_x += x(k) / static_cast<double>(n);
        mean_y += y(k) / static_cast<double>(n);
    }
    for (size_t k = 0; k < n; ++k) {
        xx += (x(k) - mean_x) * (x(k) - mean_x);
        xy += (x(k) - mean_x) * (y(k) - mean_y);
    }
    Fit out;
    out.slope = xx > 0 ? xy / xx : 0;
    out.ground = mean_y - out.slope * mean_x;
    return out;
}

double same(double z) {
    return z;
}
double root(double z) {
    return std::sqrt(std::max(0.0, z));
}

/// Where something that grows begins at the ground: straight, as edges and slopes do, or as a fillet does, with the
/// root of the height. It is not further out than its first layer.
double at_ground(const std::vector<double>& y, size_t n) {
    const auto of = [&](size_t k) { return y[k]; };
    const Fit straight = fit(n, of, same), round = fit(n, of, root);
    double better = 0;
    for (size_t k = 0; k < n; ++k) {
        const double z = static_cast<double>(k) + 0.5;
        better += std::pow(y[k] - straight.at(z), 2) - std::pow(y[k] - round.at(root(z)), 2);
    }
    return std::min(y[0], better <= 0 ? straight.ground : round.ground);
}

class FootLook {
  public:
    FootLook(const FootLayers& layers, const FootPoint& centre, double height)
        : l_(layers), centre_(centre), height_(height) {}

    Foot run();

  private:
    void find_hulls();
    void find_reaches();
    /// Layers that go on as one convex body does: at a step above a low foot another one begins.
    size_t alike() const;
    /// Whether what is along a direction has no width at the ground, as an edge, a tip and what is round.
    bool is_pointed(const Reach& r, size_t n) const;
    /// By how much the place of a side is off at the ground: by a voxel, and by a part of a layer, in which what is
    /// steep grows little and what is round much.
    double error(const std::vector<double>& y, size_t n) const {
        return std::max(l_.pitch_mm[0], l_.pitch_mm[1]) + (n > 1 ? 0.25 * (y[1] - y[0]) : 0);
    }
    /// The radius of what is round along a direction: w^2 + z^2 = 2 R z.
    double radius(const Reach& r, size_t n) const;

    const FootLayers& l_;
    FootPoint centre_;
    double height_;
    std::vector<std::vector<FootPoint>>
        hulls_;  ///< of each layer and those below it, from the first on
    std::vector<Reach> reaches_;
};

void FootLook::find_hulls() {
    const auto nx = static_cast<size_t>(l_.size[0]), ny = static_cast<size_t>(l_.size[1]);
    std::vector<FootPoint> points;
    for (size_t z = 0; z < static_cast<size_t>(l_.size[2]); ++z) {
        for (size_t y = 0; y < ny; ++y) {
            const auto row = l_.inside.begin() + static_cast<std::ptrdiff_t>((z * ny + y) * nx);
            const auto end = row + static_cast<std::ptrdiff_t>(nx);
            // The first and the last of a row have the hull.
            const auto first = std::find_if(row, end, [](uint8_t c) { return c != 0; });
            if (first == end) continue;
            auto last = end;
            while (*--last == 0) {
            }
            // Middles of sides: a corner of a voxel stands out of what is slanted.
            const double at = l_.origin_mm[1] + (static_cast<double>(y) + 0.5) * l_.pitch_mm[1];
            for (const auto& [from, step] : {std::pair(first, 0.0), {last, 1.0}}) {
                const double x = l_.origin_mm[0] + static_cast<double>(from - row) * l_.pitch_mm[0];
                points.push_back({x + step * l_.pitch_mm[0], at});
                for (const double half : {-0.5, 0.5})
                    points.push_back({x + 0.5 * l_.pitch_mm[0], at + half * l_.pitch_mm[1]});
            }
        }
        if (points.empty()) continue;
        points = convex_hull(std::move(points));
        hulls_.push_back(points);
        if (hulls_.size() == kFootLayers) break;
    }
}

void FootLook::find_reaches() {
    constexpr int kAround = 72;
    std::vector<FootPoint> all;
    for (int i = 0; i < kAround; ++i) {
        // A quarter's directions turned, so that those along axes are exact.
        const double angle = (i % (kAround / 4)) * 2 * std::numbers::pi / kAround;
        FootPoint u{std::cos(angle), std::sin(angle)};
        for (int turn = 0; turn < i / (kAround / 4); ++turn)
            u = {-u[1], u[0]};
        all.push_back(u);
    }
    for (const std::vector<FootPoint>* hull : {&hulls_.front(), &hulls_.back()})
        for (size_t i = 0; i < hull->size(); ++i) {
            const FootPoint &a = (*hull)[i], &b = (*hull)[(i + 1) % hull->size()];
            const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
            // An edge of a few voxels has no direction of its own.
            if (length > 4 * (l_.pitch_mm[0] + l_.pitch_mm[1]))
                all.push_back({(b[1] - a[1]) / length, -(b[0] - a[0]) / length});
        }
    for (const FootPoint& u : all) {
        Reach r{u, {}, {}};
        for (const std::vector<FootPoint>& hull : hulls_) {
            double most = -std::numeric_limits<double>::infinity(), least = -most;
            for (const FootPoint& p : hull) {
                const double s = u[0] * (p[0] - centre_[0]) + u[1] * (p[1] - centre_[1]);
                most = std::max(most, s);
                least = std::min(least, s);
            }
            r.out.push_back(most);
            r.back.push_back(-least);
        }
        reaches_.push_back(std::move(r));
    }
}

size_t FootLook::alike() const {
    const double slack = 2 * std::max(l_.pitch_mm[0], l_.pitch_mm[1]);
    for (size_t k = 1; k < hulls_.size(); ++k)
        for (const Reach& r : reaches_) {
            const double before = r.out[k - 1] + r.back[k - 1], now = r.out[k] + r.back[k];
            const double z = static_cast<double>(k) + 0.5;
            if (now > before * z / (z - 1) + slack) return k;
        }
    return hulls_.size();
}

double FootLook::radius(const Reach& r, size_t n) const {
    double zz = 0, zw = 0;
    for (size_t k = 0; k < n; ++k) {
        const double z = (static_cast<double>(k) + 0.5) * l_.pitch_mm[2],
                     w = (r.out[k] + r.back[k]) / 2;
        zz += 2 * z * z;
        zw += z * (w * w + z * z);
    }
    return zw / zz;
}

bool FootLook::is_pointed(const Reach& r, size_t n) const {
    // The square of the width of what is round grows evenly, but for that of the height; the width of an edge does.
    const double layer = 2 * l_.pitch_mm[2];
    const auto width = [&](size_t k) { return r.out[k] + r.back[k]; };
    const auto square = [&](size_t k) {
        const double z = (static_cast<double>(k) + 0.5) * layer;
        return width(k) * width(k) + z * z;
    };
    const Fit straight = fit(n, width, same), round = fit(n, square, same);
    double better = 0;
    for (size_t k = 0; k < n; ++k) {
        const double z = static_cast<double>(k) + 0.5;
        better += std::pow(width(k) - straight.at(z), 2) -
                  std::pow(width(k) - root(round.at(z) - z * z * layer * layer), 2);
    }
    // Where in its first layer it begins is not known.
    return better <= 0 ? straight.ground <= 1.5 * (error(r.out, n) + error(r.back, n))
                       : round.ground <= round.slope;
}

Foot FootLook::run() {
    Foot out;
    out.error_mm = std::max(l_.pitch_mm[0], l_.pitch_mm[1]);
    find_hulls();
    if (hulls_.empty()) return out;
    find_reaches();
    const size_t n = alike();
    out.margin_mm = out.round_mm = std::numeric_limits<double>::infinity();
    FootPoint sharpest{};
    bool pointed = false, at_edge = false, outside = false;
    for (const Reach& r : reaches_) {
        double ground = at_ground(r.out, n);
        const double off = error(r.out, n);
        if (is_pointed(r, n)) {
            pointed = true;
            if (const double round = radius(r, n); round < out.round_mm) {
                out.round_mm = round;
                sharpest = r.along;
            }
            // Its middle; above it is balanced on what it stands on, however high.
            ground = (ground - at_ground(r.back, n)) / 2;
            if (ground >= -off) continue;
        } else if (std::abs(ground) <= off) {
            at_edge = true;
        }
        outside = outside || ground < -off;
        if (ground >= out.margin_mm) continue;
        out.margin_mm = ground;
        out.error_mm = off;
        out.towards = r.along;
    }
    constexpr size_t kFewest = 3;
    constexpr double kLow = 0.93;  // of the radius, which is right within a few hundredths
    if (outside)
        out.kind = Foot::Kind::kFalls;
    else if (n < kFewest || at_edge)
        out.kind = Foot::Kind::kNotResolved;
    else if (!pointed)
        out.kind = Foot::Kind::kStands;
    else
        out.kind = height_ > kLow * out.round_mm ? Foot::Kind::kRolls : Foot::Kind::kRocks;
    if (out.kind == Foot::Kind::kRolls || out.kind == Foot::Kind::kRocks) {
        out.margin_mm = 0;
        out.towards = sharpest;
    } else {
        out.round_mm = 0;
    }
    return out;
}

}  // namespace

std::vector<FootPoint> convex_hull(std::vector<FootPoint> p) {
    std::ranges::sort(p);
    p.erase(std::ranges::unique(p).begin(), p.end());
    if (p.size() < 3) return p;
    const auto left = [](const FootPoint& a, const FootPoint& b, const FootPoint& c) {
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    };
    std::vector<FootPoint> out(2 * p.size());
    size_t k = 0;
    for (const FootPoint& one : p) {
        while (k >= 2 && left(out[k - 2], out[k - 1], one) <= 0)
            --k;
        out[k++] = one;
    }
    const size_t lower = k + 1;
    for (size_t i = p.size() - 1; i-- > 0;) {
        while (k >= lower && left(out[k - 2], out[k - 1], p[i]) <= 0)
            --k;
        out[k++] = p[i];
    }
    out.resize(k - 1);
    return out;
}

Foot foot_of(const FootLayers& layers, const std::array<double, 2>& centre_mm, double height_mm) {
    return FootLook(layers, centre_mm, height_mm).run();
}

}  // namespace openfab::mechanics

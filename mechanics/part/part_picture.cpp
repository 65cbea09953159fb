// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/part/part_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mechanics/model/picture.h"
#include "mechanics/part/shown.h"

namespace openfab::mechanics {

namespace {

constexpr int32_t kWidth = 900, kHeight = 640, kBar = 150, kMargin = 40;

struct Point {
    double x = 0, y = 0, depth = 0;
};

/// A parallel view from a direction, z up.
class View {
  public:
    explicit View(const PictureOptions& o)
        : turn_(o.turn_deg * std::numbers::pi / 180), tilt_(o.tilt_deg * std::numbers::pi / 180) {}

    /// In mm, y down, the nearer the larger depth.
    Point of(const Vec3& p) const {
        const double x = p[0] * std::cos(turn_) + p[1] * std::sin(turn_);
        const double back = -p[0] * std::sin(turn_) + p[1] * std::cos(turn_);
        return {x, -(p[2] * std::cos(tilt_) + back * std::sin(tilt_)),
                p[2] * std::sin(tilt_) - back * std::cos(tilt_)};
    }

  private:
    double turn_, tilt_;
};

class Canvas {
  public:
    explicit Canvas(Picture* picture)
        : picture_(*picture), depth_(static_cast<size_t>(kWidth * kHeight), -1e300) {}

    void triangle(const Point& a, const Point& b, const Point& c, Colour colour) {
        const double area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
        if (std::abs(area) < 1e-12) return;
        const auto low = [](double v, int32_t most) {
            return static_cast<int32_t>(std::clamp(std::floor(v), 0.0, double(most)));
        };
        const int32_t x0 = low(std::min({a.x, b.x, c.x}), kWidth - 1);
        const int32_t x1 = low(std::max({a.x, b.x, c.x}) + 1, kWidth - 1);
        const int32_t y0 = low(std::min({a.y, b.y, c.y}), kHeight - 1);
        const int32_t y1 = low(std::max({a.y, b.y, c.y}) + 1, kHeight - 1);
        for (int32_t y = y0; y <= y1; ++y)
            for (int32_t x = x0; x <= x1; ++x) {
                const double u = ((x - a.x) * (c.y - a.y) - (c.x - a.x) * (y - a.y)) / area;
                const double v = ((b.x - a.x) * (y - a.y) - (x - a.x) * (b.y - a.y)) / area;
                constexpr double kEdge = -1e-3;  // so that neighbours leave no gap
                if (u < kEdge || v < kEdge || u + v > 1 - kEdge) continue;
                const double d = a.depth + u * (b.depth - a.depth) + v * (c.depth - a.depth);
                double& there = depth_[static_cast<size_t>(y * kWidth + x)];
                if (d <= there) continue;
                there = d;
                picture_.put(x, y, colour);
            }
    }

  private:
    Picture& picture_;
    std::vector<double> depth_;
};

}  // namespace

std::vector<uint8_t> part_picture(const PartProblem& problem, const PartFields& fields,
                                  const Field<double, kElastic>& moved,
                                  const PictureOptions& options) {
    const Grid& g = problem.grid;
    const View view(options);
    const std::vector<Face> surface = surface_of(g, problem.elements.kind);
    double longest = 0, most_moved = 0;
    for (size_t a = 0; a < 3; ++a)
        longest = std::max(longest, g.elements[a] * g.pitch_mm[a]);
    for (const Face& f : surface)
        for (const int64_t node : nodes_of(g, f)) {
            const Vec3 u = moved_at(moved, node);
            most_moved = std::max(most_moved, std::hypot(u[0], u[1], u[2]));
        }
    // What a face is sheared or stretched by: a soft sole that is shown too thin would show its other side.
    double most_strained = 0;
    const double pitch = *std::ranges::min_element(g.pitch_mm);
    for (const Face& f : surface) {
        const std::array<int64_t, 4> n = nodes_of(g, f);
        const Vec3 first = moved_at(moved, n[0]);
        for (size_t k = 1; k < 4; ++k) {
            const Vec3 u = moved_at(moved, n[k]);
            const double far = std::hypot(u[0] - first[0], u[1] - first[1], u[2] - first[2]);
            most_strained = std::max(most_strained, far / pitch);
        }
    }
    // Moved by a twelfth of the part, so that it is seen; never less than it is.
    constexpr double kStrained = 0.5;
    const double factor =
        most_moved > 0
            ? std::max(1.0, std::min(longest / 12 / most_moved, kStrained / most_strained))
            : 0;
    const Shown shown = shown_of(problem, fields, moved, options.show);

    // The frame holds the part as it is and as it is moved.
    const auto node_at = [&](int64_t node, double by) {
        const Vec3 u = by != 0 ? moved_at(moved, node) : Vec3{};
        return Vec3{
            static_cast<double>(node % g.nodes[0]) * g.pitch_mm[0] + by * u[0],
            static_cast<double>(node / g.nodes[0] % g.nodes[1]) * g.pitch_mm[1] + by * u[1],
            static_cast<double>(node / g.nodes[0] / g.nodes[1]) * g.pitch_mm[2] + by * u[2]};
    };
    Point low{1e300, 1e300}, high{-1e300, -1e300};
    for (const Face& f : surface)
        for (const int64_t node : nodes_of(g, f))
            for (const double by : {0.0, factor}) {
                const Point p = view.of(node_at(node, by));
                low = {std::min(low.x, p.x), std::min(low.y, p.y)};
                high = {std::max(high.x, p.x), std::max(high.y, p.y)};
            }
    const double scale = std::min((kWidth - kBar - 2 * kMargin) / std::max(high.x - low.x, 1e-9),
                                  (kHeight - 2 * kMargin - 30) / std::max(high.y - low.y, 1e-9));
    const double left = (kWidth - kBar - scale * (high.x - low.x)) / 2;
    const double top = 30 + (kHeight - 30 - scale * (high.y - low.y)) / 2;
    const auto screen = [&](int64_t node, double by) {
        Point p = view.of(node_at(node, by));
        p.x = left + scale * (p.x - low.x);
        p.y = top + scale * (p.y - low.y);
        return p;
    };
    Picture picture(kWidth, kHeight);
    Canvas canvas(&picture);
    std::vector<int64_t> held;
    for (const Held& h : problem.held)
        held.push_back(h.dof / 3);
    constexpr double kLight[6] = {0.78, 0.9, 0.86, 0.72, 0.6, 1.0};
    for (const Face& f : surface) {
        const std::array<int64_t, 4> n = nodes_of(g, f);
        const bool fixed = std::ranges::all_of(
            n, [&](int64_t node) { return std::ranges::binary_search(held, node); });
        Colour colour =
            fixed ? Colour{150, 150, 150}
                  : shown.colour(static_cast<double>(shown.values[static_cast<size_t>(f.element)]));
        for (uint8_t& c : colour)
            c = static_cast<uint8_t>(c * kLight[f.direction]);
        const Point p[4] = {screen(n[0], factor), screen(n[1], factor), screen(n[2], factor),
                            screen(n[3], factor)};
        canvas.triangle(p[0], p[1], p[3], colour);
        canvas.triangle(p[0], p[3], p[2], colour);
    }
    const int32_t x = kWidth - kBar + 10;
    for (int32_t y = 60; y < kHeight - 60; ++y) {
        const double t = 1 - (y - 60.0) / (kHeight - 120.0);
        for (int32_t i = 0; i < 24; ++i)
            picture.put(x + i, y, shown.colour(shown.least + t * (shown.most - shown.least)));
    }
    for (int i = 0; i <= 4; ++i)
        picture.text(x + 32, 60 + (kHeight - 120) * (4 - i) / 4 - 7,
                     short_number(shown.least + (shown.most - shown.least) * i / 4), {40, 40, 40});
    const std::string what = shown.name == "displacement" ? "moved by mm"
                             : shown.name == "safety"     ? "safety factor"
                                                          : shown.name + " " + shown.unit;
    picture.text(20, 16,
                 options.title.empty()
                     ? fmt::format("{} - moved {} times as far", what, short_number(factor))
                     : options.title,
                 {40, 40, 40});
    return picture.png();
}

}  // namespace openfab::mechanics

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "pieces/collide.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace openfab::pieces {

namespace {

/// A stroke with thickness: a stadium along n.
struct Stroke {
    const Shape& of;
    std::array<double, 4> ends;

    Vec3d nearest(const Vec3d& p) const {
        const Vec3d d = p - of.at;
        const double x = dot(d, of.u), y = dot(d, of.v);
        const double du = ends[2] - ends[0], dv = ends[3] - ends[1];
        const double size = du * du + dv * dv;
        const double t =
            size > 0 ? std::clamp(((x - ends[0]) * du + (y - ends[1]) * dv) / size, 0.0, 1.0) : 0;
        const double on_x = ends[0] + t * du, on_y = ends[1] + t * dv;
        const double flat = std::hypot(x - on_x, y - on_y);
        const double by = flat > of.radius ? of.radius / flat : 1;
        return of.at + of.u * (on_x + (x - on_x) * by) + of.v * (on_y + (y - on_y) * by) +
               of.n * std::clamp(dot(d, of.n), of.lo, of.hi);
    }
    Vec3d farthest(const Vec3d& direction) const {
        const double x = dot(direction, of.u), y = dot(direction, of.v);
        const double flat = std::hypot(x, y), by = flat > 0 ? of.radius / flat : 0;
        const bool second = x * ends[2] + y * ends[3] > x * ends[0] + y * ends[1];
        return of.at + of.u * (ends[second ? 2 : 0] + x * by) +
               of.v * (ends[second ? 3 : 1] + y * by) +
               of.n * (dot(direction, of.n) > 0 ? of.hi : of.lo);
    }
};

/// Of convex bodies: nearest points in turn; the plane between them bounds the distance from below.
template <typename A, typename B>
double distance_of_convex(const A& a, const B& b, const Vec3d& begin) {
    constexpr int kMost = 400;
    constexpr double kGap_mm = 1e-4;
    Vec3d on = b.nearest(begin);
    double below = 0;
    for (int i = 0; i < kMost; ++i) {
        const Vec3d in = a.nearest(on);
        on = b.nearest(in);
        const Vec3d away = on - in;
        const double size = length(away);
        if (size < 1e-9) return 0;
        const Vec3d d = away * (1 / size);
        below = std::max(below, dot(d, b.farthest(d * -1.0)) - dot(d, a.farthest(d)));
        if (size - below < kGap_mm) break;
    }
    return below;
}

/// Calls `with` for each of the convex bodies that a shape consists of.
template <typename With>
void for_convex(const Shape& shape, const With& with) {
    if (shape.kind != Shape::Kind::kStrokes) return with(shape);
    for (const auto& ends : shape.strokes)
        with(Stroke{shape, ends});
}

std::string place_of(const SourceLocation& location) {
    return location.line > 0 ? fmt::format(" of {}:{}", location.line, location.column) : "";
}

}  // namespace

double distance(const Shape& a, const Shape& b) {
    double least = 1e300;
    const Vec3d begin = a.at + a.n * (a.hi / 2);
    for_convex(a, [&](const auto& one) {
        for_convex(b, [&](const auto& other) {
            least = std::min(least, distance_of_convex(one, other, begin));
        });
    });
    return least;
}

std::string collision(const Region& region, SourceLocation* location) {
    constexpr double kSlack_mm = 1e-3;
    // Nothing where they are far apart.
    const auto near = [](const Shape& one, const Shape& other, double wanted) {
        const Vec3d grow{wanted, wanted, wanted};
        const Box3d box = one.box();
        return other.box().overlaps({box.lo - grow, box.hi + grow});
    };
    std::vector<Shape> numbers;
    for (const Shape& shape : region.removed) {
        if (shape.kind != Shape::Kind::kStrokes) continue;
        const Shape number = shape.upper();
        for (const Shape& other : numbers) {
            if (near(number, other, 0) && !(distance(number, other) > 0))
                return fmt::format("two numbers of piece `{}` run into each other", region.name);
        }
        numbers.push_back(number);
    }
    for (size_t i = 0; i < region.fits.size(); ++i) {
        const Fit& one = region.fits[i];
        const Shape shape = one.shape.upper();
        *location = one.location;
        for (const Shape& number : numbers) {
            if (near(shape, number, 0) && !(distance(shape, number) > 0))
                return fmt::format("{} runs into a number in piece `{}`", one.what, region.name);
        }
        for (size_t j = 0; j < i; ++j) {
            const Fit& other = region.fits[j];
            const double wanted = std::min(one.skin_mm, other.skin_mm);
            const Shape of = other.shape.upper();
            if (!near(shape, of, wanted)) continue;
            const double least = distance(shape, of);
            if (least > 0 && least >= wanted - kSlack_mm) continue;
            return least > 0 ? fmt::format(
                                   "{} is {:.3g} mm from {}{} in piece `{}`, and {:.3g} mm "
                                   "are asked for",
                                   one.what, least, other.what, place_of(other.location),
                                   region.name, wanted)
                             : fmt::format("{} runs into {}{} in piece `{}`", one.what, other.what,
                                           place_of(other.location), region.name);
        }
    }
    return {};
}

}  // namespace openfab::pieces

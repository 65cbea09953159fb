// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/render/skin.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace openfab::render {

namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr double kLeastStep = 1e-200;

double interpolate(const std::array<int32_t, 8>& c, double x, double y, double z) {
    const auto along = [&](size_t i) { return c[i] + x * (c[i + 1] - c[i]); };
    const double low = along(0) + y * (along(2) - along(0));
    const double high = along(4) + y * (along(6) - along(4));
    return low + z * (high - low);
}

/// Steps of a ray through a grid of boxes. Directions are random, so that branches on them would be guessed wrong.
struct Steps {
    Vec3i at;    ///< the box; no number of it is negative, but of one that the ray left the grid to
    Vec3i ways;  ///< +1 or -1
    Vec3d next;  ///< where the ray leaves it along each axis, in mm
    Vec3d apart;  ///< from there to where it leaves the next
    Vec3d speed;  ///< boxes per mm

    /// From `t` on; the boxes are `side` voxels wide, the first begins at `origin` along each axis.
    Steps(const Ray& ray, double t, double origin, double side) {
        for (int a = 0; a < 3; ++a) {
            const double step = ray.step[a] != 0 ? ray.step[a] : kLeastStep;
            const double place = (ray.at[a] + ray.step[a] * t - origin) / side;
            at[a] = static_cast<int32_t>(place);
            const bool is_up = step > 0;
            ways[a] = is_up ? 1 : -1;
            // On its border it is the box ahead.
            at[a] -= static_cast<int32_t>(!is_up) & static_cast<int32_t>(at[a] == place);
            const double inverse = 1 / step;
            next[a] = ((at[a] + (is_up ? 1 : 0)) * side + origin - ray.at[a]) * inverse;
            apart[a] = std::abs(inverse) * side;
            speed[a] = std::abs(step) / side;
        }
    }
    /// Where the ray leaves this box and up to `more` further ones along each axis.
    double leaves(const Vec3i& more) const {
        return std::min(
            {next.x + apart.x * more.x, next.y + apart.y * more.y, next.z + apart.z * more.z});
    }
    /// Goes on to the box that begins at `t`, which leaves() gave.
    void go_on(double t) {
        for (int a = 0; a < 3; ++a) {
            const double beyond = (t - next[a]) * speed[a];
            const int32_t passed = beyond >= 0 ? static_cast<int32_t>(beyond) + 1 : 0;
            at[a] += ways[a] * passed;
            next[a] += apart[a] * passed;
        }
    }
};

}  // namespace

Skin::Skin(const Volume* volume) : volume_(*volume), clearances_(*volume) {
    const Vec3i blocks = volume_.blocks();
    constexpr int32_t kGroup = Volume::kGroup;
    group_count_ = {blocks.x / kGroup, blocks.y / kGroup, blocks.z / kGroup};
    is_void_.assign(index_in(group_count_, {0, 0, group_count_.z}), 1);
    for (int32_t z = 0; z < blocks.z; ++z) {
        for (int32_t y = 0; y < blocks.y; ++y) {
            for (int32_t x = 0; x < blocks.x; ++x) {
                if (clearances_.kind({x, y, z}) != Clearances::Kind::kOutside)
                    is_void_[index_in(group_count_, {x / kGroup, y / kGroup, z / kGroup})] = 0;
            }
        }
    }
    const Vec3d mm = volume_.pitch_mm();
    per_mm_ = {1 / mm.x, 1 / mm.y, 1 / mm.z};
    apart_mm_ = 1e-5 * std::min({mm.x, mm.y, mm.z});
}

double Skin::enter(const Ray& ray) const {
    double from = 0;
    double to = kFar;
    for (int a = 0; a < 3; ++a) {
        const double side = volume_.blocks()[a] * Volume::kSide;
        if (ray.step[a] == 0) {
            if (ray.at[a] < 0 || ray.at[a] >= side) return kFar;
            continue;
        }
        const double low = -ray.at[a] / ray.step[a];
        const double high = (side - ray.at[a]) / ray.step[a];
        from = std::max(from, std::min(low, high));
        to = std::min(to, std::max(low, high));
    }
    return from < to ? from : kFar;
}

double Skin::coverage(const Vec3d& at) const {
    const double x = std::floor(at.x - 0.5);
    const double y = std::floor(at.y - 0.5);
    const double z = std::floor(at.z - 0.5);
    return interpolate(
        volume_.corners(static_cast<int32_t>(x), static_cast<int32_t>(y), static_cast<int32_t>(z)),
        at.x - 0.5 - x, at.y - 0.5 - y, at.z - 0.5 - z);
}

Vec3d Skin::slope(const Vec3d& at) const {
    const double fx = std::floor(at.x - 0.5);
    const double fy = std::floor(at.y - 0.5);
    const double fz = std::floor(at.z - 0.5);
    const std::array<int32_t, 8> c = volume_.corners(
        static_cast<int32_t>(fx), static_cast<int32_t>(fy), static_cast<int32_t>(fz));
    const double x = at.x - 0.5 - fx;
    const double y = at.y - 0.5 - fy;
    const double z = at.z - 0.5 - fz;
    const auto blend = [](double a, double b, double t) { return a + t * (b - a); };
    const auto d = [&](size_t i, size_t j) { return static_cast<double>(c[j] - c[i]); };
    return {blend(blend(d(0, 1), d(2, 3), y), blend(d(4, 5), d(6, 7), y), z) * per_mm_.x,
            blend(blend(d(0, 2), d(1, 3), x), blend(d(4, 6), d(5, 7), x), z) * per_mm_.y,
            blend(blend(d(0, 4), d(1, 5), x), blend(d(2, 6), d(3, 7), x), y) * per_mm_.z};
}

Vec3d Skin::smooth_slope(const Vec3d& at) const {
    Vec3d out;
    for (int a = 0; a < 3; ++a) {
        Vec3d high = at;
        Vec3d low = at;
        high[a] += 1;
        low[a] -= 1;
        out[a] = (coverage(high) - coverage(low)) * 0.5 * per_mm_[a];
    }
    return out;
}

/// Finds where, between two distances, the coverage passes to the other side.
bool Skin::find(const Ray& ray, double from, double to, double* where) const {
    Steps dual(ray, from, 0.5, 1);
    const auto is_wrong = [&](double coverage) {
        return (coverage >= Volume::kSurface) != ray.inside;
    };
    const int32_t of_side = ray.inside ? 0 : Clearances::kVoid;
    for (double begin = from;;) {
        const Vec3i low = dual.at;
        const Clearances::Clearance here = clearances_.at(low.x, low.y, low.z);
        const int32_t clearance = here.value - of_side;
        // Those that are all on the ray's side have no surface: they are passed together.
        const bool is_clear = clearance >= 1 && clearance <= Clearances::kMost;
        Vec3i more;
        for (int a = 0; a < 3; ++a) {
            const int32_t in_block = dual.ways[a] > 0 ? 7 - (low[a] & 7) : low[a] & 7;
            more[a] = !is_clear ? 0 : here.is_of_block ? in_block : clearance - 1;
        }
        const double leaves = dual.leaves(more);
        if (!is_clear) {
            const double end = std::min(std::max(begin, leaves), to);
            const std::array<int32_t, 8> c = volume_.corners(low.x, low.y, low.z);
            const auto value = [&](double t) {
                const Vec3d q = ray.at + ray.step * t;
                return interpolate(c, q.x - (low.x + 0.5), q.y - (low.y + 0.5),
                                   q.z - (low.z + 0.5));
            };
            if (is_wrong(value(end))) {
                double right = begin;
                double wrong = end;
                for (int i = 0; i < 40 && !is_wrong(value(right)); ++i) {
                    const double half = 0.5 * (right + wrong);
                    (is_wrong(value(half)) ? wrong : right) = half;
                    if (wrong - right < apart_mm_ * 1e-3) break;
                }
                *where = right;
                return true;
            }
        }
        if (leaves >= to) return false;
        begin = std::max(begin, leaves);
        dual.go_on(leaves);
    }
}

bool Skin::walk(double most_mm, Ray* ray) const {
    double t = enter(*ray);
    if (t < most_mm) {
        Steps groups(*ray, t, 0, Volume::kGroup * Volume::kSide);
        for (int a = 0; a < 3; ++a)
            groups.at[a] = std::clamp(groups.at[a], 0, group_count_[a] - 1);
        double searched_from = -1;
        for (bool is_last = false; !is_last;) {
            const bool is_searched = is_void_[index_in(group_count_, groups.at)] == 0;
            if (is_searched && searched_from < 0) searched_from = t;
            const double leaves = groups.leaves({0, 0, 0});
            t = std::min(std::max(t, leaves), most_mm);
            groups.go_on(leaves);
            is_last = t == most_mm;
            for (int a = 0; a < 3; ++a)
                is_last = is_last || groups.at[a] < 0 || groups.at[a] >= group_count_[a];
            // Groups that may have a surface are searched together where they follow each other.
            if (searched_from < 0 || (!is_last && is_void_[index_in(group_count_, groups.at)] == 0))
                continue;
            double surface = 0;
            if (find(*ray, searched_from, t, &surface)) {
                ray->at = ray->at + ray->step * surface;
                return true;
            }
            searched_from = -1;
        }
    }
    ray->at = ray->at + ray->step * std::min(most_mm, 1e9);
    return false;
}

}  // namespace openfab::render

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What find_thin is, word by word: every ball at every place where its centre may lie, every way from every voxel.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <queue>
#include <utility>
#include <vector>

#include "tools/inspection/bits.h"
#include "tools/inspection/thickness.h"

namespace openfab::inspection {

class OpeningTwin {
  public:
    /// Centres of balls lie on voxel centres alone, or on all halves of voxels.
    OpeningTwin(const Bits& bits, int outside, const Vec3d& pitch, double diameter, bool halves)
        : bits_(bits), outside_(outside), pitch_(pitch), radius_(diameter / 2), halves_(halves) {
        for (int axis = 0; axis < 3; ++axis) {
            coarse_ = std::max(coarse_, pitch[axis]);
            // Balls have their centres beyond the box where it is set there.
            beyond_[axis] = outside != 0 ? static_cast<int32_t>(radius_ / pitch[axis]) + 2 : 1;
        }
        for_box(margin_, [&](const Vec3i& p) {
            if (!set(p)) others_.push_back(place(p));
        });
        for_box(beyond_, [&](const Vec3i& p) {
            for (int half = 0; half < (halves_ ? 8 : 1); ++half) {
                const Vec3d at =
                    place(p) + Vec3d{(half & 1) * 0.5 * pitch_.x, (half >> 1 & 1) * 0.5 * pitch_.y,
                                     (half >> 2) * 0.5 * pitch_.z};
                const double deep = depth(at);
                if (deep > 0) deep_.emplace_back(deep, at);
            }
        });
    }

    /// By voxel: 1 where balls of a radius leave it, 2 where it is no edge besides.
    Box<uint8_t> thin() {
        Box<uint8_t> out(bits_.size);
        const std::vector<bool> left = rest(radius_);
        size_t at = 0;
        for_box(margin_, [&](const Vec3i& p) {
            if (left[at++] && bits_.holds(p.x, p.y, p.z)) out.values[bits_.at(p.x, p.y, p.z)] = 1;
        });
        mark(radius_, &out);
        for (double r = radius_ * std::sqrt(0.5); r >= 1.5 * coarse_; r *= std::sqrt(0.5))
            mark(r, &out);
        return out;
    }

    bool set(const Vec3i& p) const {
        return bits_.holds(p.x, p.y, p.z) ? bits_.values[bits_.at(p.x, p.y, p.z)] != 0
                                          : outside_ != 0;
    }
    double depth(const Vec3d& at) const {
        double least = 1e300;
        for (const Vec3d& other : others_)
            least = std::min(least, dot(other - at, other - at));
        return std::sqrt(least);
    }
    Vec3d place(const Vec3i& p) const { return {p.x * pitch_.x, p.y * pitch_.y, p.z * pitch_.z}; }

    /// Whether balls fit at voxels that are as far from a place on one side as on the other, and all between is set.
    bool halfway(const Vec3i& p) const {
        for (int i = 0; i < 13; ++i) {
            const Vec3i d{i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
            for (int k = 1; set(p + d * k) && set(p - d * k) && k < 40; ++k) {
                if (depth(place(p + d * k)) >= radius_ - kSame &&
                    depth(place(p - d * k)) >= radius_ - kSame)
                    return true;
            }
        }
        return false;
    }

  private:
    static constexpr double kSame = 1e-6;

    /// Calls for all voxels of the box and of a margin, in one order.
    template <typename With>
    void for_box(const Vec3i& margin, const With& with) const {
        for (int32_t z = -margin.z; z < bits_.size.z + margin.z; ++z) {
            for (int32_t y = -margin.y; y < bits_.size.y + margin.y; ++y) {
                for (int32_t x = -margin.x; x < bits_.size.x + margin.x; ++x)
                    with(Vec3i{x, y, z});
            }
        }
    }
    /// Distances of set voxels to the nearest centre.
    std::vector<double> distances(double radius) const {
        std::vector<Vec3d> all;
        for (const auto& [deep, at] : deep_) {
            if (deep >= radius - kSame) all.push_back(at);
        }
        std::vector<double> out;
        for_box(margin_, [&](const Vec3i& p) {
            double least = 1e300;
            for (const Vec3d& c : all)
                least = std::min(least, dot(c - place(p), c - place(p)));
            out.push_back(set(p) ? std::sqrt(least) : -1);
        });
        return out;
    }
    std::vector<bool> rest(double radius) const {
        std::vector<bool> out;
        for (const double far : distances(radius))
            out.push_back(far >= radius - kSame);
        return out;
    }

    void mark(double radius, Box<uint8_t>* out) const {
        const std::vector<double> near = distances(radius);
        std::vector<double> way(near.size(), 1e300);
        const Vec3i size = bits_.size + margin_ + margin_;
        const auto index = [&](const Vec3i& p) {
            const Vec3i q = p + margin_;
            return (static_cast<size_t>(q.z) * static_cast<size_t>(size.y) +
                    static_cast<size_t>(q.y)) *
                       static_cast<size_t>(size.x) +
                   static_cast<size_t>(q.x);
        };
        std::vector<Vec3i> places;
        for_box(margin_, [&](const Vec3i& p) { places.push_back(p); });
        using Item = std::pair<double, size_t>;
        std::priority_queue<Item, std::vector<Item>, std::greater<>> open;
        for (size_t i = 0; i < near.size(); ++i) {
            if (near[i] < 0 || near[i] >= radius - kSame) continue;
            way[i] = near[i];
            open.emplace(way[i], i);
        }
        while (!open.empty()) {
            const auto [far, i] = open.top();
            open.pop();
            if (far > way[i]) continue;
            for (int n = 0; n < 27; ++n) {
                const Vec3i d{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
                const Vec3i q = places[i] + d, in = q + margin_;
                if (in.x < 0 || in.y < 0 || in.z < 0 || in.x >= size.x || in.y >= size.y ||
                    in.z >= size.z)
                    continue;
                const size_t j = index(q);
                // Where balls reach, the straight way to their centres is free.
                if (near[j] < radius - kSame) continue;
                const double longer = far + length(place(d));
                if (longer >= way[j]) continue;
                way[j] = longer;
                open.emplace(longer, j);
            }
        }
        for (size_t i = 0; i < near.size(); ++i) {
            const Vec3i& p = places[i];
            if (near[i] < radius - kSame || !bits_.holds(p.x, p.y, p.z)) continue;
            const double deep = std::max(depth(place(p)) - coarse_, 0.0);
            const double reach = (radius - deep) / kEdgeSlope + coarse_;
            uint8_t& state = out->values[bits_.at(p.x, p.y, p.z)];
            // By as much as numbers of 15 bits round.
            const double slack = (halves_ ? 1 : -1) * 0.002 * radius / kEdgeSlope;
            if (way[i] > reach + slack && state == 1) state = 2;
        }
    }

    const Bits& bits_;
    const int outside_;
    const Vec3d pitch_;
    const double radius_;
    const bool halves_;
    double coarse_ = 0;
    const Vec3i margin_{1, 1, 1};
    Vec3i beyond_;
    std::vector<std::pair<double, Vec3d>> deep_;  ///< of all places where a ball may lie
    std::vector<Vec3d> others_;
};

}  // namespace openfab::inspection

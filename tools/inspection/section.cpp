// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/inspection/section.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace openfab::inspection {

namespace {

/// Directions that are nowhere more than 15 degrees apart from the nearest one: 49, and none with its opposite.
std::vector<Vec3d> directions() {
    std::vector<Vec3d> out;
    for (int i = 0; i < 125; ++i) {
        const Vec3i d{i % 5 - 2, i / 5 % 5 - 2, i / 25 - 2};
        const bool first = d.z > 0 || (d.z == 0 && (d.y > 0 || (d.y == 0 && d.x > 0)));
        const int squares = dot(d, d);
        const bool multiple = d.x % 2 == 0 && d.y % 2 == 0 && d.z % 2 == 0;
        if (!first || multiple) continue;
        out.push_back(vec_cast<double>(d) * (1 / std::sqrt(static_cast<double>(squares))));
    }
    return out;
}

class Section {
  public:
    Section(const std::function<bool(const Vec3i&)>& open, const Vec3d& pitch_mm,
            const Vec3i& voxel, double diameter_mm)
        : open_(open),
          pitch_(pitch_mm),
          middle_{(voxel.x + 0.5) * pitch_mm.x, (voxel.y + 0.5) * pitch_mm.y,
                  (voxel.z + 0.5) * pitch_mm.z},
          diameter_(diameter_mm),
          step_(std::max(0.7 * std::min({pitch_mm.x, pitch_mm.y, pitch_mm.z}),
                         diameter_mm / kMostSteps)),
          reach_(static_cast<int32_t>(diameter_mm / step_) + 1) {}

    /// Returns the length of what is open along a line, at most four diameters.
    double along(const Vec3d& direction) const {
        double sum = 0;
        for (const double side : {-1.0, 1.0}) {
            for (double t = 0; t < 2 * diameter_ && is_open(middle_ + direction * (side * t));
                 t += step_)
                sum += step_;
        }
        return sum;
    }

    /// Whether the plane across a direction cuts an area of less than the diameter, in all directions.
    bool is_narrow(const Vec3d& across) {
        const Vec3d other = std::fabs(across.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
        Vec3d u = cross(across, other);
        u = u * (1 / length(u));
        const Vec3d v = cross(across, u);
        const int32_t side = 2 * reach_ + 1;
        seen_.assign(static_cast<size_t>(side) * static_cast<size_t>(side), 0);
        std::array<double, kAngles> lo{}, hi{};
        cells_.assign(1, {0, 0});
        mark(0, 0);
        while (!cells_.empty()) {
            const auto [i, j] = cells_.back();
            cells_.pop_back();
            for (size_t a = 0; a < kAngles; ++a) {
                const double angle = 3.14159265358979 * static_cast<double>(a) / kAngles;
                const double at = (i * std::cos(angle) + j * std::sin(angle)) * step_;
                lo[a] = std::min(lo[a], at), hi[a] = std::max(hi[a], at);
                if (hi[a] - lo[a] >= diameter_) return false;
            }
            for (const auto& [di, dj] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
                const int32_t p = i + di, q = j + dj;
                if (std::max(std::abs(p), std::abs(q)) > reach_) return false;
                if (!mark(p, q)) continue;
                if (is_open(middle_ + u * (p * step_) + v * (q * step_))) cells_.emplace_back(p, q);
            }
        }
        return true;
    }

  private:
    static constexpr double kMostSteps = 48;
    static constexpr size_t kAngles = 8;

    /// Returns whether it was not seen before.
    bool mark(int32_t i, int32_t j) {
        uint8_t& seen =
            seen_[static_cast<size_t>(j + reach_) * static_cast<size_t>(2 * reach_ + 1) +
                  static_cast<size_t>(i + reach_)];
        return seen++ == 0;
    }
    bool is_open(const Vec3d& p) const {
        return open_({static_cast<int32_t>(std::floor(p.x / pitch_.x)),
                      static_cast<int32_t>(std::floor(p.y / pitch_.y)),
                      static_cast<int32_t>(std::floor(p.z / pitch_.z))});
    }

    const std::function<bool(const Vec3i&)>& open_;
    const Vec3d pitch_, middle_;
    const double diameter_, step_;
    const int32_t reach_;
    std::vector<uint8_t> seen_;
    std::vector<std::pair<int32_t, int32_t>> cells_;
};

}  // namespace

bool is_hole(const std::function<bool(const Vec3i&)>& open, const Vec3d& pitch_mm,
             const Vec3i& voxel, double diameter_mm) {
    Section section(open, pitch_mm, voxel, diameter_mm);
    std::vector<std::pair<double, Vec3d>> all;
    for (const Vec3d& direction : directions())
        all.emplace_back(section.along(direction), direction);
    // A hole is long across its area.
    std::stable_sort(all.begin(), all.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    return std::any_of(all.begin(), all.end(),
                       [&](const auto& one) { return section.is_narrow(one.second); });
}

}  // namespace openfab::inspection

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/split/coarse_solid.h"

#include <algorithm>
#include <cmath>

namespace openfab::pieces {

CoarseSolid::CoarseSolid(const Body& body, int64_t voxels) {
    Box3d box;
    for (const Vec3d& p : body.positions)
        box.add(p);
    const Vec3d size = box.size();
    const double volume = std::max(size.x, 1e-6) * std::max(size.y, 1e-6) * std::max(size.z, 1e-6);
    pitch_ = std::cbrt(volume / static_cast<double>(voxels));
    origin_ = box.lo;
    for (int a = 0; a < 3; ++a)
        size_[a] = static_cast<int32_t>(std::clamp(std::ceil(size[a] / pitch_), 1.0, 4096.0));
    cells_.assign(index(0, 0, size_.z), 0);
    // Crossings of rows along x: the winding number changes at each.
    std::vector<int8_t> turns(cells_.size() + 1, 0);
    for (size_t t = 0; t < body.triangles.size(); ++t) {
        const auto [a, b, c] = body.triangle(t);
        const auto first = [&](double least, double from) {
            return static_cast<int32_t>(std::max(std::ceil((least - from) / pitch_ - 0.5), 0.0));
        };
        const int32_t y0 = first(std::min({a.y, b.y, c.y}), origin_.y);
        const int32_t z0 = first(std::min({a.z, b.z, c.z}), origin_.z);
        const double y_end = std::max({a.y, b.y, c.y}), z_end = std::max({a.z, b.z, c.z});
        const Vec3d n = cross(b - a, c - a);
        if (n.x == 0) continue;
        const double turn = n.x > 0 ? 1 : -1;
        const auto right = [&](const Vec3d& p, const Vec3d& q, double y, double z) {
            const double s = (q.y - p.y) * (z - p.z) - (q.z - p.z) * (y - p.y);
            if (s != 0) return s * turn > 0;
            const double e = (p.z - q.z) != 0 ? p.z - q.z : q.y - p.y;
            return e * turn > 0;
        };
        for (int32_t z = z0; z < size_.z; ++z) {
            const double pz = origin_.z + (z + 0.5) * pitch_;
            if (pz > z_end) break;
            for (int32_t y = y0; y < size_.y; ++y) {
                const double py = origin_.y + (y + 0.5) * pitch_;
                if (py > y_end) break;
                if (!right(a, b, py, pz) || !right(b, c, py, pz) || !right(c, a, py, pz)) continue;
                const double x = a.x - (n.y * (py - a.y) + n.z * (pz - a.z)) / n.x;
                const double at = std::ceil((x - origin_.x) / pitch_ - 0.5);
                // Entering is a turn against x.
                if (at < size_.x) {
                    turns[index(static_cast<int32_t>(std::max(at, 0.0)), y, z)] =
                        static_cast<int8_t>(
                            turns[index(static_cast<int32_t>(std::max(at, 0.0)), y, z)] +
                            (turn < 0 ? 1 : -1));
                }
            }
        }
    }
    for (int32_t z = 0; z < size_.z; ++z) {
        for (int32_t y = 0; y < size_.y; ++y) {
            int32_t winding = 0;
            for (int32_t x = 0; x < size_.x; ++x) {
                winding += turns[index(x, y, z)];
                cells_[index(x, y, z)] = winding > 0 ? 1 : 0;
            }
        }
    }
    for (int32_t z = 0; z < size_.z; ++z) {
        for (int32_t y = 0; y < size_.y; ++y) {
            for (int32_t x = 0; x < size_.x; ++x) {
                if (cells_[index(x, y, z)] == 0) continue;
                const Vec3d p = origin_ + Vec3d{x + 0.5, y + 0.5, z + 0.5} * pitch_;
                centers_.push_back(vec_cast<float>(p));
                bool skin = false;
                for (int a = 0; a < 3; ++a) {
                    for (const double by : {-pitch_, pitch_}) {
                        Vec3d q = p;
                        q[a] += by;
                        skin |= !solid(q);
                    }
                }
                skin_.push_back(skin ? 1 : 0);
            }
        }
    }
}

bool CoarseSolid::solid(const Vec3d& p) const {
    Vec3i i;
    for (int a = 0; a < 3; ++a) {
        const double at = std::floor((p[a] - origin_[a]) / pitch_);
        if (!(at >= 0 && at < size_[a])) return false;
        i[a] = static_cast<int32_t>(at);
    }
    return cells_[index(i.x, i.y, i.z)] != 0;
}

}  // namespace openfab::pieces

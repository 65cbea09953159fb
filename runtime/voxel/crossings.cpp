// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/voxel/crossings.h"

#include <algorithm>
#include <utility>

namespace openfab::voxel {

namespace {

__extension__ typedef __int128 Wide;

// With all differences below 2^19 the plane test stays below 2^62.
constexpr int32_t kSmall = 1 << 19;

/// E of one edge at the first row, and its change per row; `least` is 0 where E = 0 counts as left,
/// else 1.
struct EdgeTest {
    int64_t at, per_j, per_k, least;

    EdgeTest(const Vec3i& p, const Vec3i& q, int64_t y, int64_t z) {
        const int64_t dy = static_cast<int64_t>(q.y) - p.y, dz = static_cast<int64_t>(q.z) - p.z;
        at = dy * (z - p.z) - dz * (y - p.y);
        per_j = -dz * kSnap;
        per_k = dy * kSnap;
        least = dz < 0 || (dz == 0 && dy > 0) ? 0 : 1;
    }
};

template <typename Int>
Int ceil_div(Int a, Int b) {
    const Int q = a / b;
    return q + (a % b > 0 ? 1 : 0);
}

/// Which infinitesimal of a sample dominates, seen along its ray: for rows the ray's own, for
/// columns those across.
enum class Along { kRow, kColumn };

/// The plane of a triangle whose (y, z) area is positive, for finding c.
template <typename Int>
class Plane {
  public:
    Plane(const Vec3i& a, const Vec3i& b, const Vec3i& c, Along along) : y0_(a.y), z0_(a.z) {
        const Int by = static_cast<Int>(b.y) - a.y, bz = static_cast<Int>(b.z) - a.z,
                  bx = static_cast<Int>(b.x) - a.x;
        const Int cy = static_cast<Int>(c.y) - a.y, cz = static_cast<Int>(c.z) - a.z,
                  cx = static_cast<Int>(c.x) - a.x;
        nx_ = by * cz - bz * cy;
        ny_ = bz * cx - bx * cz;
        nz_ = bx * cy - by * cx;
        // a.x - 128 = 256 whole + rest keeps the products small.
        whole_ = (a.x - 128) >> 8;
        const Int rest = (a.x - 128) & 255;
        scaled_rest_ = rest * nx_;
        // A column's sample at the crossing's own height lies below it where the plane rises along
        // the column's first axis, or is level there and rises along the second: whole quotients
        // then count one more, ceil((q + 1) / d) = floor(q / d) + 1.
        if (along == Along::kColumn && (ny_ < 0 || (ny_ == 0 && nz_ < 0))) scaled_rest_ += 1;
    }
    int32_t crossing(int32_t y, int32_t z) const {
        const Int off = ny_ * (static_cast<Int>(y) - y0_) + nz_ * (static_cast<Int>(z) - z0_);
        return whole_ + static_cast<int32_t>(ceil_div<Int>(scaled_rest_ - off, nx_ * kSnap));
    }

  private:
    Int nx_, ny_, nz_, scaled_rest_;
    Int y0_, z0_;
    int32_t whole_;
};

template <typename Int>
void walk(const Vec3i& a, const Vec3i& b, const Vec3i& c, int32_t turn, Along along,
          const Window& rows, const Window& window, std::vector<Crossing>* out) {
    const int32_t y = rows.lo.y * kSnap + 128, z = rows.lo.z * kSnap + 128;
    EdgeTest e0(a, b, y, z), e1(b, c, y, z), e2(c, a, y, z);
    const Plane<Int> plane(a, b, c, along);
    for (int32_t k = rows.lo.z; k < rows.hi.z; ++k) {
        int64_t s0 = e0.at, s1 = e1.at, s2 = e2.at;
        for (int32_t j = rows.lo.y; j < rows.hi.y; ++j) {
            if (s0 >= e0.least && s1 >= e1.least && s2 >= e2.least) {
                const int32_t at = plane.crossing(j * kSnap + 128, k * kSnap + 128);
                out->push_back({k, j, std::clamp(at, window.lo.x, window.hi.x), turn});
            }
            s0 += e0.per_j, s1 += e1.per_j, s2 += e2.per_j;
        }
        e0.at += e0.per_k, e1.at += e1.per_k, e2.at += e2.per_k;
    }
}

void add_along(const Vec3i& a, const Vec3i& b, const Vec3i& c, int32_t turn, Along along,
               const Window& window, std::vector<Crossing>* out) {
    const auto [y_lo, y_hi] = std::minmax({a.y, b.y, c.y});
    const auto [z_lo, z_hi] = std::minmax({a.z, b.z, c.z});
    Window rows;
    rows.lo.y = std::max(first_row(y_lo), window.lo.y),
    rows.hi.y = std::min(first_row(y_hi), window.hi.y);
    rows.lo.z = std::max(first_row(z_lo), window.lo.z),
    rows.hi.z = std::min(first_row(z_hi), window.hi.z);
    if (rows.lo.y >= rows.hi.y || rows.lo.z >= rows.hi.z) return;
    const int64_t area = (static_cast<int64_t>(b.y) - a.y) * (static_cast<int64_t>(c.z) - a.z) -
                         (static_cast<int64_t>(b.z) - a.z) * (static_cast<int64_t>(c.y) - a.y);
    if (area == 0) return;
    const auto [x_lo, x_hi] = std::minmax({a.x, b.x, c.x});
    const bool small = y_hi - y_lo < kSmall && z_hi - z_lo < kSmall && x_hi - x_lo < kSmall;
    const Vec3i &second = area > 0 ? b : c, &third = area > 0 ? c : b;
    const int32_t signed_turn = area > 0 ? turn : -turn;
    if (small) {
        walk<int64_t>(a, second, third, signed_turn, along, rows, window, out);
    } else {
        walk<Wide>(a, second, third, signed_turn, along, rows, window, out);
    }
}

/// z becomes the axis of the ray, x and y those across, in this order: a rotation, not a mirror
/// image.
Vec3i column_first(const Vec3i& v) {
    return {v.z, v.x, v.y};
}

}  // namespace

void add_crossings(const Vec3i& a, const Vec3i& b, const Vec3i& c, int32_t turn,
                   const Window& window, std::vector<Crossing>* out) {
    add_along(a, b, c, turn, Along::kRow, window, out);
}

void add_column_crossings(const Vec3i& a, const Vec3i& b, const Vec3i& c, int32_t turn,
                          const Window& window, std::vector<Crossing>* out) {
    add_along(column_first(a), column_first(b), column_first(c), turn, Along::kColumn,
              {column_first(window.lo), column_first(window.hi)}, out);
}

}  // namespace openfab::voxel

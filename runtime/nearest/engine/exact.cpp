// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/engine/exact.h"

#include <cmath>

namespace openfab::nearest {
namespace {

/// An exact sum or product: `hi` is the rounded result, `lo` its rounding error.
struct Pair {
    double hi, lo;
};

Pair exact_sum(double a, double b) {
    const double hi = a + b;
    const double b_part = hi - a, a_part = hi - b_part;
    return {hi, (a - a_part) + (b - b_part)};
}

Pair exact_difference(float a, float b) {
    return exact_sum(a, -static_cast<double>(b));
}

/// Splits a double into its upper 26 bits and the rest.
Pair split(double a) {
    const double c = 134217729.0 * a;  // 2^27 + 1
    const double hi = c - (c - a);
    return {hi, a - hi};
}

Pair exact_product(double a, double b) {
    const double hi = a * b;
    const Pair x = split(a), y = split(b);
    const double lo = x.lo * y.lo - (((hi - x.hi * y.hi) - x.lo * y.hi) - x.hi * y.lo);
    return {hi, lo};
}

/// A sum of nonoverlapping doubles in ascending order, without zeros.
class Sum {
  public:
    void add(double x) {
        int kept = 0;
        for (int i = 0; i < count_; ++i) {
            const Pair s = exact_sum(x, part_[i]);
            x = s.hi;
            if (s.lo != 0) part_[kept++] = s.lo;
        }
        if (x != 0) part_[kept++] = x;
        count_ = kept;
    }
    void add_product(double a, double b) {
        const Pair p = exact_product(a, b);
        add(p.lo);
        add(p.hi);
    }
    int sign() const { return count_ == 0 ? 0 : part_[count_ - 1] > 0 ? 1 : -1; }

  private:
    double part_[200];  ///< the largest sum has 192 terms
    int count_ = 0;
};

int sign_of(double x) {
    return x > 0 ? 1 : x < 0 ? -1 : 0;
}

// The relative errors of the double evaluations below, differences included, are at most 3 and 7
// times 2^-53 (Shewchuk's A bounds, to first order); twice that covers higher orders.
constexpr double kAreaError = 6 * 0x1p-53;
constexpr double kVolumeError = 14 * 0x1p-53;

void add_area(const Pair& a, const Pair& b, double turn, Sum* sum) {
    for (const double x : {a.hi, a.lo}) {
        for (const double y : {b.hi, b.lo})
            sum->add_product(turn * x, y);
    }
}

void add_volume(const Pair& a, const Pair& b, const Pair& c, double turn, Sum* sum) {
    for (const double x : {a.hi, a.lo}) {
        for (const double y : {b.hi, b.lo}) {
            const Pair xy = exact_product(turn * x, y);
            for (const double z : {c.hi, c.lo}) {
                sum->add_product(xy.lo, z);
                sum->add_product(xy.hi, z);
            }
        }
    }
}

}  // namespace

int area_sign(const Vec3f& p, const Vec3f& q, const Vec3f& s) {
    const double left = (static_cast<double>(q.y) - p.y) * (static_cast<double>(s.z) - p.z);
    const double right = (static_cast<double>(q.z) - p.z) * (static_cast<double>(s.y) - p.y);
    const double area = left - right;
    const double size = std::fabs(left) + std::fabs(right);
    // Where size is 0 a factor of each product is exactly 0.
    if (std::fabs(area) > kAreaError * size || size == 0) return sign_of(area);
    Sum sum;
    add_area(exact_difference(q.y, p.y), exact_difference(s.z, p.z), 1, &sum);
    add_area(exact_difference(q.z, p.z), exact_difference(s.y, p.y), -1, &sum);
    return sum.sign();
}

int volume_sign(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& s) {
    const Vec3f* const to[3] = {&b, &c, &s};
    double d[3][3];
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k)
            d[i][k] = static_cast<double>((*to[i])[k]) - a[k];
    }
    double volume = 0, size = 0;
    for (int k = 0; k < 3; ++k) {
        const int k1 = (k + 1) % 3, k2 = (k + 2) % 3;
        const double left = d[0][k1] * d[1][k2], right = d[0][k2] * d[1][k1];
        volume += (left - right) * d[2][k];
        size += (std::fabs(left) + std::fabs(right)) * std::fabs(d[2][k]);
    }
    if (std::fabs(volume) > kVolumeError * size || size == 0) return sign_of(volume);
    Pair e[3][3];
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k)
            e[i][k] = exact_difference((*to[i])[k], a[k]);
    }
    Sum sum;
    for (int k = 0; k < 3; ++k) {
        const int k1 = (k + 1) % 3, k2 = (k + 2) % 3;
        add_volume(e[0][k1], e[1][k2], e[2][k], 1, &sum);
        add_volume(e[0][k2], e[1][k1], e[2][k], -1, &sum);
    }
    return sum.sign();
}

}  // namespace openfab::nearest

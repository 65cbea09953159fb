// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/nearly_equal_stretch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "base/polar.h"

namespace openfab::world {

namespace {

using Matrix = std::array<double, 9>;

/// Of a rotation of six decimals, each entry of S is off by at most sqrt(3) / 2 of the sixth.
constexpr double kSlack = 1e-6;
constexpr double kHalfSqrt3 = 0.8660254037844386;
constexpr Matrix kIdentity{1, 0, 0, 0, 1, 0, 0, 0, 1};

double largest_entry(const Matrix& s) {
    return std::max({std::fabs(s[0]), std::fabs(s[4]), std::fabs(s[8])});  // S is positive definite
}

bool is_near(const Matrix& a, const Matrix& b, double slack) {
    for (size_t i = 0; i < a.size(); ++i) {
        if (std::fabs(a[i] - b[i]) > slack) return false;
    }
    return true;
}

Matrix product(const Matrix& a, const Matrix& b) {
    Matrix out{};
    for (size_t i = 0; i < 3; ++i) {
        for (size_t j = 0; j < 3; ++j)
            out[i * 3 + j] = a[i * 3] * b[j] + a[i * 3 + 1] * b[3 + j] + a[i * 3 + 2] * b[6 + j];
    }
    return out;
}

/// Returns by how much an entry of S may be off because M is written with four or five decimals: 0
/// where it is not, and where each axis goes along one axis, which needs no decimals to be exact.
double slack_of(const Matrix& m) {
    bool slanted = false;
    for (size_t row = 0; row < 3; ++row)
        slanted = slanted || std::count(&m[3 * row], &m[3 * row] + 3, 0.0) < 2;
    if (!slanted) return 0;
    for (const double last : {1e4, 1e5}) {
        // A number of so many decimals is the quotient that is rounded correctly.
        if (std::ranges::all_of(m, [&](double v) { return std::round(v * last) / last == v; }))
            return 1.01 * kHalfSqrt3 / last;
    }
    return 0;
}

}  // namespace

Matrix Stretches::representative(const Matrix& s, double slack, double apart) {
    if (is_near(s, kIdentity, slack)) return kIdentity;
    for (auto it = known_.lower_bound(s[0] - apart);
         it != known_.end() && it->first <= s[0] + apart; ++it) {
        for (const Matrix& other : it->second) {
            if (is_near(s, other, apart)) return other;
        }
    }
    known_[s[0]].push_back(s);
    return s;
}

Matrix WrittenMatrices::exact(const Matrix& written) {
    const double slack = slack_of(written);
    if (slack == 0) return written;
    const Result<PolarFactors> polar = polar_factors(written);
    if (!polar) return written;  // reported where it was read
    const Matrix s = stretches_.representative(polar->s, slack, 2 * slack);
    if (s == polar->s) return written;
    ++changed_;
    return product(polar->r, s);
}

size_t equalise_stretches(World* world) {
    size_t changed = 0;
    std::map<int32_t, Stretches> by_mesh;
    for (Placement& placement : world->build) {
        const Result<PolarFactors> polar = polar_factors(placement.transform.m);
        if (!polar) continue;  // reported where the part is made
        Stretches& of_mesh = by_mesh[world->objects[static_cast<size_t>(placement.object)].mesh];
        const Matrix s = of_mesh.representative(polar->s, kSlack, kSlack * largest_entry(polar->s));
        if (s == polar->s) continue;
        placement.transform.m = product(polar->r, s);
        ++changed;
    }
    return changed;
}

}  // namespace openfab::world

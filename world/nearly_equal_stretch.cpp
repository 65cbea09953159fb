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

/// The stretches of a mesh's placements so far, by their first entry.
class Stretches {
  public:
    /// Returns the one that stands for `s`, which may be `s`.
    Matrix representative(const Matrix& s) {
        if (is_near(s, kIdentity, kSlack)) return kIdentity;
        const double slack = kSlack * largest_entry(s);
        for (auto it = known_.lower_bound(s[0] - slack);
             it != known_.end() && it->first <= s[0] + slack; ++it) {
            for (const Matrix& other : it->second) {
                if (is_near(s, other, slack)) return other;
            }
        }
        known_[s[0]].push_back(s);
        return s;
    }

  private:
    std::map<double, std::vector<Matrix>> known_;
};

}  // namespace

size_t equalise_stretches(World* world) {
    size_t changed = 0;
    std::map<int32_t, Stretches> by_mesh;
    for (Placement& placement : world->build) {
        const Result<PolarFactors> polar = polar_factors(placement.transform.m);
        if (!polar) continue;  // reported where the part is made
        const Matrix s =
            by_mesh[world->objects[static_cast<size_t>(placement.object)].mesh].representative(
                polar->s);
        if (s == polar->s) continue;
        placement.transform.m = product(polar->r, s);
        ++changed;
    }
    return changed;
}

}  // namespace openfab::world

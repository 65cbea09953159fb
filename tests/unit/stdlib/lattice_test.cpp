// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Distances to minimal surfaces, against the nearest of many points of each surface, in double
// precision: the error of a wall's thickness or a solid's volume; and the share of space that a
// level or a wall was asked to fill.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/stdlib/library_function.h"

namespace openfab::testing {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kPeriod = 8;  // mm
// Half the thickness of a wall, as a fraction of the period: up to 0.28 in thickness.
constexpr std::array<double, 8> kHalves = {0.008, 0.03, 0.045, 0.06, 0.07, 0.08, 0.1, 0.14};

double dot(const Vec& a, const Vec& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
/// a + b * t
Vec along(const Vec& a, const Vec& b, double t) {
    return {a[0] + b[0] * t, a[1] + b[1] * t, a[2] + b[2] * t};
}

/// Fields of period 2 pi, like the functions of the same names.
double gyroid(const Vec& q) {
    return std::sin(q[0]) * std::cos(q[1]) + std::sin(q[1]) * std::cos(q[2]) +
           std::sin(q[2]) * std::cos(q[0]);
}
double schwarz_p(const Vec& q) {
    return std::cos(q[0]) + std::cos(q[1]) + std::cos(q[2]);
}
/// The same as a sum of two products of sums: sin(x + y) and cos(x - y).
double schwarz_d(const Vec& q) {
    return std::cos(q[2]) * std::sin(q[0] + q[1]) + std::sin(q[2]) * std::cos(q[0] - q[1]);
}
double neovius(const Vec& q) {
    return 3 * schwarz_p(q) + 4 * std::cos(q[0]) * std::cos(q[1]) * std::cos(q[2]);
}

double iwp(const Vec& q) {
    return 2 * (std::cos(q[0]) * std::cos(q[1]) + std::cos(q[1]) * std::cos(q[2]) +
                std::cos(q[2]) * std::cos(q[0])) -
           schwarz_p({2 * q[0], 2 * q[1], 2 * q[2]});
}
/// cos 2x cos 2y + cos 2y cos 2z + cos 2z cos 2x
double double_pairs(const Vec& q) {
    return std::cos(2 * q[0]) * std::cos(2 * q[1]) + std::cos(2 * q[1]) * std::cos(2 * q[2]) +
           std::cos(2 * q[2]) * std::cos(2 * q[0]);
}
double frd(const Vec& q) {
    return 4 * std::cos(q[0]) * std::cos(q[1]) * std::cos(q[2]) - double_pairs(q);
}
double fischer_koch_s(const Vec& q) {
    return std::cos(2 * q[0]) * std::sin(q[1]) * std::cos(q[2]) +
           std::cos(q[0]) * std::cos(2 * q[1]) * std::sin(q[2]) +
           std::sin(q[0]) * std::cos(q[1]) * std::cos(2 * q[2]);
}
double double_odd(const Vec& q) {
    return std::sin(2 * q[0]) * std::cos(q[1]) * std::sin(q[2]) +
           std::sin(2 * q[1]) * std::cos(q[2]) * std::sin(q[0]) +
           std::sin(2 * q[2]) * std::cos(q[0]) * std::sin(q[1]);
}
double lidinoid(const Vec& q) {
    return 0.5 * (double_odd(q) - double_pairs(q)) + 0.15;
}
double split_p(const Vec& q) {
    return 1.1 * double_odd(q) - 0.2 * double_pairs(q) -
           0.4 * schwarz_p({2 * q[0], 2 * q[1], 2 * q[2]});
}
/// A gyroid of cells twice as long along x and half as long again along y, in units of the shortest
/// edge.
double long_gyroid(const Vec& q) {
    return gyroid({q[0] / 2, q[1] / 1.5, q[2]});
}

using Field = double (*)(const Vec&);

Vec gradient(Field field, const Vec& q) {
    constexpr double kStep = 1e-5;
    Vec out;
    for (size_t k = 0; k < 3; ++k) {
        Vec more = q, less = q;
        more[k] += kStep;
        less[k] -= kStep;
        out[k] = (field(more) - field(less)) / (2 * kStep);
    }
    return out;
}

/// Returns a point of the surface near q.
Vec onto(Field field, Vec q, int steps) {
    for (int k = 0; k < steps; ++k) {
        const Vec g = gradient(field, q);
        const double step = field(q) / std::max(dot(g, g), 0.02);
        q = along(q, g, -std::clamp(step, -0.5, 0.5));
    }
    return q;
}

/// Points on the surface in one period and around it, in cells.
class Surface {
  public:
    explicit Surface(Field field) : field_(field) {
        std::mt19937 random(5);
        std::uniform_real_distribution<double> place(-kReach, kTwoPi + kReach);
        for (int k = 0; k < kPoints; ++k) {
            const Vec q = onto(field, {place(random), place(random), place(random)}, 12);
            if (std::abs(field(q)) < 1e-9) cells_[cell_of(q)].push_back(q);
        }
    }

    /// Unsigned. From the nearest of the points, along the surface to where the normal passes
    /// through q.
    double distance(const Vec& q) const {
        Vec y = nearest(q);
        for (int k = 0; k < 8; ++k) {
            y = onto(field_, y, 1);
            const Vec g = gradient(field_, y), off = along(q, y, -1);
            const Vec beside = along(off, g, -dot(off, g) / dot(g, g));
            y = along(y, beside, 0.6);
        }
        const Vec off = along(q, onto(field_, y, 2), -1);
        return std::sqrt(dot(off, off));
    }

  private:
    using Cell = std::array<int, 3>;
    static constexpr double kReach = 2.7, kCell = 0.5;
    static constexpr int kPoints = 60'000;

    static Cell cell_of(const Vec& q) {
        Cell out;
        for (size_t k = 0; k < 3; ++k)
            out[k] = static_cast<int>(std::floor(q[k] / kCell));
        return out;
    }

    /// Shells of cells outwards, until none can hold a nearer point.
    Vec nearest(const Vec& q) const {
        const Cell centre = cell_of(q);
        Vec best{};
        double least = 1e30;
        for (int r = 0; r < 8 && (r == 0 || least > kCell * kCell * (r - 1) * (r - 1)); ++r) {
            for (int x = -r; x <= r; ++x) {
                for (int y = -r; y <= r; ++y) {
                    const bool side = std::abs(x) == r || std::abs(y) == r;
                    for (int z = -r; z <= r; z += side || r == 0 ? 1 : 2 * r) {
                        const auto cell =
                            cells_.find({centre[0] + x, centre[1] + y, centre[2] + z});
                        if (cell == cells_.end()) continue;
                        for (const Vec& p : cell->second) {
                            const Vec off = along(q, p, -1);
                            if (dot(off, off) >= least) continue;
                            least = dot(off, off);
                            best = p;
                        }
                    }
                }
            }
        }
        return best;
    }

    Field field_;
    std::map<Cell, std::vector<Vec>> cells_;
};

struct Case {
    const char* name;
    Field field;
    double largest;              ///< distance from the surface, as a fraction of the period
    double widest;               ///< wall that is measured, as a fraction of the period
    bool steps = true;           ///< found by steps, which are interpreted slowly
    const char* call = nullptr;  ///< of a function that another case has, too, in other cells

    bool has_shares() const { return call == nullptr; }
    /// The distance at p, for a period of 8 mm.
    std::string expression() const {
        return call != nullptr ? call : std::string(name) + "_distance(p, 8)";
    }
};

const Surface& reference_of(Field field) {
    static std::map<Field, Surface> made;
    return made.try_emplace(field, field).first->second;
}

LibraryFunction function(const std::string& expression) {
    return LibraryFunction::of("lattice", expression);
}

Vec in_mm(const Vec& q) {
    return {q[0] * kPeriod / kTwoPi, q[1] * kPeriod / kTwoPi, q[2] * kPeriod / kTwoPi};
}

class Lattice : public ::testing::TestWithParam<Case> {};

TEST_P(Lattice, WallsAndSolidsAreAsThickAsAsked) {
    const Case& surface = GetParam();
    const LibraryFunction distance = function(surface.expression());
    const Surface& reference = reference_of(surface.field);
    const int samples = surface.steps ? 5'000 : 12'000;
    std::mt19937 random(23);
    std::uniform_real_distribution<double> place(0, kTwoPi);
    std::array<int, kHalves.size()> walls{}, walls_found{}, solids{}, solids_found{};
    std::vector<double> errors;
    for (int k = 0; k < samples; ++k) {
        const Vec q = {place(random), place(random), place(random)};
        const double unsigned_mm = reference.distance(q) * kPeriod / kTwoPi;
        const double exact = surface.field(q) < 0 ? -unsigned_mm : unsigned_mm;
        const double found = distance(in_mm(q));
        EXPECT_LE(std::abs(found), surface.largest * kPeriod);
        if (std::abs(exact) > 1e-3) {
            EXPECT_EQ(found < 0, exact < 0) << exact;
        }
        for (size_t h = 0; h < kHalves.size(); ++h) {
            const double half = kHalves[h] * kPeriod;
            walls[h] += std::abs(exact) < half ? 1 : 0;
            walls_found[h] += std::abs(found) < half ? 1 : 0;
            // A solid on one side, eroded by as much.
            solids[h] += exact < -half ? 1 : 0;
            solids_found[h] += found < -half ? 1 : 0;
        }
        if (std::abs(exact) < 0.35 * surface.widest * kPeriod)
            errors.push_back(std::abs(found - exact));
    }
    for (size_t h = 0; h < kHalves.size() && 2 * kHalves[h] <= surface.widest; ++h) {
        SCOPED_TRACE(::testing::Message() << "a wall of " << 2 * kHalves[h] << " of the period");
        // 2 %, plus the sampling error where there are few points.
        EXPECT_NEAR(walls_found[h], walls[h], 0.02 * walls[h] + 4);
        EXPECT_NEAR(solids_found[h], solids[h], 0.02 * std::max(solids[h], walls[h]) + 4);
        RecordProperty("share_" + std::to_string(h),
                       std::to_string(static_cast<double>(walls_found[h]) / samples) + " of " +
                           std::to_string(static_cast<double>(walls[h]) / samples));
    }
    // Each point, against a wall of 0.7 of the widest.
    std::sort(errors.begin(), errors.end());
    EXPECT_LT(errors[errors.size() * 95 / 100], 0.02 * 0.7 * surface.widest * kPeriod);
}

/// The field itself, in units of its range.
TEST_P(Lattice, FieldsAreThoseOfTheirFormulas) {
    const Case& surface = GetParam();
    if (!surface.has_shares()) return;
    const LibraryFunction field = function(std::string(surface.name) + "(p, 8)");
    std::mt19937 random(31);
    std::uniform_real_distribution<double> place(-2 * kTwoPi, 2 * kTwoPi);
    for (int k = 0; k < 300; ++k) {
        const Vec q = {place(random), place(random), place(random)};
        EXPECT_NEAR(field(in_mm(q)), surface.field(q), 1e-5 * 13);
    }
}

/// Levels by the field in double precision, walls by its distances, with their sampling error.
TEST_P(Lattice, LevelsAndWallsFillTheShareThatWasAsked) {
    const Case& surface = GetParam();
    if (!surface.has_shares()) return;
    const Surface& reference = reference_of(surface.field);
    constexpr size_t kSamples = 6'000;
    std::mt19937 random(29);
    std::uniform_real_distribution<double> place(0, kTwoPi);
    std::vector<double> fields, distances;
    for (size_t k = 0; k < 16 * kSamples; ++k) {
        const Vec q = {place(random), place(random), place(random)};
        fields.push_back(surface.field(q));
        if (k % 16 == 0) distances.push_back(reference.distance(q) / kTwoPi);
    }
    const auto share = [](const std::vector<double>& values, double most) {
        return static_cast<double>(
                   std::ranges::count_if(values, [&](double v) { return v < most; })) /
               static_cast<double>(values.size());
    };
    const LibraryFunction level = function(std::string(surface.name) + "_level(p.x)");
    const LibraryFunction wall = function(std::string(surface.name) + "_wall(p.x, p.y)");
    for (const double fraction : {0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9})
        EXPECT_NEAR(share(fields, level({fraction, 0, 0})), fraction, 0.01);
    for (const double fraction : {0.05, 0.15, 0.3, 0.5, 0.65, 0.8}) {
        const double thickness = wall({fraction, 3, 0}) / 3;
        const double sampled = std::sqrt(fraction * (1 - fraction) / kSamples);
        EXPECT_NEAR(share(distances, thickness / 2), fraction, 0.01 + 3 * sampled);
    }
}

INSTANTIATE_TEST_SUITE_P(
    MinimalSurfaces, Lattice,
    ::testing::Values(
        Case{"gyroid", gyroid, 0.2309, 0.28, false},
        Case{"schwarz_p", schwarz_p, 0.4298, 0.28, false},
        Case{"schwarz_d", schwarz_d, 0.2149, 0.28, false}, Case{"neovius", neovius, 0.4123, 0.28},
        Case{"iwp", iwp, 0.2786, 0.24}, Case{"frd", frd, 0.2754, 0.14},
        Case{"fischer_koch_s", fischer_koch_s, 0.1516, 0.16},
        Case{"lidinoid", lidinoid, 0.1363, 0.12}, Case{"split_p", split_p, 0.1643, 0.16},
        Case{"long_gyroid", long_gyroid, 2 * 0.2309, 0.28, true,
             "gyroid_distance(p, float3(16, 12, 8))"},
        Case{"stepped_p", schwarz_p, 0.4298, 0.28, true, "schwarz_p_distance(p, float3(8, 8, 8))"},
        Case{"stepped_d", schwarz_d, 0.2149, 0.28, true, "schwarz_d_distance(p, float3(8, 8, 8))"}),
    [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace openfab::testing

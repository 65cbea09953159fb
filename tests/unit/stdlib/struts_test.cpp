// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Strut lattices and honeycombs against all bonds between their nodes near a cell, in double
// precision: the distance itself where no second strut is near, and what a fillet may change.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/stdlib/library_function.h"

namespace openfab::testing {
namespace {

double length(const Vec& v) {
    return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}
Vec minus(const Vec& a, const Vec& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Vec times(const Vec& a, const Vec& b) {
    return {a[0] * b[0], a[1] * b[1], a[2] * b[2]};
}

struct Bond {
    Vec from, to;
    double thickness = 1;
};

double distance(const Vec& p, const Bond& bond) {
    const Vec way = minus(bond.to, bond.from), off = minus(p, bond.from);
    double along = 0, square = 0;
    for (size_t k = 0; k < 3; ++k) {
        along += way[k] * off[k];
        square += way[k] * way[k];
    }
    const double t = std::clamp(along / square, 0.0, 1.0);
    return length({off[0] - t * way[0], off[1] - t * way[1], off[2] - t * way[2]});
}

/// All nodes of the cells around one, in edges.
std::vector<Vec> repeated(const std::vector<Vec>& nodes) {
    std::vector<Vec> out;
    for (int x = -2; x <= 2; ++x) {
        for (int y = -2; y <= 2; ++y) {
            for (int z = -2; z <= 2; ++z) {
                for (const Vec& n : nodes)
                    out.push_back({n[0] + x, n[1] + y, n[2] + z});
            }
        }
    }
    return out;
}

/// Joins nodes that are so far apart, where a cell has those proportions.
std::vector<Bond> bonds(const std::vector<Vec>& nodes, double apart, const Vec& shape = {1, 1, 1},
                        double thickness = 1) {
    const std::vector<Vec> all = repeated(nodes);
    std::vector<Bond> out;
    for (size_t i = 0; i < all.size(); ++i) {
        for (size_t j = i + 1; j < all.size(); ++j) {
            if (std::abs(length(times(minus(all[i], all[j]), shape)) - apart) < 1e-6)
                out.push_back({all[i], all[j], thickness});
        }
    }
    return out;
}

std::vector<Bond> both(std::vector<Bond> a, const std::vector<Bond>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

/// Between nodes of different kinds.
std::vector<Bond> between(const std::vector<Vec>& a, const std::vector<Vec>& b, double apart) {
    std::vector<Bond> out;
    for (const Vec& from : repeated(a)) {
        for (const Vec& to : repeated(b)) {
            if (std::abs(length(minus(from, to)) - apart) < 1e-6) out.push_back({from, to});
        }
    }
    return out;
}

const double kRoot2 = std::numbers::sqrt2, kRoot3 = std::numbers::sqrt3;
const std::vector<Vec> kCorner = {{0, 0, 0}};
const std::vector<Vec> kFcc = {{0, 0, 0}, {0.5, 0.5, 0}, {0.5, 0, 0.5}, {0, 0.5, 0.5}};
const std::vector<Vec> kDiamond = {
    {0.25, 0.25, 0.25}, {0.75, 0.75, 0.25}, {0.75, 0.25, 0.75}, {0.25, 0.75, 0.75}};

std::vector<Bond> cubic(double thickness) {
    return bonds(kCorner, 1, {1, 1, 1}, thickness);
}
std::vector<Bond> bcc() {
    return between(kCorner, {{0.5, 0.5, 0.5}}, kRoot3 / 2);
}
std::vector<Bond> fcc() {
    std::vector<Bond> out;
    for (const Bond& bond : between(kCorner, {kFcc.begin() + 1, kFcc.end()}, kRoot2 / 2))
        out.push_back(bond);
    return out;
}
std::vector<Bond> kelvin() {
    std::vector<Vec> nodes;
    for (const double sign : {0.25, 0.75}) {
        for (size_t k = 0; k < 3; ++k) {
            Vec a{}, b{};
            a[k] = sign;
            a[(k + 1) % 3] = 0.5;
            b[k] = sign;
            b[(k + 2) % 3] = 0.5;
            nodes.push_back(a);
            nodes.push_back(b);
        }
    }
    return bonds(nodes, kRoot2 / 4);
}
std::vector<Bond> fluorite() {
    std::vector<Vec> eighths = kDiamond;
    for (const Vec& n : kDiamond)
        eighths.push_back({1 - n[0], n[1], n[2]});
    return between(kFcc, eighths, kRoot3 / 4);
}
std::vector<Bond> prisms() {
    const std::vector<Vec> nodes = {
        {0, 1.0 / 3, 0}, {0, 2.0 / 3, 0}, {0.5, 1.0 / 6, 0}, {0.5, 5.0 / 6, 0}};
    return both(bonds(nodes, 1 / kRoot3, {1, kRoot3, 10}), bonds(nodes, 1, {10, 10, 1}));
}
std::vector<Bond> reentrant(double lean) {
    const double top = 0.4, waist = top - lean;
    std::vector<Bond> out;
    for (int x = -2; x <= 2; ++x) {
        for (int y = -2; y <= 2; ++y) {
            for (int z = -2; z <= 2; ++z) {
                const auto add = [&](const Vec& a, const Vec& b) {
                    out.push_back({{a[0] + x, a[1] + y, a[2] + z}, {b[0] + x, b[1] + y, b[2] + z}});
                };
                add({0, 0, waist}, {0, 0, 1 - waist});
                add({0.5, 0, -top}, {0.5, 0, top});
                add({0, 0.5, -top}, {0, 0.5, top});
                for (const double s : {-1.0, 1.0}) {
                    for (const double t : {-0.5, 0.5}) {
                        add({0, 0, s * waist}, {t, 0, s * top});
                        add({0, 0, s * waist}, {0, t, s * top});
                    }
                }
            }
        }
    }
    return out;
}

LibraryFunction function(const std::string& expression) {
    return LibraryFunction::of("lattice struts", expression);
}

struct Case {
    const char* name;
    const char* more;  ///< arguments after the fillet
    std::vector<Bond> (*bonds)();
};

class Struts : public ::testing::TestWithParam<Case> {};

TEST_P(Struts, AreAsThickAsAskedAwayFromNodes) {
    constexpr double kRadius = 0.4;
    const Case& lattice = GetParam();
    // Cubes, and cells of three edges; what is isotropic is so in cubes alone.
    for (const Vec& cell : {Vec{6, 6, 6}, Vec{5, 8, 6.5}}) {
        std::vector<Bond> reference = lattice.bonds();
        for (Bond& bond : reference)
            bond = {times(bond.from, cell), times(bond.to, cell), bond.thickness};
        for (const double fillet : {0.0, 0.6}) {
            SCOPED_TRACE(::testing::Message() << "cell.y " << cell[1] << ", fillet " << fillet);
            const LibraryFunction strut = function(
                std::string("strut_") + lattice.name + "(p, float3(" + std::to_string(cell[0]) +
                ", " + std::to_string(cell[1]) + ", " + std::to_string(cell[2]) + "), 0.4, " +
                std::to_string(fillet) + lattice.more + ")");
            std::mt19937 random(3);
            std::uniform_real_distribution<double> place(-0.5, 0.5);
            int alone = 0;
            for (int k = 0; k < 600; ++k) {
                const Vec p = times({place(random), place(random), place(random)}, cell);
                double least = 1e9, second = 1e9;
                for (const Bond& bond : reference) {
                    const double d = distance(p, bond) - kRadius * bond.thickness;
                    second = std::min(second, std::max(d, least));
                    least = std::min(least, d);
                }
                // A fifth of the shortest edge: as far as diamond's holds in such cells.
                if (cell[0] != cell[1] && least > 1) continue;
                const double found = strut(p);
                EXPECT_LT(found, least + 3e-5);
                // Inside, a strut that goes on beyond its node is one strut there.
                if (second >= fillet) {
                    EXPECT_NEAR(found, least, 3e-5);
                    ++alone;
                } else if (fillet > 0) {
                    // Up to eight struts at a node.
                    EXPECT_GT(found, fillet - std::sqrt(8.0) * (fillet - least) - 1e-5);
                }
            }
            EXPECT_GT(alone, 60);
        }
    }
}

/// The four of `lattice` in cubes, without a fillet: exact everywhere.
TEST_P(Struts, InCubesWithoutFilletsAreExact) {
    const Case& lattice = GetParam();
    const std::string name = lattice.name;
    if (name != "cubic" && name != "bcc" && name != "fcc" && name != "octet") return;
    std::vector<Bond> reference = lattice.bonds();
    for (Bond& bond : reference)
        bond = {times(bond.from, {6, 6, 6}), times(bond.to, {6, 6, 6})};
    const LibraryFunction strut = function("strut_" + name + "(p, 6, 0.4)");
    std::mt19937 random(13);
    std::uniform_real_distribution<double> place(-3, 3);
    for (int k = 0; k < 600; ++k) {
        const Vec p = {place(random), place(random), place(random)};
        double least = 1e9;
        for (const Bond& bond : reference)
            least = std::min(least, distance(p, bond));
        EXPECT_NEAR(strut(p), least - 0.4, 3e-6);
    }
}

INSTANTIATE_TEST_SUITE_P(
    All, Struts,
    ::testing::Values(
        Case{"cubic", "", [] { return cubic(1); }}, Case{"bcc", "", bcc}, Case{"fcc", "", fcc},
        Case{"octet", "", [] { return bonds(kFcc, kRoot2 / 2); }}, Case{"kelvin", "", kelvin},
        Case{"diamond", "", [] { return between(kFcc, kDiamond, kRoot3 / 4); }},
        Case{"fluorite", "", fluorite},
        Case{"isotruss", "", [] { return both(cubic(1.2408065), bcc()); }},
        Case{"reentrant", ", 0.25", [] { return reentrant(0.25); }}, Case{"hexagonal", "", prisms}),
    [](const auto& info) { return info.param.name; });

/// Between two struts at a right angle a fillet is a circle.
TEST(Fillets, AreRoundAtRightAngles) {
    const LibraryFunction strut = function("strut_cubic(p, 20, 1, 0.5)");
    for (double turn = 0.1; turn < 1.5; turn += 0.2) {
        const Vec p = {1.5 - 0.5 * std::cos(turn), 1.5 - 0.5 * std::sin(turn), 0};
        EXPECT_NEAR(strut(p), 0, 1e-5) << turn;
    }
}

/// Pieces of which the middle of the walls is made, in edges of a cell, at z = 0.
void expect_walls(const std::string& expression, const Vec& cell, const std::vector<Bond>& walls) {
    const LibraryFunction strut = function(expression);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(-0.5, 0.5);
    for (int k = 0; k < 600; ++k) {
        const Vec p = times({place(random), place(random), 0}, cell);
        double least = 1e9;
        for (const Bond& wall : walls)
            least = std::min(least, distance(p, {times(wall.from, cell), times(wall.to, cell)}));
        EXPECT_NEAR(strut(p), least - 0.25, 2e-4) << expression;
    }
}

TEST(Plates, HoneycombsAreExact) {
    const auto level = [](std::vector<Bond> all) {
        std::erase_if(all, [](const Bond& b) { return b.from[2] != 0 || b.to[2] != 0; });
        return all;
    };
    expect_walls("honeycomb(p.xy, float2(5, 7), 0.5)", {5, 7, 9}, level(prisms()));
    std::vector<Bond> bow_ties;
    for (const Bond& b : reentrant(0.2)) {
        if (b.from[1] == 0 && b.to[1] == 0)
            bow_ties.push_back({{b.from[0], b.from[2], 0}, {b.to[0], b.to[2], 0}});
    }
    expect_walls("honeycomb_reentrant(p.xy, float2(5, 7), 0.5, 0.2)", {5, 7, 9}, bow_ties);
    // Rings as polygons, and the crossed tangents of neighbours.
    std::vector<Bond> chiral;
    constexpr double kRing = 0.25;
    constexpr int kSides = 400;
    const double lean = std::asin(2 * kRing), step = 2 * std::numbers::pi / kSides;
    for (int x = -1; x <= 1; ++x) {
        for (int y = -1; y <= 1; ++y) {
            const auto at = [&](double turn) {
                return Vec{x + kRing * std::cos(turn), y + kRing * std::sin(turn), 0};
            };
            for (int k = 0; k < kSides; ++k)
                chiral.push_back({at(k * step), at((k + 1) * step)});
            for (const double side : {0.0, 0.5 * std::numbers::pi}) {
                const double turn = side - (0.5 * std::numbers::pi - lean);
                Vec to = at(turn + std::numbers::pi);
                to[side == 0.0 ? 0 : 1] += 1;
                chiral.push_back({at(turn), to});
            }
        }
    }
    expect_walls("honeycomb_chiral(p.xy, 6, 1.5, 0.5)", {6, 6, 6}, chiral);
}

/// Planes of one family are where the coordinates, in edges, add up to a whole number.
TEST(Plates, AreTheNearestOfTheirPlanes) {
    const LibraryFunction octet = function("plates_octet(p, float3(4, 5, 6), 0.5)");
    const LibraryFunction cubic = function("plates_cubic(p, float3(4, 5, 6), 0.5)");
    const Vec cell = {4, 5, 6};
    std::mt19937 random(17);
    std::uniform_real_distribution<double> place(-9, 9);
    for (int k = 0; k < 500; ++k) {
        const Vec p = {place(random), place(random), place(random)};
        double across = 1e9, along = 1e9;
        for (int n = -12; n <= 12; ++n) {
            for (const Vec& sign : {Vec{1, 1, 1}, Vec{1, 1, -1}, Vec{1, -1, 1}, Vec{1, -1, -1}}) {
                const Vec slope = {sign[0] / cell[0], sign[1] / cell[1], sign[2] / cell[2]};
                const double sum = slope[0] * p[0] + slope[1] * p[1] + slope[2] * p[2];
                across = std::min(across, std::abs(sum - n) / length(slope));
            }
            for (size_t axis = 0; axis < 3; ++axis)
                along = std::min(along, std::abs(p[axis] - n * cell[axis]));
        }
        EXPECT_NEAR(octet(p), across - 0.25, 1e-5);
        EXPECT_NEAR(cubic(p), along - 0.25, 1e-5);
    }
}

TEST(Plates, PlanesPassThroughTheirNodes) {
    const LibraryFunction octet = function("plates_octet(p, float3(4, 5, 6), 0.5)");
    const LibraryFunction cubic = function("plates_cubic(p, float3(4, 5, 6), 0.5)");
    // The middle of an octahedron is half-way along an edge of the cell.
    const double planes = 0.5 / length({0.25, 0.2, 1.0 / 6});
    EXPECT_NEAR(octet({2, 0, 0}), planes - 0.25, 1e-5);
    EXPECT_NEAR(octet({2, 2.5, 0}), -0.25, 1e-5);
    EXPECT_NEAR(octet({1, 1.25, 1.5}), 0.5 * planes - 0.25, 1e-5);
    EXPECT_NEAR(cubic({1.5, 2, 3}), 1.25, 1e-5);
    EXPECT_NEAR(cubic({1.5, 2, -6.25}), 0, 1e-5);
}

}  // namespace
}  // namespace openfab::testing

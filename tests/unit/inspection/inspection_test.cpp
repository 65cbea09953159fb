// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What inspections find in voxels of shapes whose measures are known.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/long_run.h"
#include "tools/inspection/components.h"
#include "tools/inspection/distances.h"
#include "tools/inspection/section.h"
#include "tools/inspection/spread.h"
#include "tools/inspection/thickness.h"

namespace openfab::inspection {
namespace {

using testing::long_run;

/// Sets the voxels whose centres, in mm from the middle, are inside.
Bits sample(const Vec3i& size, const Vec3d& pitch_mm,
            const std::function<bool(const Vec3d& p)>& inside) {
    Bits bits(size);
    for (int32_t z = 0; z < size.z; ++z) {
        for (int32_t y = 0; y < size.y; ++y) {
            for (int32_t x = 0; x < size.x; ++x) {
                const Vec3d p{(x + 0.5 - size.x * 0.5) * pitch_mm.x,
                              (y + 0.5 - size.y * 0.5) * pitch_mm.y,
                              (z + 0.5 - size.z * 0.5) * pitch_mm.z};
                bits.values[bits.at(x, y, z)] = inside(p) ? 1 : 0;
            }
        }
    }
    return bits;
}

Vec3d random_direction(std::mt19937* random) {
    std::normal_distribution<double> normal;
    Vec3d v{normal(*random), normal(*random), normal(*random)};
    return v * (1 / length(v));
}

/// Parts of voxels at three times the pitch, as `openfab check` looks at worlds: the diameter of balls for a limit in them.
double ball_of(double limit) {
    return limit - 0.75;
}

constexpr Vec3d kCube{1, 1, 1};

/// Three directions at right angles, and a place within a voxel.
struct Frame {
    Vec3d a, b, c, at;

    Frame(std::mt19937* random, int trial) {
        std::uniform_real_distribution<double> shift(-0.5, 0.5);
        a = random_direction(random), b = random_direction(random);
        if (trial == 0) a = {1, 0, 0}, b = {0, 1, 0};
        if (trial == 1) a = {std::sqrt(0.5), 0, std::sqrt(0.5)}, b = {0, 1, 0};
        if (trial == 2) a = Vec3d{1, 1, 1} * std::sqrt(1.0 / 3);
        b = b - a * dot(a, b);
        b = b * (1 / length(b));
        c = cross(a, b);
        at = {shift(*random), shift(*random), shift(*random)};
        if (trial == 0) at = {};
    }
    /// Coordinates along the three.
    Vec3d operator()(const Vec3d& p) const {
        const Vec3d q = p - at;
        return {dot(q, a), dot(q, b), dot(q, c)};
    }
};

bool in_cube(const Vec3d& p, double half) {
    return std::max({std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)}) < half;
}

using Form = std::function<bool(const Vec3d& p, double thickness)>;

/// Things of a thickness, in a cube or a ball of 44; those of void are in a block.
struct Named {
    const char* name;
    int outside;
    Form form;
};

const std::vector<Named>& forms() {
    static const std::vector<Named> kAll{
        {"plate", 0,
         [](const Vec3d& p, double t) { return std::fabs(p.x) < t / 2 && length(p) < 20; }},
        {"square post", 0,
         [](const Vec3d& p, double t) {
             return std::fabs(p.x) < t / 2 && std::fabs(p.y) < t / 2 && std::fabs(p.z) < 20;
         }},
        {"wire", 0,
         [](const Vec3d& p, double t) {
             return std::hypot(p.x, p.y) < t / 2 && std::fabs(p.z) < 20;
         }},
        {"wire on a block", 0,
         [](const Vec3d& p, double t) {
             return (std::hypot(p.x, p.y) < t / 2 && p.z > 0 && p.z < 20) ||
                    (p.z <= 0 && in_cube(p, 15));
         }},
        {"gap", 1,
         [](const Vec3d& p, double t) { return std::fabs(p.x) < t / 2 || !in_cube(p, 18); }},
        {"groove", 1,
         [](const Vec3d& p, double t) {
             return (std::fabs(p.x) < t / 2 && p.z > 0) || !in_cube(p, 18);
         }},
        {"hole", 1,
         [](const Vec3d& p, double t) { return std::hypot(p.x, p.y) < t / 2 || !in_cube(p, 18); }},
        {"square hole", 1,
         [](const Vec3d& p, double t) {
             return (std::fabs(p.x) < t / 2 && std::fabs(p.y) < t / 2) || !in_cube(p, 18);
         }},
        {"blind hole", 1,
         [](const Vec3d& p, double t) {
             return (std::hypot(p.x, p.y) < t / 2 && p.z > 18 - 2 * t) || !in_cube(p, 18);
         }},
        {"bubble", 1,
         [](const Vec3d& p, double t) { return length(p) < t / 2 || !in_cube(p, 18); }},
        {"bubble below a skin", 1, [](const Vec3d& p, double t) {
             return length(p) < t / 2 || !in_cube(p + Vec3d{0, 0, 14 - t / 2}, 18);
         }}};
    return kAll;
}

/// Finds what is thinner than the limit by a voxel of the machine or more, at any angle, and nothing that is as thick
/// as the limit.
TEST(Thickness, WhatIsThinIsFoundAtAnyAngleAndNothingElse) {
    std::mt19937 random(7);
    const Vec3i size{46, 46, 46};
    for (int trial = 0; trial < (long_run() ? 60 : 5); ++trial) {
        const Frame frame(&random, trial);
        for (const Named& one : forms()) {
            for (const double limit : {6.0, 9.0, 12.0}) {
                for (double t = 3; t <= limit + 3; t += 3) {
                    const Bits bits =
                        sample(size, kCube, [&](const Vec3d& p) { return one.form(frame(p), t); });
                    const std::vector<Thin> found =
                        find_thin(bits, one.outside, kCube, ball_of(limit));
                    ASSERT_EQ(found.empty(), t >= limit)
                        << one.name << ", trial " << trial << ", " << t << " of " << limit;
                    if (found.empty()) continue;
                    const auto largest = std::max_element(
                        found.begin(), found.end(), [](const Thin& a, const Thin& b) {
                            return a.where.voxels < b.where.voxels;
                        });
                    EXPECT_NEAR(largest->thickness_mm, t, 1.5) << one.name << ", trial " << trial;
                }
            }
        }
    }
}

TEST(Thickness, EdgesAndCornersAreNotThin) {
    std::mt19937 random(11);
    const std::vector<std::pair<const char*, std::function<bool(const Vec3d&)>>> bodies{
        {"cube", [](const Vec3d& p) { return in_cube(p, 12.5); }},
        {"cylinder",
         [](const Vec3d& p) { return std::hypot(p.x, p.y) < 12 && std::fabs(p.z) < 13; }},
        {"wedge of 60 degrees",
         [](const Vec3d& p) {
             const double s = std::sqrt(0.75);
             return std::fabs(p.z) < 13 && p.y > -9 && s * p.x + p.y / 2 < 9 &&
                    p.y / 2 - s * p.x < 9;
         }},
        {"cubes with a gap of one",
         [](const Vec3d& p) {
             return std::fabs(p.y) < 10 && std::fabs(p.z) < 10 && std::fabs(p.x) < 20.5 &&
                    std::fabs(p.x) > 0.5;
         }},
        {"plate with a hole", [](const Vec3d& p) {
             return std::fabs(p.z) < 9 && std::hypot(p.x, p.y) > 4 && length(p) < 24;
         }}};
    for (int trial = 0; trial < (long_run() ? 60 : 5); ++trial) {
        const Frame frame(&random, trial);
        for (const auto& [name, body] : bodies) {
            const Bits bits =
                sample({56, 56, 56}, kCube, [&](const Vec3d& p) { return body(frame(p)); });
            for (const double limit : {4.0, 6.0, 9.0, 15.0}) {
                const std::vector<Thin> found = find_thin(bits, 0, kCube, ball_of(limit));
                EXPECT_TRUE(found.empty())
                    << name << ", trial " << trial << ", limit " << limit << ": " << found.size()
                    << ", " << found[0].thickness_mm << " of " << found[0].where.voxels;
            }
        }
    }
}

TEST(Thickness, WholeVoxelsAreCountedAlongAxes) {
    for (const int32_t thick : {1, 2, 3, 4}) {
        Bits bits({20, 20, 8});
        for (int32_t z = 2; z < 2 + thick; ++z) {
            for (int32_t y = 0; y < 20; ++y)
                std::fill_n(&bits.values[bits.at(0, y, z)], 20, uint8_t{1});
        }
        for (const int32_t limit : {1, 2, 3, 4})
            EXPECT_EQ(find_thin(bits, 0, kCube, limit + 0.5).empty(), thick >= limit)
                << thick << " of " << limit;
    }
}

TEST(Thickness, VoxelsNeedNotBeCubes) {
    const Vec3d pitch{0.014, 0.0283, 0.009};
    const double limit = 0.3, ball = limit - 0.75 * pitch.y;
    std::mt19937 random(3);
    for (int trial = 0; trial < 6; ++trial) {
        Frame frame(&random, trial);
        frame.at = frame.at * pitch.x;
        for (const double mm : {0.1, 0.2, 0.31, 0.4}) {
            const auto in = [&](const Vec3d& p) {
                return std::fabs(frame(p).x) < mm / 2 && in_cube(frame(p), 0.33);
            };
            const std::vector<Thin> found =
                find_thin(sample({60, 32, 90}, pitch, in), 0, pitch, ball);
            ASSERT_EQ(found.empty(), mm > limit) << mm << ", trial " << trial;
            if (!found.empty()) {
                EXPECT_NEAR(found[0].thickness_mm, mm, pitch.y) << "trial " << trial;
            }
        }
    }
}

TEST(Sections, HolesAreNarrowInSomePlaneAndGapsInNone) {
    std::mt19937 random(5);
    constexpr double kLimit = 12;
    for (int trial = 0; trial < (long_run() ? 40 : 4); ++trial) {
        const Frame frame(&random, trial);
        for (const double t : {3.0, 6.0, 8.0}) {
            for (const Named& one : forms()) {
                if (one.outside == 0) continue;
                const Bits bits = sample({46, 46, 46}, kCube,
                                         [&](const Vec3d& p) { return one.form(frame(p), t); });
                int holes = 0, all = 0;
                for (const Thin& thin : find_thin(bits, 1, kCube, ball_of(kLimit))) {
                    for (const Vec3i& p : thin.middles) {
                        ++all;
                        const auto open = [&](const Vec3i& q) {
                            return !bits.holds(q.x, q.y, q.z) ||
                                   bits.values[bits.at(q.x, q.y, q.z)] != 0;
                        };
                        holes += is_hole(open, kCube, p, kLimit) ? 1 : 0;
                    }
                }
                const std::string name = one.name;
                const bool gap = name == "gap" || name == "groove";
                ASSERT_GT(all, 0) << name;
                EXPECT_EQ(2 * holes >= all, !gap)
                    << name << " of " << t << ", trial " << trial << ": " << holes << " of " << all;
            }
        }
    }
}

TEST(Squares, EachInstructionSetSpreadsTheSame) {
    std::mt19937 random(7);
    for (int trial = 0; trial < 30; ++trial) {
        const auto rows = static_cast<int32_t>(1 + random() % 20),
                   width = static_cast<int32_t>(1 + random() % 150),
                   steps = static_cast<int32_t>(1 + random() % 80);
        std::vector<uint16_t> values(static_cast<size_t>(rows) * static_cast<size_t>(width)),
            costs(2 * static_cast<size_t>(steps) + 1);
        for (uint16_t& v : values)
            v = random() % 3 == 0 ? static_cast<uint16_t>(random() % 900) : Squares::kFar;
        for (size_t i = 0; i < costs.size(); ++i) {
            const auto d = static_cast<int32_t>(i) - steps;
            costs[i] = static_cast<uint16_t>(d * d + trial % 2);
        }
        std::vector<std::vector<uint16_t>> results;
        for (const int limit : {0, 1}) {
            std::vector<uint16_t> out = values,
                                  copy(static_cast<size_t>(width + 2 * steps), Squares::kFar),
                                  rows_copy(static_cast<size_t>(rows) * kPiece);
            std::vector<Piece> pieces(200);
            const SpreadKernels& kernels = spread_kernels(limit);
            const uint16_t* const cost = costs.data() + steps;
            for (int32_t r = 0; r < rows; ++r)
                kernels.along(out.data() + r * width, width, cost, steps, copy.data(),
                              pieces.data());
            kernels.across(out.data(), static_cast<size_t>(width), rows, width, cost, steps,
                           rows_copy.data(), pieces.data());
            results.push_back(out);
        }
        EXPECT_EQ(results[0], results[1]) << trial;
        EXPECT_NE(results[0], values) << trial;
    }
}

// Pieces of rows that are far from all that is near are passed over.
TEST(Squares, AreTheLeastOfAllPairs) {
    std::mt19937 random(64);
    for (int trial = 0; trial < 40; ++trial) {
        const auto side = [&](uint32_t most) { return static_cast<int32_t>(1 + random() % most); };
        const Vec3i size{side(200), side(12), side(6)};
        const Vec3d pitch{1, trial % 2 == 0 ? 1.0 : 0.7, trial % 3 == 0 ? 1.0 : 1.3};
        const double reach = 1 + random() % 5;
        const Squares squares(pitch, reach);
        Box<uint16_t> values(size, Squares::kFar);
        std::vector<Vec3i> set;
        const auto count = random() % 6;
        for (uint32_t k = 0; k < count; ++k) {
            const Vec3i p{static_cast<int32_t>(random()) & 0x7fffffff,
                          static_cast<int32_t>(random() % 64), static_cast<int32_t>(random() % 64)};
            set.push_back({p.x % size.x, p.y % size.y, p.z % size.z});
            // Whole stretches, too.
            for (int32_t x = set.back().x; trial % 4 == 1 && x < size.x; ++x)
                set.push_back({x, set.back().y, set.back().z});
        }
        for (const Vec3i& p : set)
            values.values[values.at(p.x, p.y, p.z)] = 0;
        const Vec3i half{trial % 5 == 1 ? 1 : 0, trial % 5 == 2 ? -1 : 0, trial % 5 == 3 ? 1 : 0};
        squares.spread(&values, half);
        for (int32_t z = 0; z < size.z; ++z) {
            for (int32_t y = 0; y < size.y; ++y) {
                for (int32_t x = 0; x < size.x; ++x) {
                    double least = 1e9;
                    for (const Vec3i& p : set) {
                        const Vec3d d{(p.x - x - 0.5 * half.x) * pitch.x,
                                      (p.y - y - 0.5 * half.y) * pitch.y,
                                      (p.z - z - 0.5 * half.z) * pitch.z};
                        least = std::min(least, length(d));
                    }
                    const double found = squares.length(values.values[values.at(x, y, z)]);
                    if (least <= reach) {
                        // Each axis is rounded to a number.
                        ASSERT_NEAR(found * found, least * least, 3e-4 * reach * reach)
                            << x << " " << y << " " << z << ", trial " << trial;
                    } else {
                        ASSERT_GT(found, reach * 0.999);
                    }
                }
            }
        }
    }
}

TEST(Components, AreCountedByWhatTheyTouchWith) {
    Bits bits({4, 4, 4});
    for (const Vec3i& p : {Vec3i{0, 0, 0}, Vec3i{1, 1, 0}, Vec3i{3, 3, 3}, Vec3i{3, 3, 2}})
        bits.values[bits.at(p.x, p.y, p.z)] = 1;
    Box<int32_t> labels;
    EXPECT_EQ(components(bits, Touch::kFaces, &labels).size(), 3u);
    const std::vector<Cluster> found = components(bits, Touch::kCorners, &labels);
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[1].voxels, 2);
    EXPECT_EQ(labels.values[labels.at(3, 3, 3)], 2);
    EXPECT_TRUE(found[0].at_border);
    EXPECT_EQ(found[1].box.lo, (Vec3i{3, 3, 2}));
}

/// By floods, voxel by voxel.
struct Flooded {
    Box<int32_t> labels;
    std::vector<Cluster> all;

    Flooded(const Bits& bits, Touch touch, uint8_t mask) : labels(bits.size, 0) {
        for (int32_t z = 0; z < bits.size.z; ++z)
            for (int32_t y = 0; y < bits.size.y; ++y)
                for (int32_t x = 0; x < bits.size.x; ++x)
                    if (is_open(bits, {x, y, z}, mask)) flood(bits, {x, y, z}, touch, mask);
        for (int32_t z = 0; z < bits.size.z; ++z)
            for (int32_t y = 0; y < bits.size.y; ++y)
                for (int32_t x = 0; x < bits.size.x; ++x)
                    if (const int32_t label = labels.values[labels.at(x, y, z)]; label > 0)
                        all[static_cast<size_t>(label - 1)].add({x, y, z}, 1, bits.size);
    }

  private:
    bool is_open(const Bits& bits, const Vec3i& p, uint8_t mask) const {
        return bits.holds(p.x, p.y, p.z) && (bits.values[bits.at(p.x, p.y, p.z)] & mask) != 0 &&
               labels.values[labels.at(p.x, p.y, p.z)] == 0;
    }
    void flood(const Bits& bits, const Vec3i& from, Touch touch, uint8_t mask) {
        all.emplace_back();
        std::vector<Vec3i> open{from};
        while (!open.empty()) {
            const Vec3i p = open.back();
            open.pop_back();
            if (!is_open(bits, p, mask)) continue;
            labels.values[labels.at(p.x, p.y, p.z)] = static_cast<int32_t>(all.size());
            for (int32_t i = 0; i < 27; ++i) {
                const Vec3i d{i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
                if (touch == Touch::kCorners || d.x * d.x + d.y * d.y + d.z * d.z == 1)
                    open.push_back(p + d);
            }
        }
    }
};

TEST(Components, AreThoseOfFloods) {
    std::mt19937 random(50);
    for (int trial = 0; trial < 300; ++trial) {
        const auto side = [&] { return static_cast<int32_t>(1 + random() % 9); };
        Bits bits({side(), side(), side()});
        const uint32_t share = 1 + random() % 9;
        for (uint8_t& one : bits.values)
            one = random() % 10 < share ? static_cast<uint8_t>(random() % 4) : 0;
        for (const Touch touch : {Touch::kFaces, Touch::kCorners}) {
            for (const uint8_t mask : {uint8_t{0xff}, uint8_t{2}}) {
                Box<int32_t> labels;
                const std::vector<Cluster> found = components(bits, touch, &labels, mask);
                const Flooded expected(bits, touch, mask);
                EXPECT_EQ(labels.values, expected.labels.values);
                ASSERT_EQ(found.size(), expected.all.size());
                for (size_t i = 0; i < found.size(); ++i) {
                    EXPECT_EQ(found[i].voxels, expected.all[i].voxels);
                    EXPECT_EQ(found[i].first, expected.all[i].first);
                    EXPECT_EQ(found[i].box.lo, expected.all[i].box.lo);
                    EXPECT_EQ(found[i].box.hi, expected.all[i].box.hi);
                    EXPECT_EQ(found[i].at_border, expected.all[i].at_border);
                }
            }
        }
    }
}

TEST(Components, ASpiralIsOne) {
    // Its arms meet late in the order of voxels.
    const Bits bits = sample({41, 41, 3}, {1, 1, 1}, [](const Vec3d& p) {
        const double angle = std::atan2(p.y, p.x) / 6.283185307;
        const double turn = std::hypot(p.x, p.y) / 4 - angle;
        return turn - std::floor(turn) < 0.5;
    });
    Box<int32_t> labels;
    const std::vector<Cluster> found = components(bits, Touch::kFaces, &labels);
    EXPECT_LE(found.size(), 12u);
    int64_t largest = 0, all = 0;
    for (const Cluster& cluster : found)
        largest = std::max(largest, cluster.voxels), all += cluster.voxels;
    EXPECT_GT(largest * 2, all);
}

}  // namespace
}  // namespace openfab::inspection

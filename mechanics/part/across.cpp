// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/part/across.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mechanics/part/surface.h"
#include "mechanics/solver/parallel.h"

namespace openfab::mechanics {

namespace {

constexpr double kMost = double{kAcrossMost} / kAcrossStep;
/// What is that much softer is no part of a wall.
constexpr float kSofter = 0.1F;
constexpr float kFull = 0.99F;

struct Step {
    std::array<int32_t, 3> by;
    double length;
};

/// One of each pair of opposite directions: three axes, six diagonals of faces, four of the body.
std::vector<Step> directions() {
    std::vector<Step> out;
    for (int o = 14; o < 27; ++o) {
        const std::array<int32_t, 3> by{o % 3 - 1, o / 3 % 3 - 1, o / 9 - 1};
        out.push_back(
            {by, std::sqrt(static_cast<double>(by[0] * by[0] + by[1] * by[1] + by[2] * by[2]))});
    }
    return out;
}

class Across {
  public:
    Across(const Grid& g, const Voxels& v, std::span<const uint8_t> kind, bool dithered)
        : g_(g), v_(v), kind_(kind), dithered_(dithered), directions_(directions()) {}

    std::vector<uint8_t> run() {
        own_.resize(kind_.size());
        const std::vector<uint8_t> deep = deep_inside();
        for_each(g_, [&](const std::array<int32_t, 3>& p, size_t e) {
            if (kind_[e] != kSolid) return;
            own_[e] = deep[e] ? uint8_t{kAcrossMost} : least_run(p, e);
        });
        std::vector<uint8_t> out = own_;
        for_each(g_, [&](const std::array<int32_t, 3>& p, size_t e) {
            if (own_[e] > 0 && own_[e] < kAcrossMost) out[e] = covered(p, e);
        });
        return out;
    }

  private:
    template <typename F>
    static void for_each(const Grid& g, const F& f) {
        for_each_index(g.elements[2], [&](int32_t z) {
            for (int32_t y = 0; y < g.elements[1]; ++y)
                for (int32_t x = 0; x < g.elements[0]; ++x)
                    f({x, y, z}, g.element(x, y, z));
        });
    }
    bool inside(const std::array<int32_t, 3>& p) const {
        for (size_t a = 0; a < 3; ++a)
            if (p[a] < 0 || p[a] >= g_.elements[a]) return false;
        return true;
    }
    float stiffness(size_t e) const { return v_.solid[e] > 0 ? v_.mu[e] / v_.solid[e] : 0; }

    /// Whether all within two elements is full and as stiff, to a factor of two: most of a part, found cheaply.
    std::vector<uint8_t> deep_inside() const {
        std::vector<uint8_t> out(kind_.size());
        for (size_t e = 0; e < out.size(); ++e)
            if (kind_[e] == kSolid && v_.solid[e] >= kFull)
                out[e] = static_cast<uint8_t>(std::clamp(std::ilogb(v_.mu[e]) + 128, 1, 255));
        const size_t stride[3] = {
            1, static_cast<size_t>(g_.elements[0]),
            static_cast<size_t>(g_.elements[0]) * static_cast<size_t>(g_.elements[1])};
        for (size_t axis = 0; axis < 3; ++axis) {
            const auto n = static_cast<size_t>(g_.elements[axis]);
            const size_t a = (axis + 1) % 3, b = (axis + 2) % 3;
            for_each_index(g_.elements[b], [&](int32_t j) {
                std::vector<uint8_t> line(n + 4);
                for (int32_t i = 0; i < g_.elements[a]; ++i) {
                    uint8_t* p = out.data() + static_cast<size_t>(i) * stride[a] +
                                 static_cast<size_t>(j) * stride[b];
                    for (size_t k = 0; k < n; ++k)
                        line[k + 2] = p[k * stride[axis]];
                    for (size_t k = 0; k < n; ++k) {
                        const uint8_t c = line[k + 2];
                        const bool same = line[k] == c && line[k + 1] == c && line[k + 3] == c &&
                                          line[k + 4] == c;
                        p[k * stride[axis]] = same ? c : uint8_t{0};
                    }
                }
            });
        }
        return out;
    }

    uint8_t least_run(const std::array<int32_t, 3>& p, size_t e) const {
        const float least_stiff = dithered_ ? 0 : kSofter * stiffness(e);
        double least = kMost;
        for (const Step& d : directions_) {
            double sum = static_cast<double>(v_.solid[e]);
            for (const int32_t sign : {1, -1}) {
                std::array<int32_t, 3> q = p;
                while (sum * d.length < least) {
                    for (size_t a = 0; a < 3; ++a)
                        q[a] += sign * d.by[a];
                    if (!inside(q)) break;
                    const size_t other = g_.element(q[0], q[1], q[2]);
                    if (kind_[other] == kNothing || stiffness(other) < least_stiff) break;
                    sum += static_cast<double>(v_.solid[other]);
                }
            }
            least = std::min(least, sum * d.length);
        }
        return static_cast<uint8_t>(std::max(1L, std::lround(least * kAcrossStep)));
    }

    /// Whether an element is in a block of two by two by two that is full.
    bool in_block(const std::array<int32_t, 3>& p, float least_stiff) const {
        for (int block = 0; block < 8; ++block) {
            bool full = true;
            for (int k = 0; full && k < 8; ++k) {
                const std::array<int32_t, 3> q{p[0] + (k & 1) - (block & 1),
                                               p[1] + (k >> 1 & 1) - (block >> 1 & 1),
                                               p[2] + (k >> 2) - (block >> 2)};
                full = inside(q);
                if (!full) break;
                const size_t other = g_.element(q[0], q[1], q[2]);
                full = v_.solid[other] >= kFull && kind_[other] == kSolid &&
                       stiffness(other) >= least_stiff;
            }
            if (full) return true;
        }
        return false;
    }

    uint8_t covered(const std::array<int32_t, 3>& p, size_t e) const {
        uint8_t most = own_[e];
        const float least_stiff = dithered_ ? 0 : kSofter * stiffness(e);
        constexpr int32_t kReach = 2;
        for (int32_t z = -kReach; z <= kReach; ++z)
            for (int32_t y = -kReach; y <= kReach; ++y)
                for (int32_t x = -kReach; x <= kReach; ++x) {
                    const std::array<int32_t, 3> q{p[0] + x, p[1] + y, p[2] + z};
                    if (!inside(q)) continue;
                    const size_t other = g_.element(q[0], q[1], q[2]);
                    const uint8_t there = own_[other];
                    // Twice the distance is at most the thickness there, from an element's corner to another's: so
                    // the edges of a wall between one and two elements are as thick as it is.
                    constexpr int kCorners = 45;
                    const int square = 4 * (x * x + y * y + z * z) * kAcrossStep * kAcrossStep;
                    const int reach = int{there} + kCorners;
                    if (there > most && square <= reach * reach && stiffness(other) >= least_stiff)
                        most = there;
                }
        // A rod of two by two has an edge in each of its elements.
        constexpr int kTwo = 2 * kAcrossStep;
        if (most < kTwo && in_block(p, least_stiff)) most = kTwo;
        return most;
    }

    const Grid& g_;
    const Voxels& v_;
    std::span<const uint8_t> kind_;
    bool dithered_;
    std::vector<Step> directions_;
    std::vector<uint8_t> own_;
};

/// The sum of shares of what goes on along an axis, of `most` elements to each side, and whether the surface is beside
/// the element.
std::pair<double, bool> run_along(const Grid& g, const Voxels& v, std::span<const uint8_t> kind,
                                  const std::array<int32_t, 3>& p, size_t axis, int32_t most) {
    double sum = static_cast<double>(v.solid[g.element(p[0], p[1], p[2])]);
    bool beside = false;
    for (const int32_t sign : {1, -1})
        for (int32_t k = 1; k <= most; ++k) {
            std::array<int32_t, 3> q = p;
            q[axis] += sign * k;
            const bool in = q[axis] >= 0 && q[axis] < g.elements[axis];
            const size_t e = in ? g.element(q[0], q[1], q[2]) : 0;
            if (in) sum += static_cast<double>(v.solid[e]);
            if (in && kind[e] == kSolid) continue;
            beside = beside || k == 1;
            break;
        }
    return {sum, beside};
}

/// Whether an element or one beside it is filled in part.
bool is_cut(const Grid& g, const Voxels& v, const std::array<int32_t, 3>& p) {
    constexpr float kPart = 0.02F;
    for (int32_t i = 0; i < 27; ++i) {
        const std::array<int32_t, 3> q{p[0] + i % 3 - 1, p[1] + i / 3 % 3 - 1, p[2] + i / 9 - 1};
        bool in = true;
        for (size_t a = 0; a < 3; ++a)
            in = in && q[a] >= 0 && q[a] < g.elements[a];
        const float share = in ? v.solid[g.element(q[0], q[1], q[2])] : 0;
        if (share > kPart && share < 1 - kPart) return true;
    }
    return false;
}

/// By which less than 3 % is left.
constexpr int32_t kMany = 27;

/// Of struts and plates that bend, whose elements are longer along them than across.
double long_excess(const Grid& g, const Voxels& v, std::span<const uint8_t> kind,
                   const std::array<int32_t, 3>& p) {
    // Measured of square rods: with elements of 4 to 1, eight across, 1.09; of 2 to 1, three across, 1.14.
    constexpr double kOfSquare = 0.5, kLittle = 1.01;
    const double longest = *std::ranges::max_element(g.pitch_mm);
    double out = 1;
    for (size_t axis = 0; axis < 3; ++axis) {
        const double own = g.pitch_mm[axis];
        const double thick = run_along(g, v, kind, p, axis, kMany).first * own;
        out = std::max(out, 1 + kOfSquare * (longest * longest - own * own) / (thick * thick));
    }
    return out > kLittle ? out : 1;
}

/// Of what elements are filled in part.
double part_excess(const Grid& g, const Voxels& v, std::span<const uint8_t> kind,
                   const std::array<int32_t, 3>& p) {
    if (!is_cut(g, v, p)) return 1;
    // Measured of round rods, bent and pressed: 1.25 with three elements across, 1.15 with four, 1.12 with six, 1.07
    // with eight.
    constexpr double kOfOne = 0.8;
    double inwards = 1e30, least = 1e30;
    for (size_t axis = 0; axis < 3; ++axis) {
        const auto [run, beside] = run_along(g, v, kind, p, axis, kMany);
        least = std::min(least, run);
        // A chord of what is round is less than it is thick.
        if (beside) inwards = std::min(inwards, run);
    }
    const double across = inwards < 1e30 ? inwards : least;
    return across < kMany ? 1 + kOfOne / across : 1;
}

}  // namespace

BlurredGaps blurred_gaps(const Grid& grid, const Voxels& voxels) {
    constexpr int32_t kLongest = 3;
    std::vector<uint8_t> blurred(voxels.count());
    const size_t stride[3] = {
        1, static_cast<size_t>(grid.elements[0]),
        static_cast<size_t>(grid.elements[0]) * static_cast<size_t>(grid.elements[1])};
    for (size_t axis = 0; axis < 3; ++axis) {
        std::array<int32_t, 3> lines = grid.elements;
        lines[axis] = 1;
        for_each_index(lines[2], [&](int32_t z) {
            for (int32_t y = 0; y < lines[1]; ++y) {
                for (int32_t x = 0; x < lines[0]; ++x) {
                    size_t e = grid.element(x, y, z);
                    int32_t run = kLongest + 1;  // of partly filled ones behind a full one
                    for (int32_t i = 0; i < grid.elements[axis]; ++i, e += stride[axis]) {
                        if (!(voxels.solid[e] > 0)) {
                            run = kLongest + 1;
                        } else if (voxels.solid[e] < kFull) {
                            ++run;
                        } else {
                            for (int32_t back = 1; run <= kLongest && back <= run; ++back)
                                blurred[e - static_cast<size_t>(back) * stride[axis]] = 1;
                            run = 0;
                        }
                    }
                }
            }
        });
    }
    BlurredGaps out;
    for (size_t e = blurred.size(); e-- > 0;) {
        if (blurred[e] == 0) continue;
        ++out.elements;
        out.first = e;
    }
    return out;
}

double cut_excess(const Grid& g, const Voxels& v, std::span<const uint8_t> kind, size_t element) {
    const std::array<int32_t, 3> p = place_of(g, static_cast<int64_t>(element));
    return part_excess(g, v, kind, p) * long_excess(g, v, kind, p);
}

std::vector<uint8_t> elements_across(const Grid& grid, const Voxels& voxels,
                                     std::span<const uint8_t> kind, bool dithered) {
    return Across(grid, voxels, kind, dithered).run();
}

}  // namespace openfab::mechanics

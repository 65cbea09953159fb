// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "inspection/thickness.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "base/principal_axes.h"
#include "inspection/sets.h"
#include "inspection/smooth.h"

namespace openfab::inspection {

namespace {

/// Half the side of the cube of gradients, in voxels.
constexpr int32_t kAround = 3;
/// Of a second or third axis to the first, from which on it counts: bodies whose faces meet at less than 53
/// degrees count as thin at their tips.
constexpr double kAcross = 0.25;
/// The least cosine between a direction and the normals of the two faces that it leads to.
constexpr double kFacing = 0.85;
constexpr float kLong = 1e30f;

struct Axes {
    std::array<double, 3> values;  ///< falling
    std::array<Vec3d, 3> axes;
};

/// The axes of a symmetric matrix (xx, yy, zz, xy, xz, yz).
Axes axes_of(const std::array<double, 6>& m) {
    double a[3][3] = {{m[0], m[3], m[4]}, {m[3], m[1], m[5]}, {m[4], m[5], m[2]}};
    double v[3][3];
    constexpr int kSweeps = 12;
    principal_axes(a, v, 0, kSweeps);
    std::array<int, 3> order{0, 1, 2};
    std::sort(order.begin(), order.end(), [&](int i, int j) { return a[i][i] > a[j][j]; });
    Axes out{};
    for (size_t i = 0; i < 3; ++i) {
        const int k = order[i];
        out.values[i] = a[k][k];
        out.axes[i] = {v[k][0], v[k][1], v[k][2]};
    }
    return out;
}

class Measure {
  public:
    Measure(const Bits& bits, int outside, const Vec3d& pitch_mm)
        : bits_(bits), outside_(outside), pitch_mm_(pitch_mm), smooth_(smooth(bits, outside)) {}

    /// Whether a voxel is set and touches one that is not.
    bool on_surface(int32_t x, int32_t y, int32_t z) const {
        if (bits_.values[bits_.at(x, y, z)] == 0) return false;
        constexpr int kSides[6][3] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                      {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
        return std::any_of(std::begin(kSides), std::end(kSides), [&](const int* d) {
            const int32_t i = x + d[0], j = y + d[1], k = z + d[2];
            return (bits_.holds(i, j, k) ? bits_.values[bits_.at(i, j, k)] : outside_) == 0;
        });
    }

    /// Returns the thickness along one direction, and the least of two or three, kLong where they are
    /// longer than `most_mm`.
    std::array<float, 2> at(int32_t x, int32_t y, int32_t z, double most_mm) const {
        const Axes found = axes_of(gradients(x, y, z));
        if (!(found.values[0] > 0)) return {kLong, kLong};
        size_t count = 1;
        while (count < 3 && found.values[count] > kAcross * found.values[0])
            ++count;
        double least = kLong;
        for (size_t i = 0; i < count; ++i) {
            const double here = across({x + 0.5, y + 0.5, z + 0.5}, found.axes[i], most_mm);
            if (here >= kLong) return {kLong, kLong};
            least = std::min(least, here);
        }
        const auto value = static_cast<float>(least);
        return count == 1 ? std::array{value, kLong} : std::array{kLong, value};
    }

  private:
    float voxel(int32_t x, int32_t y, int32_t z) const {
        if (!smooth_.holds(x, y, z)) return outside_ != 0 ? 1.0f : 0.0f;
        return static_cast<float>(smooth_.values[smooth_.at(x, y, z)]) * (1.0f / 255);
    }

    Vec3d gradient(int32_t i, int32_t j, int32_t k) const {
        return {(voxel(i + 1, j, k) - voxel(i - 1, j, k)) / pitch_mm_.x,
                (voxel(i, j + 1, k) - voxel(i, j - 1, k)) / pitch_mm_.y,
                (voxel(i, j, k + 1) - voxel(i, j, k - 1)) / pitch_mm_.z};
    }

    /// Whether the surface near a place looks along a direction of length 1.
    bool faces(const Vec3d& at_vox, const Vec3d& direction) const {
        const auto i = static_cast<int32_t>(std::floor(at_vox.x));
        const auto j = static_cast<int32_t>(std::floor(at_vox.y));
        const auto k = static_cast<int32_t>(std::floor(at_vox.z));
        Vec3d sum;
        for (int32_t c = 0; c < 27; ++c)
            sum = sum + gradient(i + c % 3 - 1, j + c / 3 % 3 - 1, k + c / 9 - 1);
        const double length = std::sqrt(sum.x * sum.x + sum.y * sum.y + sum.z * sum.z);
        // It falls outwards.
        return -(sum.x * direction.x + sum.y * direction.y + sum.z * direction.z) >=
               kFacing * length;
    }

    std::array<double, 6> gradients(int32_t x, int32_t y, int32_t z) const {
        std::array<double, 6> sum{};
        for (int32_t k = z - kAround; k <= z + kAround; ++k) {
            for (int32_t j = y - kAround; j <= y + kAround; ++j) {
                for (int32_t i = x - kAround; i <= x + kAround; ++i) {
                    const Vec3d g = gradient(i, j, k);
                    sum[0] += g.x * g.x, sum[1] += g.y * g.y, sum[2] += g.z * g.z;
                    sum[3] += g.x * g.y, sum[4] += g.x * g.z, sum[5] += g.y * g.z;
                }
            }
        }
        return sum;
    }

    double between(const Vec3d& at_vox) const {
        const double fx = at_vox.x - 0.5, fy = at_vox.y - 0.5, fz = at_vox.z - 0.5;
        const auto i = static_cast<int32_t>(std::floor(fx));
        const auto j = static_cast<int32_t>(std::floor(fy));
        const auto k = static_cast<int32_t>(std::floor(fz));
        const double u = fx - i, v = fy - j, w = fz - k;
        double sum = 0;
        for (int32_t c = 0; c < 8; ++c) {
            const double weight = ((c & 1) != 0 ? u : 1 - u) * ((c & 2) != 0 ? v : 1 - v) *
                                  ((c & 4) != 0 ? w : 1 - w);
            sum += weight * voxel(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2));
        }
        return sum;
    }

    /// Returns the length of what is set on the line through a place, in mm.
    double across(const Vec3d& place_vox, const Vec3d& axis_mm, double most_mm) const {
        const Vec3d vox{axis_mm.x / pitch_mm_.x, axis_mm.y / pitch_mm_.y, axis_mm.z / pitch_mm_.z};
        constexpr double kStepVox = 0.5;
        const double step_mm = kStepVox / std::sqrt(vox.x * vox.x + vox.y * vox.y + vox.z * vox.z);
        const double middle = between(place_vox);
        double sum = middle;
        for (const double side : {1.0, -1.0}) {
            double highest = middle, lowest = 2, face_mm = -1;
            for (int step = 1;; ++step) {
                const double t_mm = step * step_mm;
                const double value = between(place_vox + vox * (side * t_mm));
                constexpr double kNothing = 0.02, kRise = 0.03;
                if (value < 0.5 * highest && face_mm < 0) face_mm = t_mm - 0.5 * step_mm;
                if (value < kNothing) break;
                if (lowest < 0.5 * highest && value > lowest + kRise) break;  // the next body
                highest = std::max(highest, value);
                lowest = value < highest ? std::min(lowest, value) : 2;
                sum += value;
                if (sum * step_mm > most_mm) return kLong;
            }
            if (!faces(place_vox + vox * (side * face_mm), axis_mm * side)) return kLong;
        }
        return sum * step_mm;
    }

    const Bits& bits_;
    const int outside_;
    const Vec3d pitch_mm_;
    const Box<uint8_t> smooth_;
};

/// Places of the surface that are not thick, in order of z, y, x.
class Places {
  public:
    struct Place {
        Vec3i at;
        std::array<float, 2> thickness;
    };

    Places(const Measure& measure, const Vec3i& size, double most_mm) : size_(size) {
        std::vector<std::vector<Place>> by_slice(static_cast<size_t>(size.z));
        tbb::parallel_for(0, size.z, [&](int32_t z) {
            for (int32_t y = 0; y < size.y; ++y) {
                for (int32_t x = 0; x < size.x; ++x) {
                    if (!measure.on_surface(x, y, z)) continue;
                    const auto here = measure.at(x, y, z, most_mm);
                    if (here[0] < kLong || here[1] < kLong)
                        by_slice[static_cast<size_t>(z)].push_back({{x, y, z}, here});
                }
            }
        });
        for (const std::vector<Place>& slice : by_slice)
            all_.insert(all_.end(), slice.begin(), slice.end());
        rows_.resize(static_cast<size_t>(size.y) * static_cast<size_t>(size.z) + 1);
        for (const Place& place : all_)
            ++rows_[row(place.at.y, place.at.z) + 1];
        for (size_t i = 1; i < rows_.size(); ++i)
            rows_[i] += rows_[i - 1];
    }

    size_t size() const { return all_.size(); }
    const Place& operator[](size_t i) const { return all_[i]; }

    /// Calls `with` for the number of each place in the cube around one, itself among them.
    template <typename With>
    void for_near(const Vec3i& p, int32_t radius, const With& with) const {
        for (int32_t z = std::max(p.z - radius, 0); z <= std::min(p.z + radius, size_.z - 1); ++z) {
            for (int32_t y = std::max(p.y - radius, 0); y <= std::min(p.y + radius, size_.y - 1);
                 ++y) {
                const auto begin = all_.begin() + static_cast<ptrdiff_t>(rows_[row(y, z)]);
                const auto end = all_.begin() + static_cast<ptrdiff_t>(rows_[row(y, z) + 1]);
                auto one =
                    std::lower_bound(begin, end, p.x - radius,
                                     [](const Place& place, int32_t x) { return place.at.x < x; });
                for (; one != end && one->at.x <= p.x + radius; ++one)
                    with(static_cast<size_t>(one - all_.begin()));
            }
        }
    }

  private:
    size_t row(int32_t y, int32_t z) const {
        return static_cast<size_t>(z) * static_cast<size_t>(size_.y) + static_cast<size_t>(y);
    }

    Vec3i size_;
    std::vector<Place> all_;
    std::vector<size_t> rows_;  ///< where each begins
};

/// Finds what is thinner than `limit`, by the `kind`-th thickness. Single places are off by a few tenths of
/// a voxel; the mean of their neighbourhood is not.
std::vector<Thin> thin_of(const Places& places, size_t kind, double limit, const Vec3i& size,
                          double shortest_mm) {
    std::vector<float> means(places.size(), kLong);
    tbb::parallel_for(size_t{0}, places.size(), [&](size_t i) {
        if (places[i].thickness[kind] >= kLong) return;
        double sum = 0;
        int32_t count = 0;
        places.for_near(places[i].at, kAround, [&](size_t other) {
            if (places[other].thickness[kind] >= kLong) return;
            sum += static_cast<double>(places[other].thickness[kind]);
            ++count;
        });
        if (sum < limit * count) means[i] = static_cast<float>(sum / count);
    });
    Sets sets;
    for (size_t i = 0; i < places.size(); ++i)
        sets.add();
    for (size_t i = 0; i < places.size(); ++i) {
        if (means[i] >= kLong) continue;
        places.for_near(places[i].at, 1, [&](size_t other) {
            if (other < i && means[other] < kLong)
                sets.unite(static_cast<int32_t>(other), static_cast<int32_t>(i));
        });
    }
    // The two sides of a wall are one, as any of their places tell.
    constexpr size_t kSome = 5;
    for (size_t i = 0; i < places.size(); i += kSome) {
        if (means[i] >= kLong) continue;
        constexpr double kMostReach = 16;
        const double across = std::ceil(static_cast<double>(means[i]) / shortest_mm) + 1;
        places.for_near(places[i].at, static_cast<int32_t>(std::min(across, kMostReach)),
                        [&](size_t other) {
                            if (means[other] < kLong)
                                sets.unite(static_cast<int32_t>(other), static_cast<int32_t>(i));
                        });
    }
    std::vector<int32_t> number(places.size(), -1);
    std::vector<Thin> found;
    for (size_t i = 0; i < places.size(); ++i) {
        if (means[i] >= kLong) continue;
        int32_t& of = number[static_cast<size_t>(sets.find(static_cast<int32_t>(i)))];
        if (of < 0) {
            of = static_cast<int32_t>(found.size());
            found.emplace_back();
            found.back().in_all_ways = kind == 1;
        }
        Thin& thin = found[static_cast<size_t>(of)];
        thin.where.add(places[i].at, size);
        thin.voxels.push_back(places[i].at);
        thin.thickness_mm += static_cast<double>(means[i]);
    }
    constexpr int64_t kFewest = 3;
    std::erase_if(found, [](const Thin& thin) { return thin.where.voxels < kFewest; });
    for (Thin& thin : found)
        thin.thickness_mm /= static_cast<double>(thin.where.voxels);
    return found;
}

}  // namespace

std::vector<Thin> find_thin(const Bits& bits, int outside, const Vec3d& pitch_mm,
                            const ThinLimits& limits) {
    const double longest = std::max({pitch_mm.x, pitch_mm.y, pitch_mm.z});
    const std::array<double, 2> limit{limits.plate_mm - limits.slack_mm,
                                      limits.wire_mm - limits.slack_mm};
    std::vector<Thin> out;
    const double most_mm = std::max(limits.plate_mm, limits.wire_mm) + 2 * longest;
    if (!(std::max(limit[0], limit[1]) > 0)) return out;
    const Measure measure(bits, outside, pitch_mm);
    const Places places(measure, bits.size, most_mm);
    for (size_t kind = 0; kind < 2; ++kind) {
        if (!(limit[kind] > 0)) continue;
        std::vector<Thin> found = thin_of(places, kind, limit[kind], bits.size,
                                          std::min({pitch_mm.x, pitch_mm.y, pitch_mm.z}));
        std::move(found.begin(), found.end(), std::back_inserter(out));
    }
    return out;
}

}  // namespace openfab::inspection

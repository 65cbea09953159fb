// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/reference/dither.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "abi/dither_rules.h"
#include "abi/voxel_hash.h"
#include "runtime/dither/blue_noise.h"
#include "tests/support/reference/blue_noise.h"

namespace openfab::reference {

std::vector<uint16_t> normalise(std::span<const float> weights,
                                std::span<const int32_t> slot_material, int32_t materials,
                                int64_t* unusable) {
    const float infinity = std::numeric_limits<float>::infinity();
    std::vector<float> amounts;
    float total = 0;
    for (float w : weights) {
        if (!(w >= 0) && unusable != nullptr) ++*unusable;
        amounts.push_back(w > 0 ? w : 0);
        total += amounts.back();
    }
    // Larger sums use scaled-down amounts, so that nothing overflows.
    const float scale = total > 0x1p127f ? 0x1p-64f : 1.0f;
    std::vector<float> sums(static_cast<size_t>(materials) + 1, 0.0f);
    for (size_t s = 0; s < amounts.size(); ++s) {
        sums[slot_material[s]] += amounts[s] == infinity ? 0x1p100f : amounts[s] * scale;
    }
    float whole = 0;
    for (float sum : sums)
        whole += sum;

    std::vector<uint16_t> fractions(sums.size(), 0);
    if (!(whole > 0)) {
        fractions[0] = 65535;
        return fractions;
    }
    int32_t rest = 65535;
    size_t largest = 0;
    for (size_t m = 0; m < sums.size(); ++m) {
        const float share = 65535.0f * (sums[m] / whole);
        fractions[m] = static_cast<uint16_t>(std::floor(share + 0.5f));
        rest -= fractions[m];
        if (fractions[m] > fractions[largest]) largest = m;
    }
    fractions[largest] = static_cast<uint16_t>(fractions[largest] + rest);
    return fractions;
}

FractionField make_field(const Vec3i& size, int32_t materials) {
    FractionField field;
    field.size = size;
    field.channels = materials + 1;
    field.fractions.resize(static_cast<size_t>(size.x) * size.y * size.z * field.channels, 0);
    return field;
}

bool is_mixed(const uint16_t* fractions, int32_t channels) {
    int32_t positive = 0;
    for (int32_t m = 0; m < channels; ++m)
        positive += fractions[m] > 0 ? 1 : 0;
    return positive > 1;
}

namespace {

struct Neighbour {
    int32_t dx, dy;
    float weight;
};
constexpr Neighbour kForward[] = {{1, 0, 7.0f}, {-1, 1, 3.0f}, {0, 1, 5.0f}, {1, 1, 1.0f}};

int32_t pure_code(const uint16_t* fractions, int32_t channels) {
    for (int32_t m = 0; m < channels; ++m) {
        if (fractions[m] > 0) return m;
    }
    return 0;
}

/// Returns the first material at which the running sum of the fractions exceeds the threshold.
int32_t drawn_code(const uint16_t* fractions, int32_t channels, uint32_t threshold) {
    uint32_t sum = 0;
    for (int32_t m = 0; m < channels; ++m) {
        sum += fractions[m];
        if (sum > threshold) return m;
    }
    return channels - 1;
}

int32_t largest_code(const uint16_t* fractions, const float* value, int32_t channels) {
    int32_t best = -1;
    for (int32_t m = 0; m < channels; ++m) {
        if (fractions[m] > 0 && (best < 0 || value[m] > value[best])) best = m;
    }
    return best;
}

/// Returns the largest fraction; ties go to the first.
int32_t most_frequent(const uint16_t* fractions, int32_t channels) {
    return static_cast<int32_t>(std::max_element(fractions, fractions + channels) - fractions);
}

/// Draws a material in proportion to the excess of its value over the floor.
int32_t decorrelated_code(const uint16_t* fractions, const float* value, int32_t channels,
                          float floor, uint32_t hash) {
    std::vector<float> sums;
    float sum = 0;
    for (int32_t m = 0; m < channels; ++m) {
        if (fractions[m] > 0) {
            sum += std::max(value[m] - floor,
                            static_cast<float>(fractions[m]) * abi::kDecorrelatedLeast);
        }
        sums.push_back(sum);
    }
    const float threshold = static_cast<float>(hash >> 16) / 65536.0f * sum;
    int32_t code = 0;
    while (!(sums[code] > threshold))
        ++code;
    return code;
}

/// One slice: `value` starts as the fractions and accumulates errors.
class Slice {
  public:
    Slice(const FractionField& field, int32_t z, dither::DitherRule rule, uint32_t seed)
        : field_(field),
          rule_(rule),
          z_(z),
          seed_(seed),
          received_(static_cast<size_t>(field.size.x) * field.size.y, 0) {
        for (int32_t y = 0; y < field.size.y; ++y) {
            for (int32_t x = 0; x < field.size.x; ++x) {
                const uint16_t* f = field.at(x, y, z);
                value_.insert(value_.end(), f, f + field.channels);
            }
        }
    }

    uint8_t choose(int32_t x, int32_t y) {
        const uint16_t* fractions = field_.at(x, y, z_);
        if (!is_mixed(fractions, field_.channels))
            return static_cast<uint8_t>(pure_code(fractions, field_.channels));
        const Vec3i place{field_.origin.x + x, field_.origin.y + y, field_.origin.z + z_};
        if (rule_ == dither::DitherRule::kMajority)
            return static_cast<uint8_t>(most_frequent(fractions, field_.channels));
        if (rule_ == dither::DitherRule::kBlueNoise) {
            const int32_t threshold = blue_noise_threshold(place, face(x, y), seed_);
            return static_cast<uint8_t>(
                drawn_code(fractions, field_.channels, static_cast<uint32_t>(threshold)));
        }
        const int32_t code = rule_ == dither::DitherRule::kDecorrelated
                                 ? choose_decorrelated(x, y, fractions, hash_at(place))
                                 : choose_floyd_steinberg(x, y, fractions, hash_at(place));
        scatter(x, y);
        return static_cast<uint8_t>(code);
    }

  private:
    uint32_t hash_at(const Vec3i& place) const {
        return abi::voxel_hash<uint32_t>(static_cast<uint32_t>(place.x),
                                         static_cast<uint32_t>(place.y),
                                         static_cast<uint32_t>(place.z), seed_);
    }

    /// Returns the side that a voxel is on, if any.
    dither::BlueNoiseFace face(int32_t x, int32_t y) const {
        using enum dither::BlueNoiseFace;
        const bool low_x = !takes(x - 1, y), high_x = !takes(x + 1, y);
        const bool low_y = !takes(x, y - 1), high_y = !takes(x, y + 1);
        const auto side_x = low_x ? kLowX : kHighX, side_y = low_y ? kLowY : kHighY;
        if (!low_x && !high_x) return low_y || high_y ? side_y : kInside;
        if (low_x == high_x || low_y == high_y) return side_x;
        // An outer corner, whose border continues in two directions: the longer step is along x if
        // the border leaves it in y only.
        const int32_t out_x = low_x ? -1 : 1, out_y = low_y ? -1 : 1;
        return takes(x + out_x, y - out_y) && !takes(x - out_x, y + out_y) ? side_y : side_x;
    }

    int32_t choose_floyd_steinberg(int32_t x, int32_t y, const uint16_t* fractions, uint32_t hash) {
        float* value = value_at(x, y);
        const int32_t code =
            received_[index(x, y)] > 0
                ? largest_code(fractions, value, field_.channels)
                : drawn_code(fractions, field_.channels, abi::fraction_threshold(hash));
        value[code] -= 65535.0f;
        return code;
    }

    int32_t choose_decorrelated(int32_t x, int32_t y, const uint16_t* fractions, uint32_t hash) {
        float* value = value_at(x, y);
        const int32_t behind = received_[index(x, y)];
        const float floor = behind == 0   ? 0
                            : behind == 4 ? abi::kDecorrelatedInteriorFloor
                                          : abi::kDecorrelatedBorderFloor;
        const int32_t code = decorrelated_code(fractions, value, field_.channels, floor, hash);
        value[code] -= 65535.0f;
        if (behind > 0) return code;
        // A start has a random error in each material; the most frequent one compensates the
        // others.
        const int32_t most = most_frequent(fractions, field_.channels);
        int32_t sum = 0;
        for (int32_t m = 0; m < field_.channels; ++m) {
            if (fractions[m] == 0 || m == most) continue;
            const uint32_t random = abi::first_error_hash(hash, static_cast<uint64_t>(m)) >> 16;
            const int32_t phase = static_cast<int32_t>(random) - 32768;
            value[m] += static_cast<float>(phase);
            sum += phase;
        }
        value[most] -= static_cast<float>(sum);
        return code;
    }

    size_t index(int32_t x, int32_t y) const { return static_cast<size_t>(y) * field_.size.x + x; }
    float* value_at(int32_t x, int32_t y) { return &value_[index(x, y) * field_.channels]; }
    bool takes(int32_t x, int32_t y) const {
        return x >= 0 && y >= 0 && x < field_.size.x && y < field_.size.y &&
               is_mixed(field_.at(x, y, z_), field_.channels);
    }

    void scatter(int32_t x, int32_t y) {
        float weights = 0;
        for (const Neighbour& n : kForward)
            weights += takes(x + n.dx, y + n.dy) ? n.weight : 0;
        const float part = 1.0f / (weights > 1 ? weights : 1.0f);
        for (const Neighbour& n : kForward) {
            if (!takes(x + n.dx, y + n.dy)) continue;
            ++received_[index(x + n.dx, y + n.dy)];
            for (int32_t m = 0; m < field_.channels; ++m) {
                value_at(x + n.dx, y + n.dy)[m] += n.weight * (value_at(x, y)[m] * part);
            }
        }
    }

    const FractionField& field_;
    dither::DitherRule rule_;
    int32_t z_;
    uint32_t seed_;
    std::vector<int32_t> received_;  ///< previous neighbours that have passed on errors
    std::vector<float> value_;
};

}  // namespace

std::vector<uint8_t> dither(const FractionField& field, uint64_t seed, dither::DitherRule rule) {
    std::vector<uint8_t> codes;
    for (int32_t z = 0; z < field.size.z; ++z) {
        Slice slice(field, z, rule, abi::fold_seed(seed));
        for (int32_t y = 0; y < field.size.y; ++y) {
            for (int32_t x = 0; x < field.size.x; ++x)
                codes.push_back(slice.choose(x, y));
        }
    }
    return codes;
}

}  // namespace openfab::reference

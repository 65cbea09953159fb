// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/reference/dither.h"

#include <cmath>
#include <limits>

#include "runtime/abi/voxel_hash.h"

namespace openfab::reference {

std::vector<uint16_t> normalise(std::span<const float> weights,
                                std::span<const int32_t> slot_material, int32_t materials,
                                int64_t* unusable) {
    const float infinity = std::numeric_limits<float>::infinity();
    std::vector<float> amounts;
    float total = 0, peak = 0;
    for (float w : weights) {
        if (!(w >= 0) && unusable != nullptr) ++*unusable;
        amounts.push_back(w > 0 ? w : 0);
        total += amounts.back();
        if (amounts.back() > peak) peak = amounts.back();
    }
    // Sums this large are taken of amounts relative to the largest, so that nothing overflows.
    const float divisor = total > 0x1p127f ? peak : 1.0f;
    std::vector<float> sums(static_cast<size_t>(materials) + 1, 0.0f);
    for (size_t s = 0; s < amounts.size(); ++s) {
        sums[static_cast<size_t>(slot_material[s])] +=
            amounts[s] == infinity ? 1.0f : amounts[s] / divisor;
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

/// The first material at which the running sum of the fractions exceeds the hash of the place.
int32_t start_code(const uint16_t* fractions, int32_t channels, uint32_t hash) {
    const uint32_t threshold = abi::fraction_threshold(hash);
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

/// One slice: `value` starts as the fractions and gathers errors.
class Slice {
  public:
    Slice(const FractionField& field, int32_t z, uint32_t seed)
        : field_(field),
          z_(z),
          seed_(seed),
          received_(static_cast<size_t>(field.size.x) * field.size.y, false) {
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
        float* value = value_at(x, y);
        const uint32_t hash = abi::voxel_hash<uint32_t>(
            static_cast<uint32_t>(field_.origin.x + x), static_cast<uint32_t>(field_.origin.y + y),
            static_cast<uint32_t>(field_.origin.z + z_), seed_);
        const int32_t code = received_[index(x, y)]
                                 ? largest_code(fractions, value, field_.channels)
                                 : start_code(fractions, field_.channels, hash);
        value[code] -= 65535.0f;
        scatter(x, y);
        return static_cast<uint8_t>(code);
    }

  private:
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
            received_[index(x + n.dx, y + n.dy)] = true;
            for (int32_t m = 0; m < field_.channels; ++m) {
                value_at(x + n.dx, y + n.dy)[m] += n.weight * (value_at(x, y)[m] * part);
            }
        }
    }

    const FractionField& field_;
    int32_t z_;
    uint32_t seed_;
    std::vector<bool> received_;
    std::vector<float> value_;
};

}  // namespace

std::vector<uint8_t> dither(const FractionField& field, uint64_t seed) {
    std::vector<uint8_t> codes;
    for (int32_t z = 0; z < field.size.z; ++z) {
        Slice slice(field, z, abi::fold_seed(seed));
        for (int32_t y = 0; y < field.size.y; ++y) {
            for (int32_t x = 0; x < field.size.x; ++x)
                codes.push_back(slice.choose(x, y));
        }
    }
    return codes;
}

}  // namespace openfab::reference

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/slab/plain_dither.h"

#include <algorithm>
#include <limits>

#include "runtime/abi/dither_rules.h"
#include "runtime/abi/stage_table.h"
#include "runtime/abi/voxel_hash.h"
#include "runtime/slab/blue_noise.h"
#include "runtime/slab/stages.h"

namespace openfab::slab {

namespace {

constexpr int32_t kLanes = 8;
constexpr int32_t kMostChannels = OPENFAB_MAX_MATERIALS + 1;

// Values of one column of 8 voxels. Loops over lanes are written out innermost, so that compilers
// make vectors of them.
template <typename T>
struct Lanes {
    T at[kLanes];
};
using Floats = Lanes<float>;
using Ints = Lanes<int32_t>;

/// The fractions of a column: [material][lane].
const uint16_t* column_fractions(const DitherRow& row, int32_t i, int32_t channels) {
    const int64_t voxel = (int64_t{row.tiles[i / 8]} * 8 + (row.y & 7)) * 8 + i % 8;
    return row.fractions + voxel * channels * kLanes;
}

Lanes<uint32_t> column_hash(const DitherRow& row, int32_t i, uint32_t seed) {
    Lanes<uint32_t> hash;
    for (int32_t l = 0; l < kLanes; ++l) {
        hash.at[l] =
            abi::voxel_hash(static_cast<uint32_t>(row.first_x + i), static_cast<uint32_t>(row.y),
                            static_cast<uint32_t>(row.z + l), seed);
    }
    return hash;
}

/// The first material at which the running sum of the fractions exceeds the threshold; the last sum
/// is 65535 and always does.
Ints first_above(const uint16_t* fractions, int32_t channels, const Ints& threshold) {
    Ints sum{}, code{};
    for (int32_t m = 0; m + 1 < channels; ++m) {
        for (int32_t l = 0; l < kLanes; ++l) {
            sum.at[l] += fractions[m * kLanes + l];
            code.at[l] += sum.at[l] > threshold.at[l] ? 0 : 1;
        }
    }
    return code;
}

Ints largest(const uint16_t* fractions, int32_t channels) {
    Ints code{}, most{};
    for (int32_t m = 0; m < channels; ++m) {
        for (int32_t l = 0; l < kLanes; ++l) {
            const int32_t f = fractions[m * kLanes + l];
            code.at[l] = f > most.at[l] ? m : code.at[l];
            most.at[l] = std::max(f, most.at[l]);
        }
    }
    return code;
}

void write_codes(uint8_t* out, uint8_t mixed, const Ints& code) {
    for (int32_t l = 0; l < kLanes; ++l)
        out[l] = mixed >> l & 1 ? static_cast<uint8_t>(code.at[l]) : out[l];
}

/// One column of error diffusion: [material][lane].
struct Diffusion {
    const uint16_t* fractions = nullptr;
    int32_t channels = 0;
    uint8_t received = 0, interior = 0;  ///< a neighbour behind is mixed; all four are
    Lanes<uint32_t> hash;
    Floats value[kMostChannels];  ///< fractions with the errors received

    bool present(int32_t m, int32_t l) const { return fractions[m * kLanes + l] > 0; }
};

Ints floyd_steinberg(const Diffusion& d) {
    Floats best;
    Ints code{}, threshold;
    for (int32_t l = 0; l < kLanes; ++l) {
        best.at[l] = -std::numeric_limits<float>::infinity();
        threshold.at[l] = static_cast<int32_t>(abi::fraction_threshold(d.hash.at[l]));
    }
    for (int32_t m = 0; m < d.channels; ++m) {
        for (int32_t l = 0; l < kLanes; ++l) {
            const bool wins = d.present(m, l) && d.value[m].at[l] > best.at[l];
            code.at[l] = wins ? m : code.at[l];
            best.at[l] = wins ? d.value[m].at[l] : best.at[l];
        }
    }
    const Ints start = first_above(d.fractions, d.channels, threshold);
    for (int32_t l = 0; l < kLanes; ++l)
        code.at[l] = d.received >> l & 1 ? code.at[l] : start.at[l];
    return code;
}

// A start's phase: all present materials but the most frequent get a random one, which that one
// takes back.
void add_phase(Diffusion* d) {
    const Ints most = largest(d->fractions, d->channels);
    Ints all{};
    for (int32_t m = 0; m < d->channels; ++m) {
        for (int32_t l = 0; l < kLanes; ++l) {
            if (!d->present(m, l) || most.at[l] == m || (d->received >> l & 1) != 0) continue;
            const uint32_t hash = abi::phase_hash(d->hash.at[l], static_cast<uint64_t>(m));
            const int32_t phase = static_cast<int32_t>(hash >> 16) - 32768;
            all.at[l] += phase;
            d->value[m].at[l] += static_cast<float>(phase);
        }
    }
    for (int32_t l = 0; l < kLanes; ++l)
        d->value[most.at[l]].at[l] += static_cast<float>(-all.at[l]);
}

Ints decorrelated(const Diffusion& d) {
    Floats floor, sum[kMostChannels], total{}, threshold;
    for (int32_t l = 0; l < kLanes; ++l) {
        floor.at[l] = (d.received >> l & 1) == 0   ? 0.0f
                      : (d.interior >> l & 1) != 0 ? abi::kDecorrelatedInteriorFloor
                                                   : abi::kDecorrelatedBorderFloor;
    }
    for (int32_t m = 0; m < d.channels; ++m) {
        for (int32_t l = 0; l < kLanes; ++l) {
            const float above = d.value[m].at[l] - floor.at[l];
            const float least =
                static_cast<float>(d.fractions[m * kLanes + l]) * abi::kDecorrelatedLeast;
            total.at[l] += !d.present(m, l) ? 0.0f : above > least ? above : least;
            sum[m].at[l] = total.at[l];
        }
    }
    for (int32_t l = 0; l < kLanes; ++l)
        threshold.at[l] = static_cast<float>(d.hash.at[l] >> 16) * 0x1p-16f * total.at[l];
    Ints code{};
    for (int32_t m = 0; m + 1 < d.channels; ++m) {
        for (int32_t l = 0; l < kLanes; ++l)
            code.at[l] += sum[m].at[l] > threshold.at[l] ? 0 : 1;
    }
    return code;
}

Floats weights(uint8_t mixed, float weight) {
    Floats w;
    for (int32_t l = 0; l < kLanes; ++l)
        w.at[l] = mixed >> l & 1 ? weight : 0.0f;
    return w;
}

}  // namespace

void pick_row(DitherRule rule, const DitherRow& row, int32_t channels, uint32_t seed) {
    for (int32_t i = 0; i < 8 * row.blocks; ++i) {
        if (row.here[i] == 0) continue;
        const uint16_t* fractions = column_fractions(row, i, channels);
        Ints code;
        if (rule == DitherRule::kMajority) {
            code = largest(fractions, channels);
        } else {
            const uint32_t rank = blue_noise_rank(row.first_x + i, row.y, seed);
            Ints threshold;
            for (int32_t l = 0; l < kLanes; ++l)
                threshold.at[l] = blue_noise_threshold(rank, row.z + l);
            code = first_above(fractions, channels, threshold);
        }
        write_codes(row.codes + int64_t{i} * kLanes, row.here[i], code);
    }
}

void diffuse_row(DitherRule rule, const DitherRow& row, int32_t channels, uint32_t seed,
                 float* errors, int32_t width) {
    const int64_t voxel_values = int64_t{channels} * kLanes;
    const int64_t row_values = (width + 2 * kRowMargin) * voxel_values;
    const int64_t first = (row.first_x + kRowMargin) * voxel_values;
    float* own = errors + (row.y & 1) * row_values + first;
    const float* behind = errors + (1 - (row.y & 1)) * row_values + first;
    Diffusion d;
    d.channels = channels;
    for (int64_t i = 0; i < 8 * row.blocks; ++i) {
        if (row.here[i] == 0) continue;
        d.fractions = column_fractions(row, static_cast<int32_t>(i), channels);
        d.hash = column_hash(row, static_cast<int32_t>(i), seed);
        const uint8_t e = row.here[i - 1], se = row.above[i - 1], s = row.above[i],
                      sw = row.above[i + 1];
        d.received = e | se | s | sw;
        d.interior = e & se & s & sw;
        const Floats w_e = weights(e, 7), w_se = weights(se, 1), w_s = weights(s, 5),
                     w_sw = weights(sw, 3);
        for (int32_t m = 0; m < channels; ++m) {
            const float* up = behind + i * voxel_values + m * kLanes;
            const float* left = own + (i - 1) * voxel_values + m * kLanes;
            for (int32_t l = 0; l < kLanes; ++l) {
                float v = static_cast<float>(d.fractions[m * kLanes + l]);
                v = v + w_se.at[l] * up[l - voxel_values];
                v = v + w_s.at[l] * up[l];
                v = v + w_sw.at[l] * up[l + voxel_values];
                d.value[m].at[l] = v + w_e.at[l] * left[l];
            }
        }
        const bool plain = rule == DitherRule::kFloydSteinberg;
        const Ints code = plain ? floyd_steinberg(d) : decorrelated(d);
        for (int32_t l = 0; l < kLanes; ++l)
            d.value[code.at[l]].at[l] -= 65535.0f;
        if (!plain && d.received != 255) add_phase(&d);
        const Floats ahead[] = {weights(row.here[i + 1], 7), weights(row.below[i - 1], 3),
                                weights(row.below[i], 5), weights(row.below[i + 1], 1)};
        Floats hand_on;
        for (int32_t l = 0; l < kLanes; ++l) {
            const float sum = ahead[0].at[l] + ahead[1].at[l] + ahead[2].at[l] + ahead[3].at[l];
            hand_on.at[l] = 1.0f / std::max(sum, 1.0f);
        }
        float* out = own + i * voxel_values;
        for (int32_t m = 0; m < channels; ++m) {
            for (int32_t l = 0; l < kLanes; ++l)
                out[m * kLanes + l] = d.value[m].at[l] * hand_on.at[l];
        }
        write_codes(row.codes + i * kLanes, row.here[i], code);
    }
}

}  // namespace openfab::slab

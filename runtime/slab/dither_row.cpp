// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/slab/dither_row.h"

#include <limits>

#include "runtime/abi/dither_rules.h"
#include "runtime/abi/stage_table.h"
#include "runtime/abi/voxel_hash.h"
#include "runtime/slab/blue_noise.h"
#include "runtime/slab/lanes.h"

namespace openfab::slab {

namespace {

constexpr int32_t kMostChannels = OPENFAB_MAX_MATERIALS + 1;

/// One column of 8 voxels.
struct Column {
    const uint16_t* fractions = nullptr;  ///< [material][lane]
    int32_t channels = 0;
    Ints received, interior;  ///< a neighbour behind is mixed; all four are
    bool all_received = false;
    Hashes hash = Hashes(0);
    Floats value[kMostChannels];  ///< fractions with the errors received
};

OPENFAB_INLINE Hashes column_hash(const DitherSetup& setup, const DitherRow& row, int32_t i) {
    constexpr Hashes::Vector kAbove{0, 1, 2, 3, 4, 5, 6, 7};
    const uint32_t xy = abi::column_hash(static_cast<uint32_t>(row.first_x + i),
                                         static_cast<uint32_t>(row.y), setup.seed);
    return abi::mix32(Hashes(xy) ^ Hashes(static_cast<uint32_t>(row.z) + kAbove));
}

/// The first material at which the running sum of the fractions exceeds the threshold; the last sum
/// is 65535 and always does.
OPENFAB_INLINE Ints first_above(const uint16_t* fractions, int32_t channels,
                                const Ints& threshold) {
    Ints sum{}, code{};
    for (int32_t m = 0; m + 1 < channels; ++m) {
        sum += load(fractions + m * kLanes);
        code -= sum <= threshold;
    }
    return code;
}

/// The most frequent material, the first of equals.
OPENFAB_INLINE Ints largest(const uint16_t* fractions, int32_t channels) {
    Ints code{}, most{};
    for (int32_t m = 0; m < channels; ++m) {
        const Ints fraction = load(fractions + m * kLanes);
        const Ints more = fraction > most;
        code = more ? Ints{} + m : code;
        most = more ? fraction : most;
    }
    return code;
}

/// Floyd and Steinberg 1976: the largest value wins, the first of equals, among materials that are
/// present; where nothing was received, the hash decides.
OPENFAB_INLINE Ints floyd_steinberg(const Column& c) {
    Floats best = Floats{} - std::numeric_limits<float>::infinity();
    Ints code{};
    for (int32_t m = 0; m < c.channels; ++m) {
        const Ints wins = (load(c.fractions + m * kLanes) > 0) & (c.value[m] > best);
        code = wins ? Ints{} + m : code;
        best = wins ? c.value[m] : best;
    }
    if (c.all_received) return code;
    const Ints start = first_above(c.fractions, c.channels, abi::fraction_threshold(c.hash).ints());
    return c.received ? code : start;
}

/// The first material at which the running sum of what each value has above a floor exceeds a
/// random share of the whole sum. Why the floor is what it is: abi/dither_rules.h.
OPENFAB_INLINE Ints decorrelated(const Column& c) {
    const Floats floor = c.received ? (c.interior ? Floats{} + abi::kDecorrelatedInteriorFloor
                                                  : Floats{} + abi::kDecorrelatedBorderFloor)
                                    : Floats{};
    Floats sum[kMostChannels], total{};
    for (int32_t m = 0; m < c.channels; ++m) {
        const Ints fraction = load(c.fractions + m * kLanes);
        const Floats above = c.value[m] - floor;
        const Floats least = to_floats(fraction) * abi::kDecorrelatedLeast;
        const Floats weight = above > least ? above : least;
        total += fraction > 0 ? weight : Floats{};
        sum[m] = total;
    }
    const Floats share = to_floats((c.hash >> Hashes(16)).ints()) * 0x1p-16f;
    const Floats threshold = share * total;
    Ints code{};
    for (int32_t m = 0; m + 1 < c.channels; ++m)
        code -= sum[m] <= threshold;
    return code;
}

/// A start's phase: all present materials but the most frequent get a random one, which that one
/// takes back.
OPENFAB_INLINE void add_phase(Column* c) {
    const Ints most = largest(c->fractions, c->channels);
    Ints all{};
    for (int32_t m = 0; m < c->channels; ++m) {
        const Ints gets = (load(c->fractions + m * kLanes) > 0) & (most != m) & ~c->received;
        const Ints random =
            (abi::phase_hash(c->hash, static_cast<uint64_t>(m)) >> Hashes(16)).ints() - 32768;
        const Ints phase = gets & random;
        all += phase;
        c->value[m] += to_floats(phase);
    }
    for (int32_t m = 0; m < c->channels; ++m)
        c->value[m] -= to_floats((most == m) & all);
}

OPENFAB_INLINE void write_codes(uint8_t* out, uint8_t mixed, const Ints& code) {
    Bytes before;
    std::memcpy(&before, out, sizeof before);
    const Ints after = lanes_of(mixed) ? code : __builtin_convertvector(before, Ints);
    const Bytes bytes = __builtin_convertvector(after, Bytes);
    std::memcpy(out, &bytes, sizeof bytes);
}

/// The fractions of the run's i-th column.
OPENFAB_INLINE const uint16_t* column_fractions(const DitherRow& row, int32_t i, int32_t channels) {
    const int64_t voxel = (int64_t{row.tiles[i / 8]} * 8 + (row.y & 7)) * 8 + i % 8;
    return row.fractions + voxel * channels * kLanes;
}

/// Rules for which no voxel knows its neighbours.
template <DitherRule rule>
OPENFAB_INLINE void pick_row(const DitherSetup& setup, const DitherRow& row) {
    for (int32_t i = 0; i < 8 * row.blocks; ++i) {
        if (row.here[i] == 0) continue;
        const uint16_t* fractions = column_fractions(row, i, setup.channels);
        Ints code;
        if constexpr (rule == DitherRule::kMajority) {
            code = largest(fractions, setup.channels);
        } else {
            const uint32_t rank = blue_noise_rank(row.first_x + i, row.y, setup.seed);
            Ints threshold;
            for (int32_t l = 0; l < kLanes; ++l)
                threshold[l] = blue_noise_threshold(rank, row.z + l);
            code = first_above(fractions, setup.channels, threshold);
        }
        write_codes(row.codes + int64_t{i} * kLanes, row.here[i], code);
    }
}

// Error diffusion with the zero rule, in gather form. Each mixed voxel leaves what it could not
// place, divided by the weights of those forward neighbours that are mixed; a later voxel takes 7,
// 3, 5 or 1 parts of that from its own neighbours behind it, if they are mixed. The masks alone
// decide who takes from whom, so what stands in `errors` at a voxel that is not mixed never matters
// as long as it is finite.
//
// Fractions and errors are counted in 1/65535. The order of the float operations, which the twin
// follows, is
//     v = (((fraction + w_se * e_se) + w_s * e_s) + w_sw * e_sw) + w_e * e_e
//     e = ((v - (chosen ? 65535 : 0)) [+ phase]) * (1 / max(w_forward, 1))
// with w_e last because only that term waits for the voxel just before in the row.
template <DitherRule rule>
OPENFAB_INLINE void diffuse_row(const DitherSetup& setup, const DitherRow& row, float* errors) {
    const int32_t channels = setup.channels;
    const int64_t voxel_values = int64_t{channels} * kLanes;
    const int64_t row_values = (setup.width + 2 * kRowMargin) * voxel_values;
    const int64_t first = (row.first_x + kRowMargin) * voxel_values;
    float* own = errors + (row.y & 1) * row_values + first;
    const float* behind = errors + (1 - (row.y & 1)) * row_values + first;
    Column c;
    c.channels = channels;
    for (int32_t i = 0; i < 8 * row.blocks; ++i) {
        if (row.here[i] == 0) continue;
        c.fractions = column_fractions(row, i, channels);
        c.hash = column_hash(setup, row, i);
        const uint8_t e = row.here[i - 1], se = row.above[i - 1], s = row.above[i],
                      sw = row.above[i + 1];
        const auto received = static_cast<uint8_t>(e | se | s | sw);
        c.received = lanes_of(received);
        c.interior = lanes_of(e & se & s & sw);
        c.all_received = (row.here[i] & ~received) == 0;
        const Floats w_e = masked(lanes_of(e), 7), w_se = masked(lanes_of(se), 1),
                     w_s = masked(lanes_of(s), 5), w_sw = masked(lanes_of(sw), 3);
        const float* up = behind + i * voxel_values;
        float* here = own + i * voxel_values;
        for (int32_t m = 0; m < channels; ++m) {
            const int32_t k = m * kLanes;
            Floats v = to_floats(load(c.fractions + k));
            v = v + w_se * load(up + k - voxel_values);
            v = v + w_s * load(up + k);
            v = v + w_sw * load(up + k + voxel_values);
            c.value[m] = v + w_e * load(here + k - voxel_values);
        }
        const Ints code =
            rule == DitherRule::kFloydSteinberg ? floyd_steinberg(c) : decorrelated(c);
        const Floats ahead =
            masked(lanes_of(row.here[i + 1]), 7) + masked(lanes_of(row.below[i - 1]), 3) +
            masked(lanes_of(row.below[i]), 5) + masked(lanes_of(row.below[i + 1]), 1);
        const Floats hand_on = 1.0f / (ahead > 1.0f ? ahead : Floats{} + 1.0f);
        for (int32_t m = 0; m < channels; ++m)
            c.value[m] -= masked(code == m, 65535.0f);
        if (rule == DitherRule::kDecorrelated && !c.all_received) add_phase(&c);
        for (int32_t m = 0; m < channels; ++m)
            store(here + m * kLanes, c.value[m] * hand_on);
        write_codes(row.codes + int64_t{i} * kLanes, row.here[i], code);
    }
}

OPENFAB_INLINE void any_row(const DitherSetup& setup, const DitherRow& row, float* errors) {
    switch (setup.rule) {
        case DitherRule::kFloydSteinberg:
            return diffuse_row<DitherRule::kFloydSteinberg>(setup, row, errors);
        case DitherRule::kDecorrelated:
            return diffuse_row<DitherRule::kDecorrelated>(setup, row, errors);
        case DitherRule::kBlueNoise:
            return pick_row<DitherRule::kBlueNoise>(setup, row);
        case DitherRule::kMajority:
            return pick_row<DitherRule::kMajority>(setup, row);
    }
}

// `flatten`: what they call is inlined, so it is compiled for their instruction set.
__attribute__((target("avx2"), flatten)) void row_avx2(const DitherSetup& setup,
                                                       const DitherRow& row, float* errors) {
    any_row(setup, row, errors);
}

__attribute__((target("sse4.1"), flatten)) void row_sse41(const DitherSetup& setup,
                                                          const DitherRow& row, float* errors) {
    any_row(setup, row, errors);
}

}  // namespace

size_t error_count(const DitherSetup& setup) {
    if (setup.rule != DitherRule::kFloydSteinberg && setup.rule != DitherRule::kDecorrelated)
        return 0;
    return 2 * static_cast<size_t>(setup.width + 2 * kRowMargin) *
           static_cast<size_t>(setup.channels * kLanes);
}

void dither_row(const DitherSetup& setup, const DitherRow& row, float* errors) {
    (setup.isa == OPENFAB_ISA_AVX2 ? row_avx2 : row_sse41)(setup, row, errors);
}

}  // namespace openfab::slab

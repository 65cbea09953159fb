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

/// Some of the 8 voxels of a column, from slice `first` of the group on.
template <typename L>
struct Column {
    const uint16_t* fractions = nullptr;  ///< [material][slice], at `first`
    int32_t channels = 0;
    typename L::Ints received,
        interior;  ///< a neighbour behind is mixed; all four are
    bool all_received = false;
    typename L::Hashes hash = typename L::Hashes(0);
    typename L::Floats value[kMostChannels];  ///< fractions with the errors received

    OPENFAB_INLINE typename L::Ints fraction(int32_t m) const {
        return L::load(fractions + m * kSlices);
    }
};

/// The first material at which the running sum of the fractions exceeds the
/// threshold; the last sum is 65535 and always does.
template <typename L>
OPENFAB_INLINE typename L::Ints first_above(const uint16_t* fractions, int32_t channels,
                                            const typename L::Ints& threshold) {
    typename L::Ints sum{}, code{};
    for (int32_t m = 0; m + 1 < channels; ++m) {
        sum += L::load(fractions + m * kSlices);
        code -= sum <= threshold;
    }
    return code;
}

/// The most frequent material, the first of equals.
template <typename L>
OPENFAB_INLINE typename L::Ints largest(const uint16_t* fractions, int32_t channels) {
    typename L::Ints code{}, most{};
    for (int32_t m = 0; m < channels; ++m) {
        const typename L::Ints fraction = L::load(fractions + m * kSlices);
        const typename L::Ints more = fraction > most;
        code = more ? L::all(m) : code;
        most = more ? fraction : most;
    }
    return code;
}

/// Floyd and Steinberg 1976: the largest value wins, the first of equals, among
/// materials that are present; where nothing was received, the hash decides.
template <typename L>
OPENFAB_INLINE typename L::Ints floyd_steinberg(const Column<L>& c) {
    typename L::Floats best = L::all(-std::numeric_limits<float>::infinity());
    typename L::Ints code{};
    for (int32_t m = 0; m < c.channels; ++m) {
        const typename L::Ints wins = (c.fraction(m) > 0) & (c.value[m] > best);
        code = wins ? L::all(m) : code;
        best = wins ? c.value[m] : best;
    }
    if (c.all_received) return code;
    const typename L::Ints threshold = abi::fraction_threshold(c.hash).ints();
    return c.received ? code : first_above<L>(c.fractions, c.channels, threshold);
}

/// The first material at which the running sum of what each value has above a
/// floor exceeds a random share of the whole sum. Why the floor is what it is:
/// abi/dither_rules.h.
template <typename L, bool inside>
OPENFAB_INLINE typename L::Ints decorrelated(const Column<L>& c) {
    using Floats = typename L::Floats;
    const Floats with_some = c.interior ? L::all(abi::kDecorrelatedInteriorFloor)
                                        : L::all(abi::kDecorrelatedBorderFloor);
    const Floats floor = inside       ? L::all(abi::kDecorrelatedInteriorFloor)
                         : c.received ? with_some
                                      : Floats{};
    Floats sum[kMostChannels], total{};
    for (int32_t m = 0; m < c.channels; ++m) {
        const typename L::Ints fraction = c.fraction(m);
        const Floats above = c.value[m] - floor;
        const Floats least = L::to_floats(fraction) * abi::kDecorrelatedLeast;
        const Floats weight = above > least ? above : least;
        total += fraction > 0 ? weight : Floats{};
        sum[m] = total;
    }
    const Floats share = L::to_floats((c.hash >> typename L::Hashes(16)).ints()) * 0x1p-16f;
    const Floats threshold = share * total;
    typename L::Ints code{};
    for (int32_t m = 0; m + 1 < c.channels; ++m)
        code -= sum[m] <= threshold;
    return code;
}

/// A start's phase: all present materials but the most frequent get a random
/// one, which that one takes back.
template <typename L>
OPENFAB_INLINE void add_phase(Column<L>* c) {
    using Ints = typename L::Ints;
    const Ints most = largest<L>(c->fractions, c->channels);
    Ints all{};
    for (int32_t m = 0; m < c->channels; ++m) {
        const Ints gets = (c->fraction(m) > 0) & (most != m) & ~c->received;
        const auto hash = abi::phase_hash(c->hash, static_cast<uint64_t>(m));
        const Ints phase = gets & ((hash >> typename L::Hashes(16)).ints() - 32768);
        all += phase;
        c->value[m] += L::to_floats(phase);
    }
    for (int32_t m = 0; m < c->channels; ++m)
        c->value[m] -= L::to_floats((most == m) & all);
}

/// The fractions of the run's i-th column.
OPENFAB_INLINE const uint16_t* column_fractions(const DitherRow& row, int32_t i, int32_t channels) {
    const int64_t voxel = (int64_t{row.tiles[i / 8]} * 8 + (row.y & 7)) * 8 + i % 8;
    return row.fractions + voxel * channels * kSlices;
}

template <typename L>
OPENFAB_INLINE void write_codes(const DitherRow& row, int32_t i, int32_t first,
                                const typename L::Ints& code) {
    uint8_t* out = row.codes + int64_t{i} * kSlices + first;
    L::store(out, L::from_bits(row.here[i], first) ? code : L::load(out));
}

template <typename L, bool inside>
OPENFAB_INLINE typename L::Floats edge_weight(uint8_t mixed, int32_t first, float weight) {
    if constexpr (inside) return L::all(weight);
    return L::masked(L::from_bits(mixed, first), weight);
}

/// Rules for which no voxel knows its neighbours.
template <typename L, DitherRule rule>
OPENFAB_INLINE void pick_row(const DitherSetup& setup, const DitherRow& row) {
    for (int32_t i = 0; i < 8 * row.blocks; ++i) {
        if (row.here[i] == 0) continue;
        const uint16_t* fractions = column_fractions(row, i, setup.channels);
        const uint32_t rank = blue_noise_rank(row.first_x + i, row.y, setup.seed);
        for (int32_t first = 0; first < kSlices; first += L::kCount) {
            typename L::Ints code;
            if constexpr (rule == DitherRule::kMajority) {
                code = largest<L>(fractions + first, setup.channels);
            } else {
                typename L::Ints threshold;
                for (int32_t l = 0; l < L::kCount; ++l)
                    threshold[l] = blue_noise_threshold(rank, row.z + first + l);
                code = first_above<L>(fractions + first, setup.channels, threshold);
            }
            write_codes<L>(row, i, first, code);
        }
    }
}

// Error diffusion with the zero rule, in gather form. Each mixed voxel leaves
// what it could not place, divided by the weights of those forward neighbours
// that are mixed; a later voxel takes 7, 3, 5 or 1 parts of that from its own
// neighbours behind it, if they are mixed. The masks alone decide who takes
// from whom, so what stands in `errors` at a voxel that is not mixed never
// matters as long as it is finite.
//
// Fractions and errors are counted in 1/65535. The order of the float
// operations, which the twin follows, is
//     v = (((fraction + w_se * e_se) + w_s * e_s) + w_sw * e_sw) + w_e * e_e
//     e = ((v - (chosen ? 65535 : 0)) [+ phase]) * (1 / max(w_forward, 1))
// with w_e last because only that term waits for the voxel just before in the
// row.
//
// `up` and `here` are the errors of the rows above and here,
// [x][material][slice], at column i and slice `first`. `inside`: the voxel and
// all around it are mixed, in all 8 slices; the weights are the same numbers
// then, and need no masks.
template <typename L, DitherRule rule, bool inside>
OPENFAB_INLINE void diffuse_column(const DitherSetup& setup, const DitherRow& row, int32_t i,
                                   int32_t first, uint32_t hash, const float* up, float* here) {
    using Floats = typename L::Floats;
    const int32_t channels = setup.channels;
    const int64_t next = int64_t{channels} * kSlices;
    const uint8_t e = row.here[i - 1], se = row.above[i - 1], s = row.above[i],
                  sw = row.above[i + 1];
    const int32_t received = e | se | s | sw;
    Column<L> c;
    c.fractions = column_fractions(row, i, channels) + first;
    c.channels = channels;
    c.hash = abi::mix32(typename L::Hashes(hash) ^
                        typename L::Hashes(typename L::Unsigned(L::count() + row.z + first)));
    c.received = L::from_bits(received, first);
    c.interior = L::from_bits(e & se & s & sw, first);
    c.all_received = inside || (row.here[i] & ~received) == 0;
    const Floats w_e = edge_weight<L, inside>(e, first, 7),
                 w_se = edge_weight<L, inside>(se, first, 1),
                 w_s = edge_weight<L, inside>(s, first, 5),
                 w_sw = edge_weight<L, inside>(sw, first, 3);
    for (int32_t m = 0; m < channels; ++m) {
        const int32_t k = m * kSlices;
        Floats v = L::to_floats(c.fraction(m));
        v = v + w_se * L::load(up + k - next);
        v = v + w_s * L::load(up + k);
        v = v + w_sw * L::load(up + k + next);
        c.value[m] = v + w_e * L::load(here + k - next);
    }
    const typename L::Ints code =
        rule == DitherRule::kFloydSteinberg ? floyd_steinberg(c) : decorrelated<L, inside>(c);
    const Floats ahead = edge_weight<L, inside>(row.here[i + 1], first, 7) +
                         edge_weight<L, inside>(row.below[i - 1], first, 3) +
                         edge_weight<L, inside>(row.below[i], first, 5) +
                         edge_weight<L, inside>(row.below[i + 1], first, 1);
    const Floats hand_on =
        inside ? L::all(1.0f / 16) : 1.0f / (ahead > 1.0f ? ahead : L::all(1.0f));
    for (int32_t m = 0; m < channels; ++m)
        c.value[m] -= L::masked(code == m, 65535.0f);
    if (rule == DitherRule::kDecorrelated && !c.all_received) add_phase(&c);
    for (int32_t m = 0; m < channels; ++m)
        L::store(here + m * kSlices, c.value[m] * hand_on);
    write_codes<L>(row, i, first, code);
}

template <typename L, DitherRule rule>
OPENFAB_INLINE void diffuse_row(const DitherSetup& setup, const DitherRow& row, float* errors) {
    const int64_t voxel_values = int64_t{setup.channels} * kSlices;
    const int64_t row_values = (setup.width + 2 * kRowMargin) * voxel_values;
    const int64_t begin = (row.first_x + kRowMargin) * voxel_values;
    float* own = errors + (row.y & 1) * row_values + begin;
    const float* behind = errors + (1 - (row.y & 1)) * row_values + begin;
    for (int32_t i = 0; i < 8 * row.blocks; ++i) {
        if (row.here[i] == 0) continue;
        const uint32_t hash = abi::column_hash(static_cast<uint32_t>(row.first_x + i),
                                               static_cast<uint32_t>(row.y), setup.seed);
        const bool inside =
            (row.above[i - 1] & row.above[i] & row.above[i + 1] & row.here[i - 1] & row.here[i] &
             row.here[i + 1] & row.below[i - 1] & row.below[i] & row.below[i + 1]) == 255;
        for (int32_t first = 0; first < kSlices; first += L::kCount) {
            const float* up = behind + i * voxel_values + first;
            float* here = own + i * voxel_values + first;
            if (inside) {
                diffuse_column<L, rule, true>(setup, row, i, first, hash, up, here);
            } else {
                diffuse_column<L, rule, false>(setup, row, i, first, hash, up, here);
            }
        }
    }
}

template <typename L>
OPENFAB_INLINE void any_row(const DitherSetup& setup, const DitherRow& row, float* errors) {
    switch (setup.rule) {
        case DitherRule::kFloydSteinberg:
            return diffuse_row<L, DitherRule::kFloydSteinberg>(setup, row, errors);
        case DitherRule::kDecorrelated:
            return diffuse_row<L, DitherRule::kDecorrelated>(setup, row, errors);
        case DitherRule::kBlueNoise:
            return pick_row<L, DitherRule::kBlueNoise>(setup, row);
        case DitherRule::kMajority:
            return pick_row<L, DitherRule::kMajority>(setup, row);
    }
}

// `flatten`: what they call is inlined, so it is compiled for their instruction
// set.
__attribute__((target("avx2"), flatten)) void row_avx2(const DitherSetup& setup,
                                                       const DitherRow& row, float* errors) {
    any_row<Lanes<8>>(setup, row, errors);
}

__attribute__((target("sse4.1"), flatten)) void row_sse41(const DitherSetup& setup,
                                                          const DitherRow& row, float* errors) {
    any_row<Lanes<4>>(setup, row, errors);
}

}  // namespace

size_t error_count(const DitherSetup& setup) {
    if (setup.rule != DitherRule::kFloydSteinberg && setup.rule != DitherRule::kDecorrelated)
        return 0;
    return 2 * static_cast<size_t>(setup.width + 2 * kRowMargin) *
           static_cast<size_t>(setup.channels * kSlices);
}

void dither_row(const DitherSetup& setup, const DitherRow& row, float* errors) {
    (setup.isa == OPENFAB_ISA_AVX2 ? row_avx2 : row_sse41)(setup, row, errors);
}

}  // namespace openfab::slab

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Implements dither_rows. dither_avx2.cpp and dither_sse41.cpp compile it with the flags of their
// instruction sets. Slices are lanes: a slab's 8 slices are one vector of 8 lanes or two of 4.
// Everything is inlined.

#include <cstdint>

#include "abi/dither_rules.h"
#include "abi/stage_table.h"
#include "abi/voxel_hash.h"
#include "base/infinity.h"
#include "runtime/dither/blue_noise.h"
#include "runtime/dither/dither_row.h"
#include "simd/vectors.h"

namespace openfab::dither::OPENFAB_SIMD_ISA {
namespace {

using simd::Floats;
using simd::Ints;
using simd::Mask;
using simd::Uints;

constexpr int32_t kLanes = simd::kLanes;
constexpr int32_t kMaxChannels = OPENFAB_MAX_MATERIALS + 1;

template <int32_t from, int32_t end, typename F>
OPENFAB_INLINE void written_out(const F& f) {
    if constexpr (from < end) {
        f(from);
        written_out<from + 1, end>(f);
    }
}

/// Calls f(0), f(1), …, f(fixed - 1), unrolled, which GCC does not do for loops of vectors; or
/// loops to `count` where `fixed` is 0.
template <int32_t fixed, typename F>
OPENFAB_INLINE void for_channels(int32_t count, const F& f) {
    if constexpr (fixed > 0) {
        written_out<0, fixed>(f);
    } else {
        for (int32_t m = 0; m < count; ++m)
            f(m);
    }
}

/// A vector of the 8 voxels of a column, from slice `first` of the slab on. `fixed`: the number of
/// channels if it is a compile-time constant, so that loops are unrolled and values stay in
/// registers; else 0.
template <int32_t fixed>
struct Column {
    static constexpr int32_t kMost = fixed > 0 ? fixed : kMaxChannels;
    const uint16_t* fractions = nullptr;  ///< [material][slice], at `first`
    int32_t variable = 0;
    Mask received, interior;  ///< a previous neighbour is mixed; all four are
    bool all_received = false;
    Uints hash = Uints(0);
    Floats value[kMost];  ///< fractions with the errors received

    OPENFAB_INLINE int32_t channels() const { return fixed > 0 ? fixed : variable; }
    OPENFAB_INLINE Ints fraction(int32_t m) const {
        return Ints::load_unaligned(fractions + m * kSlices);
    }
};

/// Chooses the first material at which the running sum of the fractions exceeds the threshold; the
/// last sum is 65535, which always does.
OPENFAB_INLINE Ints first_above(const uint16_t* fractions, int32_t channels,
                                const Ints& threshold) {
    Ints sum = 0, code = channels - 1;
    for (int32_t m = 0; m + 1 < channels; ++m) {
        sum += Ints::load_unaligned(fractions + m * kSlices);
        code += as_ints(sum > threshold);
    }
    return code;
}

/// Chooses the largest fraction; ties go to the first.
OPENFAB_INLINE Ints largest(const uint16_t* fractions, int32_t channels) {
    Ints code = 0, most = 0;
    for (int32_t m = 0; m < channels; ++m) {
        const Ints fraction = Ints::load_unaligned(fractions + m * kSlices);
        const Mask more = fraction > most;
        code = select(more, m, code);
        most = max(most, fraction);
    }
    return code;
}

/// Floyd and Steinberg 1976: the largest value wins, ties go to the first, among materials that are
/// present; if no error was received, the hash decides.
template <int32_t fixed>
OPENFAB_INLINE Ints floyd_steinberg(const Column<fixed>& c) {
    Floats best = -kInfinity;
    Ints code = 0;
    for_channels<fixed>(c.channels(), [&](int32_t m) OPENFAB_INLINE_LAMBDA {
        const Mask wins = (c.fraction(m) > 0) & (c.value[m] > best);
        code = select(wins, m, code);
        best = select(wins, c.value[m], best);
    });
    if (c.all_received) return code;
    const Ints threshold = as_ints(abi::fraction_threshold(c.hash));
    return select(c.received, code, first_above(c.fractions, c.channels(), threshold));
}

/// Chooses the first material at which the running sum of the values' excess over a floor exceeds a
/// random fraction of the whole sum. For the choice of the floor see abi/dither_rules.h.
template <bool inside, int32_t fixed>
OPENFAB_INLINE Ints decorrelated(const Column<fixed>& c) {
    const Floats interior = abi::kDecorrelatedInteriorFloor;
    const Floats floor =
        inside ? interior
               : masked(c.received, select(c.interior, interior, abi::kDecorrelatedBorderFloor));
    Floats sum[Column<fixed>::kMost], total = 0;
    for_channels<fixed>(c.channels(), [&](int32_t m) OPENFAB_INLINE_LAMBDA {
        const Ints fraction = c.fraction(m);
        const Floats above = c.value[m] - floor;
        const Floats least = to_floats(fraction) * abi::kDecorrelatedLeast;
        total += masked(fraction > 0, max(above, least));
        sum[m] = total;
    });
    const Floats share = to_floats(as_ints(c.hash >> Uints(16))) * 0x1p-16f;
    const Floats threshold = share * total;
    Ints code = 0;
    for_channels<fixed - (fixed > 0)>(c.channels() - 1, [&](int32_t m) OPENFAB_INLINE_LAMBDA {
        code -= as_ints(sum[m] <= threshold);
    });
    return code;
}

/// Starts a chain of errors: all present materials but the most frequent get a random
/// error, which that one compensates.
template <int32_t fixed>
OPENFAB_INLINE void add_first_error(Column<fixed>* c) {
    const Ints most = largest(c->fractions, c->channels());
    Ints all = 0;
    for (int32_t m = 0; m < c->channels(); ++m) {
        const Mask gets = andnot((most == m) | c->received, c->fraction(m) > 0);
        const auto hash = abi::first_error_hash(c->hash, static_cast<uint64_t>(m));
        const Ints error = masked(gets, as_ints(hash >> Uints(16)) - 32768);
        all += error;
        c->value[m] += to_floats(error);
    }
    for (int32_t m = 0; m < c->channels(); ++m)
        c->value[m] -= to_floats(masked(most == m, all));
}

/// The fractions of the run's i-th column.
OPENFAB_INLINE const uint16_t* column_fractions(const DitherRow& row, int32_t i, int32_t channels) {
    return row.fractions + int64_t{row.columns[i]} * channels * kSlices;
}

/// Returns a mask from the bits of the slices from `first` on.
OPENFAB_INLINE Mask from_bits(int32_t bits, int32_t first) {
    return Mask::from_bits(static_cast<uint32_t>(bits >> first));
}

template <bool inside>
OPENFAB_INLINE void write_codes(const DitherRow& row, int32_t i, int32_t first, const Ints& code) {
    uint8_t* out = row.codes + int64_t{i} * kSlices + first;
    if constexpr (inside) {
        store_low_bytes(out, code);
    } else {
        const Mask mixed = from_bits(row.here[i], first);
        store_low_bytes(out, select(mixed, code, Ints::load_unaligned(out)));
    }
}

template <bool inside>
OPENFAB_INLINE Floats edge_weight(uint8_t mixed, int32_t first, float weight) {
    if constexpr (inside) return weight;
    return masked(from_bits(mixed, first), Floats(weight));
}

/// The only rule that does not depend on neighbours.
OPENFAB_INLINE void majority_row(const DitherSetup& setup, const DitherRow& row) {
    for (int32_t i = 0; i < 8 * row.blocks; ++i) {
        if (row.here[i] == 0) continue;
        const uint16_t* fractions = column_fractions(row, i, setup.channels);
        for (int32_t first = 0; first < kSlices; first += kLanes) {
            write_codes<false>(row, i, first, largest(fractions + first, setup.channels));
        }
    }
}

/// The pixels of the masks at a voxel of a row; a side that faces x has one for the whole row.
struct BlueNoisePlaces {
    const BlueNoiseOffset in, left, right, front, back;
    uint32_t inside, low_x, high_x, low_y, high_y;

    OPENFAB_INLINE BlueNoisePlaces(uint32_t seed, int32_t x, int32_t y, int32_t z)
        : in(seed, BlueNoiseFace::kInside),
          left(seed, BlueNoiseFace::kLowX),
          right(seed, BlueNoiseFace::kHighX),
          front(seed, BlueNoiseFace::kLowY),
          back(seed, BlueNoiseFace::kHighY),
          inside(in.inside(x, y, z)),
          low_x(left.upright(y, z)),
          high_x(right.upright(y, z)),
          low_y(front.upright(x, z)),
          high_y(back.upright(x, z)) {}

    OPENFAB_INLINE void advance() {
        inside = next_blue_noise(inside);
        low_y = next_blue_noise(low_y);
        high_y = next_blue_noise(high_y);
    }
};

/// Returns ranks of a pixel from slice `first` of the slab on.
OPENFAB_INLINE Ints ranks_at(const BlueNoiseMask& mask, uint32_t pixel, int32_t first,
                             const BlueNoiseOffset& offset) {
    return Ints::load_unaligned(mask[pixel] + first) + static_cast<int32_t>(offset.turn);
}

/// `inside`: the voxel and the four that decide its face are mixed, in all 8 slices. Then it is on no
/// side, which takes most of the work away where mixtures fill a solid.
template <bool inside>
OPENFAB_INLINE void blue_noise_column(const DitherSetup& setup, const DitherRow& row, int32_t i,
                                      const BlueNoisePlaces& at, const uint16_t* drift) {
    const uint16_t* fractions = column_fractions(row, i, setup.channels);
    const auto drift_here = static_cast<int32_t>(blue_noise_drift(i, 0, 0));
    const BlueNoiseFaces faces({row.here[i], row.here[i - 1], row.here[i + 1], row.above[i],
                                row.below[i], row.above[i - 1], row.above[i + 1], row.below[i - 1],
                                row.below[i + 1]});
    for (int32_t first = 0; first < kSlices; first += kLanes) {
        Ints rank = ranks_at(kBlueNoiseInside, at.inside, first, at.in);
        const auto take = [&](uint32_t bits, uint32_t pixel,
                              const BlueNoiseOffset& offset) OPENFAB_INLINE_LAMBDA {
            if (inside || bits == 0) return;
            rank = select(from_bits(static_cast<int32_t>(bits), first),
                          ranks_at(kBlueNoiseSides, pixel, first, offset), rank);
        };
        take(faces.low_x, at.low_x, at.left);
        take(faces.high_x, at.high_x, at.right);
        take(faces.low_y, at.low_y, at.front);
        take(faces.high_y, at.high_y, at.back);
        rank = (rank + Ints::load_unaligned(drift + first) + drift_here) & 0xffff;
        // fraction_threshold: rank 65535 / 65536, rounded down.
        const Ints threshold = rank + as_ints(rank > 0);
        write_codes<inside>(row, i, first,
                            first_above(fractions + first, setup.channels, threshold));
    }
}

OPENFAB_INLINE void blue_noise_row(const DitherSetup& setup, const DitherRow& row) {
    BlueNoisePlaces at(setup.seed, row.first_x, row.y, row.z);
    uint16_t drift[kSlices];
    for (int32_t l = 0; l < kSlices; ++l)
        drift[l] = static_cast<uint16_t>(blue_noise_drift(row.first_x, row.y, row.z + l));
    for (int32_t i = 0; i < 8 * row.blocks; ++i, at.advance()) {
        if (row.here[i] == 0) continue;
        if ((row.here[i - 1] & row.here[i] & row.here[i + 1] & row.above[i] & row.below[i]) == 255)
            blue_noise_column<true>(setup, row, i, at, drift);
        else
            blue_noise_column<false>(setup, row, i, at, drift);
    }
}

/// Larger runs do not stay in registers.
constexpr int32_t kFewChannels = 8;

/// diffuse_column for the decorrelated rule and many materials, where the voxel and all of its
/// neighbours are mixed: one pass computes the values, the sums and the errors passed on, which are
/// exactly a sixteenth of the value; that of the chosen material is corrected afterwards.
template <int32_t fixed>
OPENFAB_INLINE void diffuse_many(const DitherSetup& setup, const DitherRow& row, int32_t i,
                                 int32_t first, uint32_t hash, const float* up, float* here) {
    const int32_t channels = fixed > 0 ? fixed : setup.channels;
    const int64_t next = int64_t{channels} * kSlices;
    const uint16_t* fractions = column_fractions(row, i, channels) + first;
    const Uints hashes = abi::mix32(Uints(hash) ^ Uints(Ints::lane_numbers() + row.z + first));
    Floats sum[kMaxChannels], total = 0;
    for_channels<fixed>(channels, [&](int32_t m) OPENFAB_INLINE_LAMBDA {
        const int32_t k = m * kSlices;
        const Ints fraction = Ints::load_unaligned(fractions + k);
        const Floats asked = to_floats(fraction);
        Floats v = asked + Floats::load_unaligned(up + k - next);
        v = v + 5.0f * Floats::load_unaligned(up + k);
        v = v + 3.0f * Floats::load_unaligned(up + k + next);
        v = v + 7.0f * Floats::load_unaligned(here + k - next);
        const Floats above = v - abi::kDecorrelatedInteriorFloor;
        const Floats least = asked * abi::kDecorrelatedLeast;
        total += masked(fraction > 0, max(above, least));
        sum[m] = total;
        store_unaligned(here + k, v * 0x1p-4f);
    });
    const Floats share = to_floats(as_ints(hashes >> Uints(16))) * 0x1p-16f;
    const Floats threshold = share * total;
    Ints code = 0;
    for_channels<fixed - (fixed > 0)>(channels - 1, [&](int32_t m) OPENFAB_INLINE_LAMBDA {
        code -= as_ints(sum[m] <= threshold);
    });
    for (int32_t l = 0; l < kLanes; ++l) {
        float& chosen = here[code.lane(l) * kSlices + l];
        chosen = (16 * chosen - 65535.0f) * 0x1p-4f;
    }
    write_codes<true>(row, i, first, code);
}

// Error diffusion with the zero rule, in gather form. Each mixed voxel stores its error, divided by
// the sum of the weights of its mixed forward neighbours; a later voxel takes 7, 3, 5 or 1 times
// that from its own previous neighbours, if they are mixed. The masks alone decide which errors are
// taken, so `errors` of voxels that are not mixed never matter as long as they are finite.
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
template <DitherRule rule, bool inside, int32_t fixed>
OPENFAB_INLINE void diffuse_column(const DitherSetup& setup, const DitherRow& row, int32_t i,
                                   int32_t first, uint32_t hash, const float* up, float* here) {
    if constexpr (rule == DitherRule::kDecorrelated && inside &&
                  (fixed == 0 || fixed > kFewChannels)) {
        return diffuse_many<fixed>(setup, row, i, first, hash, up, here);
    }
    const int32_t channels = fixed > 0 ? fixed : setup.channels;
    const int64_t next = int64_t{channels} * kSlices;
    const uint8_t e = row.here[i - 1], se = row.above[i - 1], s = row.above[i],
                  sw = row.above[i + 1];
    const int32_t received = e | se | s | sw;
    Column<fixed> c;
    c.fractions = column_fractions(row, i, channels) + first;
    c.variable = channels;
    c.hash = abi::mix32(Uints(hash) ^ Uints(Ints::lane_numbers() + row.z + first));
    c.received = from_bits(received, first);
    c.interior = from_bits(e & se & s & sw, first);
    c.all_received = inside || (row.here[i] & ~received) == 0;
    const Floats w_e = edge_weight<inside>(e, first, 7), w_se = edge_weight<inside>(se, first, 1),
                 w_s = edge_weight<inside>(s, first, 5), w_sw = edge_weight<inside>(sw, first, 3);
    for_channels<fixed>(channels, [&](int32_t m) OPENFAB_INLINE_LAMBDA {
        const int32_t k = m * kSlices;
        Floats v = to_floats(c.fraction(m));
        v = v + w_se * Floats::load_unaligned(up + k - next);
        v = v + w_s * Floats::load_unaligned(up + k);
        v = v + w_sw * Floats::load_unaligned(up + k + next);
        c.value[m] = v + w_e * Floats::load_unaligned(here + k - next);
    });
    const Ints code =
        rule == DitherRule::kFloydSteinberg ? floyd_steinberg(c) : decorrelated<inside, fixed>(c);
    const Floats ahead = edge_weight<inside>(row.here[i + 1], first, 7) +
                         edge_weight<inside>(row.below[i - 1], first, 3) +
                         edge_weight<inside>(row.below[i], first, 5) +
                         edge_weight<inside>(row.below[i + 1], first, 1);
    const Floats hand_on = inside ? Floats(1.0f / 16) : 1.0f / max(ahead, 1.0f);
    for_channels<fixed>(channels, [&](int32_t m) OPENFAB_INLINE_LAMBDA {
        c.value[m] -= masked(code == m, Floats(65535.0f));
    });
    if (rule == DitherRule::kDecorrelated && !c.all_received) add_first_error(&c);
    for_channels<fixed>(channels, [&](int32_t m) OPENFAB_INLINE_LAMBDA {
        store_unaligned(here + m * kSlices, c.value[m] * hand_on);
    });
    write_codes<inside>(row, i, first, code);
}

/// Processes the rows as a wavefront, each two columns behind the one above, as close as the error
/// from the upper right allows: the errors of one row are read by the next before they have left
/// the cache, which matters for many materials (the errors of a row of 64 are 5 MB), and the
/// arithmetic of rows overlaps, which matters for few.
template <DitherRule rule, int32_t fixed>
OPENFAB_INLINE void diffuse_rows(const DitherSetup& setup, const DitherRow* rows, int32_t count,
                                 float* errors) {
    const int64_t voxel_values = int64_t{fixed > 0 ? fixed : setup.channels} * kSlices;
    const int64_t row_values = (setup.width + 2 * kRowMargin) * voxel_values;
    float* const begin = errors + (rows->first_x + kRowMargin) * voxel_values;
    const int32_t columns = 8 * rows->blocks;
    for (int32_t step = 0; step < columns + 2 * (count - 1); ++step) {
        const int32_t first_row = step < columns ? 0 : (step - columns) / 2 + 1;
        for (int32_t r = first_row; r < count && 2 * r <= step; ++r) {
            const DitherRow& row = rows[r];
            const int32_t i = step - 2 * r;
            if (row.here[i] == 0) continue;
            const uint32_t hash = abi::column_hash(static_cast<uint32_t>(row.first_x + i),
                                                   static_cast<uint32_t>(row.y), setup.seed);
            const bool inside = (row.above[i - 1] & row.above[i] & row.above[i + 1] &
                                 row.here[i - 1] & row.here[i] & row.here[i + 1] &
                                 row.below[i - 1] & row.below[i] & row.below[i + 1]) == 255;
            float* own = begin + (row.y & 1) * row_values + i * voxel_values;
            const float* behind = begin + (1 - (row.y & 1)) * row_values + i * voxel_values;
            for (int32_t first = 0; first < kSlices; first += kLanes) {
                if (inside) {
                    diffuse_column<rule, true, fixed>(setup, row, i, first, hash, behind + first,
                                                      own + first);
                } else {
                    diffuse_column<rule, false, fixed>(setup, row, i, first, hash, behind + first,
                                                       own + first);
                }
            }
        }
    }
}

template <DitherRule rule>
OPENFAB_INLINE void diffuse_rows_of(const DitherSetup& setup, const DitherRow* rows, int32_t count,
                                    float* errors) {
    switch (setup.channels) {  // those of fraction_channels
        case 2:
            return diffuse_rows<rule, 2>(setup, rows, count, errors);
#ifndef OPENFAB_SANITIZED  // with sanitizers these take minutes to compile
        case 3:
            return diffuse_rows<rule, 3>(setup, rows, count, errors);
        case 4:
            return diffuse_rows<rule, 4>(setup, rows, count, errors);
        case 5:
            return diffuse_rows<rule, 5>(setup, rows, count, errors);
        case 7:
            return diffuse_rows<rule, 7>(setup, rows, count, errors);
        case 9:
            return diffuse_rows<rule, 9>(setup, rows, count, errors);
        case 13:
            return diffuse_rows<rule, 13>(setup, rows, count, errors);
        case 16:
            return diffuse_rows<rule, 16>(setup, rows, count, errors);
#endif
        default:
            return diffuse_rows<rule, 0>(setup, rows, count, errors);
    }
}

}  // namespace

// `flatten`: the functions of no instruction set that it calls are inlined, too.
__attribute__((flatten)) void dither_rows(const DitherSetup& setup, const DitherRow* rows,
                                          int32_t count, float* errors) {
    switch (setup.rule) {
        case DitherRule::kFloydSteinberg:
            return diffuse_rows_of<DitherRule::kFloydSteinberg>(setup, rows, count, errors);
        case DitherRule::kDecorrelated:
            return diffuse_rows_of<DitherRule::kDecorrelated>(setup, rows, count, errors);
        case DitherRule::kBlueNoise:
            for (int32_t r = 0; r < count; ++r)
                blue_noise_row(setup, rows[r]);
            return;
        case DitherRule::kMajority:
            for (int32_t r = 0; r < count; ++r)
                majority_row(setup, rows[r]);
            return;
    }
}

}  // namespace openfab::dither::OPENFAB_SIMD_ISA

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The loops of flights.h, for the instruction set of the file that includes this. Included once in each. Each loop over lanes
// is either arithmetic alone, which becomes vectors, or reads memory.

#include <cstddef>

#include "simd/target.h"
#include "tools/render/clearances.h"
#include "tools/render/flights.h"

namespace openfab::render {
inline namespace OPENFAB_SIMD_ISA {

namespace {

constexpr int32_t kLanes = Lanes::kCount;
constexpr uint32_t kUniform = Clearances::kUniform;
constexpr float kTiny = 1e-30F;  // of what is divided by

/// What a round of all lanes has, beside their heads.
struct alignas(64) Round {
    uint32_t bits[4][kLanes];
    float leaves[kLanes];  ///< mm
    int32_t axis[kLanes];  ///< along which
    float majorant[kLanes], mm[kLanes];
    int32_t collides[kLanes];
    int32_t from[3][kLanes], far[kLanes];  ///< dual cells
    float extinction[3][kLanes], scattering[3][kLanes], anisotropy[kLanes];
};

OPENFAB_INLINE uint32_t rotated(uint32_t x, int by) {
    return x << by | x >> (32 - by);
}

/// Random::bits.
OPENFAB_INLINE void draw(Lanes* lanes, uint32_t* bits) {
    uint32_t* __restrict a = lanes->random[0];
    uint32_t* __restrict b = lanes->random[1];
    uint32_t* __restrict c = lanes->random[2];
    uint32_t* __restrict d = lanes->random[3];
#pragma GCC ivdep
    for (int32_t i = 0; i < kLanes; ++i) {
        bits[i] = rotated(a[i] + d[i], 7) + a[i];
        const uint32_t t = b[i] << 9;
        c[i] ^= a[i];
        d[i] ^= b[i];
        b[i] ^= c[i];
        a[i] ^= d[i];
        c[i] ^= t;
        d[i] = rotated(d[i], 11);
    }
}

/// Exponential with mean 1, from 31 bits: the logarithm's relative error is below 1e-6.
OPENFAB_INLINE float exponential(uint32_t bits) {
    const float u = (static_cast<float>(static_cast<int32_t>(bits >> 1)) + 0.5F) * 0x1p-31F;
    const auto as_bits = __builtin_bit_cast(int32_t, u);
    const int32_t half = as_bits - 0x3f3504f3;  // from the root of one half on
    const int32_t exponent = half >> 23;
    const auto m = __builtin_bit_cast(
        float, as_bits - static_cast<int32_t>(static_cast<uint32_t>(exponent) << 23));
    const float s = (m - 1) / (m + 1);
    const float z = s * s;
    const float series = 1 + z * (1.0F / 3 + z * (1.0F / 5 + z * (1.0F / 7)));
    return -(static_cast<float>(exponent) * 0.693147180559945F + 2 * s * series);
}

OPENFAB_INLINE float unit(uint32_t bits) {
    return static_cast<float>(static_cast<int32_t>(bits >> 8)) * 0x1p-24F;
}

/// Cosine and sine of an angle of all that bits may mean: a quadrant, and where in it.
OPENFAB_INLINE void azimuth(uint32_t bits, float* cosine, float* sine) {
    const auto in = static_cast<int32_t>(bits & 0x3fffffffU) - 0x20000000;
    const float x = static_cast<float>(in) * (0x1p-30F * 1.57079632679489662F);
    const float z = x * x;
    const float s = x * (1 - z * (1.0F / 6 - z * (1.0F / 120 - z * (1.0F / 5040))));
    const float c = 1 - z * (0.5F - z * (1.0F / 24 - z * (1.0F / 720 - z * (1.0F / 40320))));
    const bool is_turned = (bits & 0x40000000U) != 0;
    const float sign = (bits & 0x80000000U) != 0 ? -1.0F : 1.0F;
    *cosine = sign * (is_turned ? -s : c);
    *sine = sign * (is_turned ? c : s);
}

/// How far it is to the macrocells' walls.
OPENFAB_INLINE void find_walls(const Lanes& lanes, float side, Round* round) {
    for (int32_t i = 0; i < kLanes; ++i) {
        round->leaves[i] = 1e30F;
        round->axis[i] = -1;
    }
    for (int32_t a = 0; a < 3; ++a) {
        alignas(64) float below[kLanes];
#pragma GCC ivdep
        for (int32_t i = 0; i < kLanes; ++i)
            below[i] = static_cast<float>(
                lanes.at[a][i] - static_cast<double>(lanes.cell[a][i]) * static_cast<double>(side));
#pragma GCC ivdep
        for (int32_t i = 0; i < kLanes; ++i) {
            const float step = lanes.step[a][i];
            const bool is_up = step > 0;
            const float room = is_up ? side - below[i] : below[i];
            const float speed = is_up ? step : -step;
            const float ahead = room > 0 ? room : 0;
            const float mm = ahead / (speed > kTiny ? speed : kTiny);
            const bool is_first = mm < round->leaves[i];
            round->leaves[i] = is_first ? mm : round->leaves[i];
            round->axis[i] = is_first ? a : round->axis[i];
        }
    }
}

OPENFAB_INLINE void find_collisions(Lanes* lanes, Round* round) {
#pragma GCC ivdep
    for (int32_t i = 0; i < kLanes; ++i) {
        const float drawn = exponential(round->bits[0][i]);
        const float depth = lanes->depth[i] < 0 ? drawn : lanes->depth[i];
        const float size = round->majorant[i] < 0 ? -round->majorant[i] : round->majorant[i];
        const float mm = depth / (size > kTiny ? size : kTiny);
        const bool collides = size > 0 && mm <= round->leaves[i];
        round->collides[i] = collides ? 1 : 0;
        round->mm[i] = collides ? mm : round->leaves[i];
        const float left = depth - size * round->leaves[i];
        lanes->depth[i] = collides ? -1.0F : (left > 0 ? left : 0);
    }
}

/// The dual cells in which flights begin, and how many further they end.
OPENFAB_INLINE void find_dual_cells(const Lanes& lanes, Round* round) {
    for (int32_t i = 0; i < kLanes; ++i)
        round->far[i] = 0;
    for (int32_t a = 0; a < 3; ++a) {
        alignas(64) int32_t to[kLanes];
#pragma GCC ivdep
        for (int32_t i = 0; i < kLanes; ++i) {
            const double from = lanes.at[a][i] - 0.5;
            const double end = from + static_cast<double>(lanes.step[a][i] * round->mm[i]);
            round->from[a][i] = static_cast<int32_t>(from);
            to[i] = static_cast<int32_t>(end);
        }
#pragma GCC ivdep
        for (int32_t i = 0; i < kLanes; ++i) {
            const int32_t by = to[i] - round->from[a][i];
            const int32_t far = by < 0 ? -by : by;
            round->far[i] = far > round->far[i] ? far : round->far[i];
        }
    }
}

/// Which blocks voxels are in, and where in them.
struct alignas(64) Places {
    int32_t block[kLanes], in_block[kLanes];
};

OPENFAB_INLINE void find_places(const Medium& medium, const int32_t (*at)[kLanes], Places* places) {
    const int32_t wide = medium.blocks[0], deep = medium.blocks[1];
#pragma GCC ivdep
    for (int32_t i = 0; i < kLanes; ++i) {
        const int32_t x = at[0][i], y = at[1][i], z = at[2][i];
        places->block[i] = ((z >> 3) * deep + (y >> 3)) * wide + (x >> 3);
        places->in_block[i] = ((z & 7) << 6) | ((y & 7) << 3) | (x & 7);
    }
}

/// Clearances::at, of solid dual cells; else 0.
OPENFAB_INLINE int32_t clearance(const Medium& medium, int32_t block, int32_t in_block) {
    const uint32_t entry = medium.clearances[block];
    const auto place = static_cast<uint32_t>(in_block);
    const uint32_t value =
        (entry & kUniform) != 0
            ? entry & ~kUniform
            : medium.clearance_pool[size_t{entry} * Clearances::kBlockBytes + place / 2] >> (place % 2 * 4) & 15;
    return value < uint32_t{Clearances::kVoid} ? static_cast<int32_t>(value) : 0;
}

/// Weighs what scatters and what passes, and turns what scatters.
OPENFAB_INLINE void collide(Lanes* lanes, const float* per_mm, bool turns_by_angles, Round* round) {
    alignas(64) int32_t is_turned[kLanes];
#pragma GCC ivdep
    for (int32_t i = 0; i < kLanes; ++i) {
        const float size = round->majorant[i] < 0 ? -round->majorant[i] : round->majorant[i];
        const float r = lanes->weight[0][i], g = lanes->weight[1][i], b = lanes->weight[2][i];
        const float scatters = r * round->scattering[0][i] + g * round->scattering[1][i] +
                               b * round->scattering[2][i];
        const float r_passes = size - round->extinction[0][i];
        const float g_passes = size - round->extinction[1][i];
        const float b_passes = size - round->extinction[2][i];
        const float passes = r * r_passes + g * g_passes + b * b_passes;
        const float all = scatters + passes;
        const bool is_scattered = unit(round->bits[1][i]) * all < scatters;
        const float share = size * (is_scattered ? scatters : passes);
        const float scale = all / (share > kTiny ? share : kTiny);
        const bool collides = round->collides[i] != 0;
        const float of_r = scale * (is_scattered ? round->scattering[0][i] : r_passes);
        const float of_g = scale * (is_scattered ? round->scattering[1][i] : g_passes);
        const float of_b = scale * (is_scattered ? round->scattering[2][i] : b_passes);
        lanes->weight[0][i] = collides ? r * of_r : r;
        lanes->weight[1][i] = collides ? g * of_g : g;
        lanes->weight[2][i] = collides ? b * of_b : b;
        is_turned[i] = collides && is_scattered ? 1 : 0;
        round->collides[i] = collides && !(all > 0) ? -1 : round->collides[i];
    }
    alignas(64) float turned[3][kLanes];
#pragma GCC ivdep
    for (int32_t i = 0; i < kLanes; ++i) {
        float c, s;
        azimuth(round->bits[3][i], &c, &s);
        const float z = static_cast<float>(static_cast<int32_t>(round->bits[2][i])) * 0x1p-31F;
        const float squared = 1 - z * z;
        const float radius = __builtin_sqrtf(squared > 0 ? squared : 0);
        turned[0][i] = radius * c;
        turned[1][i] = radius * s;
        turned[2][i] = z;
    }
    if (turns_by_angles) {
#pragma GCC ivdep
        for (int32_t i = 0; i < kLanes; ++i) {
            // Henyey and Greenstein's phase function, in a frame by Duff et al. 2017.
            const float g = round->anisotropy[i];
            const bool is_plain = g > -1e-3F && g < 1e-3F;
            const float by = is_plain ? 1.0F : g;
            const float u = unit(round->bits[2][i]);
            const float q = (1 - by * by) / (1 - by + 2 * by * u);
            const float raw = (1 + by * by - q * q) / (2 * by);
            const float cosine = raw < -1 ? -1.0F : raw > 1 ? 1.0F : raw;
            const float squared = 1 - cosine * cosine;
            const float sine = __builtin_sqrtf(squared > 0 ? squared : 0);
            float c, s;
            azimuth(round->bits[3][i], &c, &s);
            const float x = lanes->direction[0][i], y = lanes->direction[1][i],
                        z = lanes->direction[2][i];
            const float sign = z >= 0 ? 1.0F : -1.0F;
            const float k = -1 / (sign + z);
            const float v = x * y * k;
            const float p = sine * c, o = sine * s;
            const float tx = x * cosine + (1 + sign * x * x * k) * p + v * o;
            const float ty = y * cosine + sign * v * p + (sign + y * y * k) * o;
            const float tz = z * cosine - sign * x * p - y * o;
            const float scale = 1 / __builtin_sqrtf(tx * tx + ty * ty + tz * tz);
            turned[0][i] = is_plain ? turned[0][i] : tx * scale;
            turned[1][i] = is_plain ? turned[1][i] : ty * scale;
            turned[2][i] = is_plain ? turned[2][i] : tz * scale;
        }
    }
    for (int32_t a = 0; a < 3; ++a) {
#pragma GCC ivdep
        for (int32_t i = 0; i < kLanes; ++i) {
            const float to = is_turned[i] != 0 ? turned[a][i] : lanes->direction[a][i];
            lanes->direction[a][i] = to;
            lanes->step[a][i] = to * per_mm[a];
        }
    }
}

void fly(const Medium& medium, Lanes* lanes) {
    const auto side = static_cast<float>(1 << medium.cell_shift);
    const float* const majorants = medium.majorants.data();
    const LaneMaterial* const materials = medium.materials.data();
    Round round;
    Places places;
    for (;;) {
        for (uint32_t* const bits : round.bits)
            draw(lanes, bits);
        find_walls(*lanes, side, &round);
        for (int32_t i = 0; i < kLanes; ++i)
            round.majorant[i] =
                majorants[(lanes->cell[2][i] * medium.cells[1] + lanes->cell[1][i]) *
                              medium.cells[0] +
                          lanes->cell[0][i]];
        find_collisions(lanes, &round);
        find_dual_cells(*lanes, &round);
        find_places(medium, round.from, &places);
        uint32_t met = 0;
        for (int32_t i = 0; i < kLanes; ++i) {
            lanes->meeting[i] = Meeting::kNothing;
            if (!(round.majorant[i] < 0)) continue;
            if (round.far[i] < clearance(medium, places.block[i], places.in_block[i])) continue;
            if (!medium.meets(medium.tracer, lanes, i, round.mm[i])) continue;
            lanes->meeting[i] = Meeting::kSurface;
            round.mm[i] = 0;
            round.collides[i] = 0;
            lanes->depth[i] = -1;
            met |= 1U << i;
        }
        for (int32_t a = 0; a < 3; ++a) {
#pragma GCC ivdep
            for (int32_t i = 0; i < kLanes; ++i)
                lanes->at[a][i] += static_cast<double>(lanes->step[a][i] * round.mm[i]);
#pragma GCC ivdep
            for (int32_t i = 0; i < kLanes; ++i) {
                const bool crosses = round.collides[i] == 0 && round.axis[i] == a &&
                                     lanes->meeting[i] == Meeting::kNothing;
                // One that is not in use goes nowhere.
                const int32_t way = lanes->step[a][i] > 0 ? 1 : lanes->step[a][i] < 0 ? -1 : 0;
                lanes->cell[a][i] += crosses ? way : 0;
            }
        }
        for (int32_t a = 0; a < 3; ++a) {
#pragma GCC ivdep
            for (int32_t i = 0; i < kLanes; ++i)
                round.from[a][i] = static_cast<int32_t>(lanes->at[a][i]);
        }
        find_places(medium, round.from, &places);
        float angles = 0;
        for (int32_t i = 0; i < kLanes; ++i) {
            if (round.collides[i] == 0) continue;
            const uint32_t entry = medium.codes[places.block[i]];
            const auto place = static_cast<uint32_t>(places.in_block[i]);
            const uint8_t code = (entry & kUniform) != 0
                                     ? static_cast<uint8_t>(entry)
                                     : medium.code_pool[size_t{entry} * Volume::kBlockVoxels + place];
            const LaneMaterial& material = materials[code];
            for (int32_t c = 0; c < 3; ++c) {
                round.extinction[c][i] = material.extinction[c];
                round.scattering[c][i] = material.scattering[c];
            }
            round.anisotropy[i] = material.anisotropy;
            angles += material.anisotropy < 0 ? -material.anisotropy : material.anisotropy;
        }
        collide(lanes, medium.per_mm, angles != 0, &round);
        alignas(64) int32_t meets[kLanes];
        int32_t any = 0;
#pragma GCC ivdep
        for (int32_t i = 0; i < kLanes; ++i) {
            const float heavy =
                (lanes->weight[0][i] + lanes->weight[1][i] + lanes->weight[2][i]) * (1.0F / 3);
            const bool is_away =
                static_cast<uint32_t>(lanes->cell[0][i]) >= static_cast<uint32_t>(medium.cells[0]) ||
                static_cast<uint32_t>(lanes->cell[1][i]) >= static_cast<uint32_t>(medium.cells[1]) ||
                static_cast<uint32_t>(lanes->cell[2][i]) >= static_cast<uint32_t>(medium.cells[2]);
            const auto kNothing = static_cast<int32_t>(Meeting::kNothing);
            const int32_t other = round.collides[i] < 0      ? static_cast<int32_t>(Meeting::kNowhere)
                                  : is_away                  ? static_cast<int32_t>(Meeting::kAway)
                                  : heavy < Lanes::kLight    ? static_cast<int32_t>(Meeting::kLight)
                                                             : kNothing;
            meets[i] = lanes->is_used[i] != 0 ? other : kNothing;
            any |= meets[i];
        }
        if (any == 0 && met == 0) continue;
        for (int32_t i = 0; i < kLanes; ++i) {
            if (meets[i] != 0 && (met >> i & 1) == 0) lanes->meeting[i] = static_cast<Meeting>(meets[i]);
        }
        return;
    }
}

}  // namespace

extern const Fly kFly;
const Fly kFly = fly;

}  // namespace OPENFAB_SIMD_ISA
}  // namespace openfab::render

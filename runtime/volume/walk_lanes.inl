// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The loops of walk_lanes.h, for the instruction set of the file that includes this. Included once in each. Each loop over
// lanes is either arithmetic alone, which becomes vectors, or reads memory.
//
// Source: Sawhney and Crane, "Monte Carlo geometry processing", ACM Transactions on Graphics 39 (2020), where balls are
// about the point; exits of other balls are by Poisson's kernel.

#include <cstddef>

#include "runtime/volume/walk_lanes.h"
#include "simd/target.h"

namespace openfab::volume {
inline namespace OPENFAB_SIMD_ISA {

namespace {

constexpr int32_t kLanes = WalkLanes::kCount;
/// The eight nodes around a point, from the lowest one on.
constexpr int32_t kCorners[8] = {0, 1, 3, 4, 9, 10, 12, 13};

/// abi::mix32.
OPENFAB_INLINE uint32_t mix(uint32_t h) {
    h ^= h >> 16;
    h *= 0x7feb352du;
    h ^= h >> 15;
    h *= 0x846ca68bu;
    return h ^ h >> 16;
}

OPENFAB_INLINE float unit(uint32_t state) {
    return static_cast<float>(static_cast<int32_t>(mix(state) >> 8)) * 0x1p-24f;
}

/// What is read of the cells.
struct alignas(64) Reads {
    float of[2][8][kLanes];  ///< of the part and of the object, at eight nodes
    float side[kLanes];
    float u[3][kLanes];  ///< where between the nodes
};

/// The fields between nodes, as walk_between.
OPENFAB_INLINE void blend(const float (&v)[8][kLanes], const Reads& reads, float* value,
                          float (*slope)[kLanes]) {
#pragma GCC ivdep
    for (int32_t i = 0; i < kLanes; ++i) {
        const float ux = reads.u[0][i], uy = reads.u[1][i], uz = reads.u[2][i];
        const float scale = 2 / reads.side[i];
        const float dx00 = v[1][i] - v[0][i], dx10 = v[3][i] - v[2][i], dx01 = v[5][i] - v[4][i],
                    dx11 = v[7][i] - v[6][i];
        const float v00 = v[0][i] + ux * dx00, v10 = v[2][i] + ux * dx10,
                    v01 = v[4][i] + ux * dx01, v11 = v[6][i] + ux * dx11;
        const float dy0 = v10 - v00, dy1 = v11 - v01;
        const float v0 = v00 + uy * dy0, v1 = v01 + uy * dy1;
        const float dx0 = dx00 + uy * (dx10 - dx00), dx1 = dx01 + uy * (dx11 - dx01);
        slope[0][i] = (dx0 + uz * (dx1 - dx0)) * scale;
        slope[1][i] = (dy0 + uz * (dy1 - dy0)) * scale;
        slope[2][i] = (v1 - v0) * scale;
        value[i] = v0 + uz * (v1 - v0);
    }
}

uint32_t read(const WalkCells& cells, WalkLanes* lanes) {
    static const WalkKept kNothing{};
    alignas(64) int32_t place[3][kLanes], inside[kLanes], bits[kLanes];
    Reads reads;
    for (int32_t i = 0; i < kLanes; ++i)
        inside[i] = lanes->phase[i] != WalkLanes::kEnded ? 1 : 0;
    for (size_t a = 0; a < 3; ++a) {
        const float origin = cells.origin[a], per_unit = cells.per_unit;
        const auto most = static_cast<float>(cells.count[a] << kWalkUnitBits);
#pragma GCC ivdep
        for (int32_t i = 0; i < kLanes; ++i) {
            const float at = (lanes->asks[a][i] - origin) * per_unit;
            const bool in = at >= 0 && at < most;
            inside[i] = in ? inside[i] : 0;
            place[a][i] = static_cast<int32_t>(in ? at : 0.0f);
        }
    }
    uint32_t missing = 0;
    const size_t wide = cells.count[0], deep = cells.count[1];
    for (int32_t i = 0; i < kLanes; ++i) {
        const auto x = static_cast<uint32_t>(place[0][i]), y = static_cast<uint32_t>(place[1][i]),
                   z = static_cast<uint32_t>(place[2][i]);
        const WalkKept* kept = &kNothing;
        uint32_t bit = kWalkUnitBits - 1;
        const auto octant = [&]() OPENFAB_INLINE_LAMBDA {
            return (x >> bit & 1) | (y >> bit & 1) << 1 | (z >> bit & 1) << 2;
        };
        if (inside[i] != 0) {
            const size_t root =
                ((z >> kWalkUnitBits) * deep + (y >> kWalkUnitBits)) * wide + (x >> kWalkUnitBits);
            kept = __atomic_load_n(cells.roots + root, __ATOMIC_ACQUIRE);
            while (kept != nullptr && !(lanes->stop[i] >= kept->reads_from) && bit > 1) {
                kept = __atomic_load_n(kept->eighths.data() + octant(), __ATOMIC_ACQUIRE);
                --bit;
            }
            if (kept == nullptr) {
                missing |= 1u << i;
                kept = &kNothing;
            }
        }
        lanes->known[i] = kept != &kNothing ? 1 : 0;
        bits[i] = static_cast<int32_t>(bit);
        reads.side[i] = kept->side;
        lanes->may_exceed[i] = kept->over;
        const uint32_t in = octant();
        const uint32_t first = (in & 1) + (in >> 1 & 1) * 3 + (in >> 2) * 9;
        const float* const own = kept->own.data() + first;
        const float* const object = kept->object.data() + first;
        for (size_t c = 0; c < 8; ++c) {
            reads.of[0][c][i] = own[kCorners[c]];
            reads.of[1][c][i] = object[kCorners[c]];
        }
    }
    for (int32_t a = 0; a < 3; ++a) {
#pragma GCC ivdep
        for (int32_t i = 0; i < kLanes; ++i) {
            const int32_t mask = (1 << bits[i]) - 1;
            const float part = __builtin_bit_cast(float, (127 - bits[i]) << 23);
            reads.u[a][i] = static_cast<float>(place[a][i] & mask) * part;
        }
    }
    blend(reads.of[0], reads, lanes->own, lanes->own_slope);
    if (cells.with_object) {
        blend(reads.of[1], reads, lanes->object, lanes->object_slope);
    } else {
        for (float& object : lanes->object)
            object = __builtin_inff();
    }
    return missing;
}

/// Cosine and sine of `turn` turns, 0 to 1, within 1e-6.
OPENFAB_INLINE void direction(float turn, float* cosine, float* sine) {
    const float quarters = 4 * turn;
    const auto quarter = static_cast<int32_t>(quarters);
    const float a = (quarters - static_cast<float>(quarter) - 0.5f) * 1.57079633f, a2 = a * a;
    const float c = 1 + a2 * (-0.5f + a2 * (1.0f / 24 + a2 * (-1.0f / 720 + a2 * (1.0f / 40320))));
    const float s = a * (1 + a2 * (-1.0f / 6 + a2 * (1.0f / 120 + a2 * (-1.0f / 5040))));
    const int32_t turns = quarter & 3;
    const float x = (turns & 1) != 0 ? s : c, y = (turns & 1) != 0 ? c : s;
    *cosine = turns == 1 || turns == 2 ? -x : x;
    *sine = turns >= 2 ? -y : y;
}

/// All ones or all zeros: bools of comparisons of different widths do not become vectors.
OPENFAB_INLINE int32_t mask(bool is) {
    return is ? -1 : 0;
}
OPENFAB_INLINE float lesser(float a, float b) {
    return b < a ? b : a;
}
OPENFAB_INLINE float greater(float a, float b) {
    return a < b ? b : a;
}

/// Returns the radius of a ball that is empty. Between nodes of a smooth field errors are a quarter of those between corners.
OPENFAB_INLINE float empty(float height, float over) {
    return height - 0.5f * over;
}

/// The balls that walks leave. They begin at the height `touch` above a foot, and the walk is at the share `depth` of the
/// radius under a ball's surface, straight below its centre.
struct alignas(64) Balls {
    float touch[kLanes], radius[kLanes], depth[kLanes];
    int32_t leaves[kLanes];  ///< a mask: else it goes elsewhere
    int32_t draws[kLanes];   ///< how many numbers
};

/// Takes what is known where the walks asked, and finds where they ask next, but for where they leave balls.
OPENFAB_INLINE void go_on(WalkLanes* lanes, Balls* balls) {
    // Most steps of a walk, which one in a million reaches.
    constexpr int32_t kMostSteps = 256;
    constexpr float kFirstReach = 2, kWorth = 0.7f, kShrink = 0.3f;
#pragma GCC ivdep
    for (int32_t i = 0; i < kLanes; ++i) {
        // No short circuits, and all is loaded: control flow would keep this from becoming vectors.
        const int32_t phase = lanes->phase[i];
        const float stop = lanes->stop[i], own = lanes->own[i], of_object = lanes->object[i];
        const float asked_x = lanes->asks[0][i], asked_y = lanes->asks[1][i],
                    asked_z = lanes->asks[2][i];
        const float at_x = lanes->at[0][i], at_y = lanes->at[1][i], at_z = lanes->at[2][i];
        const float up_x = lanes->up[0][i], up_y = lanes->up[1][i], up_z = lanes->up[2][i];
        const float own_x = lanes->own_slope[0][i], own_y = lanes->own_slope[1][i],
                    own_z = lanes->own_slope[2][i];
        const float object_x = lanes->object_slope[0][i], object_y = lanes->object_slope[1][i],
                    object_z = lanes->object_slope[2][i];
        const float may_exceed = lanes->may_exceed[i], last_height = lanes->height[i],
                    last_over = lanes->over[i], last_reach = lanes->reach[i],
                    last_side = lanes->side[i];
        const int32_t was_on_object = lanes->on_object[i], last_steps = lanes->steps[i];
        const uint32_t random = lanes->random[i] + 0x9e3779b9u;
        const int32_t begins = mask(phase == WalkLanes::kBegins),
                      tries = mask(phase == WalkLanes::kTries), known = mask(lanes->known[i] != 0);

        // From inside the object a walk ends at its surface, too.
        const float first_side = of_object < 0 ? -1.0f : 1.0f;
        const float side = begins != 0 ? first_side : last_side;
        const float object = side * of_object;
        const int32_t on_object = mask(object < own);
        const float nearest = on_object != 0 ? object : own;
        const int32_t holds = mask(phase != WalkLanes::kRises) | mask(nearest > stop);
        const int32_t arrives = mask(phase != WalkLanes::kEnded) & ~tries & known & holds;

        const float sx = on_object != 0 ? object_x * side : own_x;
        const float sy = on_object != 0 ? object_y * side : own_y;
        const float sz = on_object != 0 ? object_z * side : own_z;
        const float per_length = 1 / greater(__builtin_sqrtf(sx * sx + sy * sy + sz * sz), 1e-20f);
        const float ux = arrives != 0 ? sx * per_length : up_x;
        const float uy = arrives != 0 ? sy * per_length : up_y;
        const float uz = arrives != 0 ? sz * per_length : up_z;
        const float x = arrives != 0 ? asked_x : at_x;
        const float y = arrives != 0 ? asked_y : at_y;
        const float z = arrives != 0 ? asked_z : at_z;
        const float height = arrives != 0 ? nearest : last_height;
        const float over = arrives != 0 ? may_exceed : last_over;
        const float reach = begins != 0 ? kFirstReach * height : last_reach;
        const int32_t steps = last_steps - arrives;

        const int32_t steps_on = arrives & mask(steps <= kMostSteps);
        const int32_t is_low = mask(height < stop), may_be_larger = mask(height < 0.5f * reach);
        const int32_t low = steps_on & is_low;
        // A lot between the surface and a place farther than `stop`, or it would be cast there again.
        const float away = 1.25f * stop;
        const int32_t rises = low & mask(unit(random) * away < height);
        // A ball that touches the surface where it is nearest may be larger than one about the place.
        const int32_t will_try = steps_on & ~is_low & may_be_larger;
        const int32_t leaves = tries | (steps_on & ~is_low & ~may_be_larger);

        // Of a ball that was tried.
        const float large = known != 0 ? empty(nearest, may_exceed) : 0.0f;
        const float inside = large - reach + height;
        const int32_t good = tries & mask(inside > kWorth * height) & mask(large > empty(height, over));
        const float shrunk = greater(tries != 0 ? kShrink * reach : reach, height);
        const float radius_about = greater(empty(height, over), 0.5f * height);
        balls->radius[i] = good != 0 ? large : radius_about;
        balls->touch[i] = good != 0 ? reach - large : height - radius_about;
        balls->depth[i] = good != 0 ? lesser(inside / large, 1.0f) : 1.0f;
        balls->leaves[i] = leaves;
        balls->draws[i] = (low & 1) | (leaves & 2);

        const float by = rises != 0 ? away - height : will_try != 0 ? reach - height : 0.0f;
        lanes->asks[0][i] = x + ux * by;
        lanes->asks[1][i] = y + uy * by;
        lanes->asks[2][i] = z + uz * by;
        const float left_reach = good != 0 ? large : shrunk;
        lanes->reach[i] = leaves != 0 ? left_reach : reach;
        const int32_t otherwise = leaves != 0 ? WalkLanes::kLeaves : WalkLanes::kEnded;
        const int32_t not_risen = will_try != 0 ? WalkLanes::kTries : otherwise;
        lanes->phase[i] = rises != 0 ? WalkLanes::kRises : not_risen;
        lanes->up[0][i] = ux;
        lanes->up[1][i] = uy;
        lanes->up[2][i] = uz;
        lanes->at[0][i] = x;
        lanes->at[1][i] = y;
        lanes->at[2][i] = z;
        lanes->height[i] = height;
        lanes->over[i] = over;
        lanes->side[i] = side;
        lanes->steps[i] = steps;
        lanes->on_object[i] = arrives != 0 ? on_object : was_on_object;
    }
}

/// Finds where walks leave balls, and draws for all.
OPENFAB_INLINE void leave(const Balls& balls, WalkLanes* lanes) {
#pragma GCC ivdep
    for (int32_t i = 0; i < kLanes; ++i) {
        const uint32_t one = lanes->random[i] + 0x9e3779b9u, two = one + 0x9e3779b9u;
        const int32_t draws = balls.draws[i];
        lanes->random[i] += static_cast<uint32_t>(draws) * 0x9e3779b9u;
        const bool leaves = balls.leaves[i] != 0;
        const float depth = balls.depth[i], radius = balls.radius[i];
        const float v = 2 * unit(one);
        const float out_of = 1 - depth, below = depth + out_of * v;
        // 1 - cos of the angle from straight below.
        const float fall = depth * depth * (2 - v) * (2 + out_of * v) / (2 * below * below);
        float c, s;
        direction(unit(two), &c, &s);
        const float ux = lanes->up[0][i], uy = lanes->up[1][i], uz = lanes->up[2][i];
        const bool along_x = __builtin_fabsf(ux) > 0.6f;
        const float sx = along_x ? -uz : 0.0f, sy = along_x ? 0.0f : uz, sz = along_x ? ux : -uy;
        const float per_length =
            1 / greater(__builtin_sqrtf(sx * sx + sy * sy + sz * sz), 1e-20f);
        const float ax = sx * per_length, ay = sy * per_length, az = sz * per_length;
        const float rx = ax * c + (uy * az - uz * ay) * s;
        const float ry = ay * c + (uz * ax - ux * az) * s;
        const float rz = az * c + (ux * ay - uy * ax) * s;
        const float flat = radius * __builtin_sqrtf(greater(fall * (2 - fall), 0.0f));
        const float along = balls.touch[i] + radius * fall, height = lanes->height[i];
        const float x = lanes->at[0][i] - ux * height + ux * along + rx * flat;
        const float y = lanes->at[1][i] - uy * height + uy * along + ry * flat;
        const float z = lanes->at[2][i] - uz * height + uz * along + rz * flat;
        lanes->asks[0][i] = leaves ? x : lanes->asks[0][i];
        lanes->asks[1][i] = leaves ? y : lanes->asks[1][i];
        lanes->asks[2][i] = leaves ? z : lanes->asks[2][i];
    }
}

uint32_t take(WalkLanes* lanes) {
    Balls balls;
    go_on(lanes, &balls);
    leave(balls, lanes);
    uint32_t ended = 0;
    for (int32_t i = 0; i < kLanes; ++i)
        ended |= (lanes->phase[i] == WalkLanes::kEnded ? 1u : 0u) << i;
    return ended;
}

}  // namespace

extern const WalkKernels kWalk;
const WalkKernels kWalk = {read, take};

}  // namespace OPENFAB_SIMD_ISA
}  // namespace openfab::volume

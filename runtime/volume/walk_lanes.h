// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Random walks (walk.h) side by side in the lanes of vectors, compiled for several instruction sets, which all give the same
// bits. A walk does not depend on those in other lanes. (Their twin, one at a time: tests/support/reference/plain_walk.h.)

#include <array>
#include <cstdint>

#include "abi/fablet_table.h"
#include "base/vec.h"
#include "runtime/volume/walk.h"

namespace openfab::volume {

/// A cell of the lattice that is kept.
struct alignas(64) WalkKept {
    float reads_from = 0;  ///< the least `stop` with which it is read, not one of its eighths
    float side = 0, over = 0;
    bool settled = false;  ///< its nodes are not what was asked
    /// Null: not there yet. Read and set with __atomic functions; what is set stays.
    std::array<WalkKept*, 8> eighths{};
    WalkNodes own{}, object{};
};

/// Where walks read.
struct WalkCells {
    std::array<float, 3> origin{};
    float per_unit = 1;
    std::array<uint32_t, 3> count{};
    WalkKept* const* roots = nullptr;  ///< by (z, y, x)
    bool with_object = false;
};

struct alignas(64) WalkLanes {
    static constexpr int32_t kCount = 16;
    enum Phase : int32_t { kBegins, kRises, kTries, kLeaves, kEnded };
    static constexpr float kLeastStop = 1e-4f;

    WalkLanes() {
        for (int32_t& one : phase)
            one = kEnded;
    }
    void begin(size_t lane, const Vec3f& p, float stop_mm, int32_t seed);
    void know(size_t lane, const WalkField& field);
    Vec3f asked(size_t lane) const { return {asks[0][lane], asks[1][lane], asks[2][lane]}; }
    /// Returns where a walk ended.
    Vec3f end(size_t lane) const;

    int32_t phase[kCount], steps[kCount] = {}, on_object[kCount] = {};
    uint32_t random[kCount] = {};
    float stop[kCount] = {};
    float at[3][kCount] = {}, up[3][kCount] = {}, asks[3][kCount] = {};
    float height[kCount] = {}, over[kCount] = {}, side[kCount] = {}, reach[kCount] = {};
    // WalkField at `asks`; not `known`: nothing is.
    int32_t known[kCount] = {};
    float own[kCount] = {}, object[kCount] = {}, may_exceed[kCount] = {};
    float own_slope[3][kCount] = {}, object_slope[3][kCount] = {};
};

struct WalkKernels {
    /// Reads what is known where walks ask; returns the lanes whose cells are not there.
    uint32_t (*read)(const WalkCells& cells, WalkLanes* lanes);
    /// Lets walks go on with what is known; returns the lanes without one under way.
    uint32_t (*take)(WalkLanes* lanes);
};

/// Those of this machine's best set, up to `limit`.
WalkKernels walk_kernels(openfab_isa limit);

}  // namespace openfab::volume

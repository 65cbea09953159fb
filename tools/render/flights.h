// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Flights of many paths inside a print, side by side in the lanes of vectors, compiled for several instruction sets, which
// all give the same bits. A path does not depend on those in other lanes.
//
// Flights are drawn against a majorant of the extinction, which is constant in a macrocell and the same for all channels
// (delta tracking). At each tentative collision the path goes on straight or scatters, with probabilities that follow what
// its channels weigh by then (spectral tracking: Kutz, Habel, Li and Novak 2017, "Spectral and decomposition tracking for
// rendering heterogeneous volumes"), so that the mean of its weights never grows: no speckle comes from colours that are
// absorbed differently.

#include <cstdint>
#include <vector>

namespace openfab::render {

/// What a path meets that ends a flight of its lane.
enum class Meeting : int32_t {
    kNothing,
    kSurface,  ///< it is there
    kAway,     ///< it left the macrocells
    kLight,    ///< its mean weight is below Lanes::kLight
    kNowhere   ///< no channel is left
};

/// The heads of paths inside. Lengths are in mm, places in voxels.
struct alignas(64) Lanes {
    static constexpr int32_t kCount = 16;
    static constexpr float kLight = 0.1F;

    double at[3][kCount];
    float direction[3][kCount];  ///< unit
    float step[3][kCount];       ///< voxels per mm along it
    float weight[3][kCount];
    float depth[kCount];  ///< optical, that is left of a flight; below 0: to be drawn
    uint32_t random[4][kCount];
    int32_t cell[3][kCount];
    int32_t is_used[kCount];  ///< 0 or 1
    Meeting meeting[kCount];
};

/// A material, one channel after the other.
struct alignas(32) LaneMaterial {
    float extinction[3], scattering[3];
    float anisotropy;
};

/// Where flights are.
struct Medium {
    /// By macrocell, x fastest, per mm; negative where a surface may be.
    std::vector<float> majorants;
    int32_t cells[3];
    int32_t cell_shift;  ///< of coordinates to macrocells
    float per_mm[3];     ///< voxels
    std::vector<LaneMaterial> materials;
    /// By block of 8 x 8 x 8 voxels: the code of all of them and kUniform, or which of the pool's.
    const uint32_t* codes;
    const uint8_t* code_pool;
    int32_t blocks[3];
    /// How far it is to the surface at least (Clearances).
    const uint32_t* clearances;
    const uint8_t* clearance_pool;
    /// Tells whether a path meets the surface on its way of that many mm; moves it there.
    bool (*meets)(const void* tracer, Lanes* lanes, int32_t lane, float mm);
    const void* tracer;
};

/// Lets all lanes in use fly until one of them meets something.
using Fly = void (*)(const Medium& medium, Lanes* lanes);

/// That of this machine's best set, up to `limit` (0 SSE4.1, 1 AVX2, 2 AVX-512).
Fly best_flight(int limit = 2);

}  // namespace openfab::render

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The interval form of the volume stage over cubes of voxels: which of them can hold one
// composition only.

#include <cstdint>
#include <span>
#include <vector>

#include "runtime/slab/kernel_arguments.h"
#include "runtime/slab/print_part.h"

namespace openfab::slab {

/// Where the intervals of what queries give come from.
enum class QueryBounds {
    /// The distance of the cube's middle, less and plus half its diagonal; of the surface's
    /// attributes nothing is known. A tenth of a microsecond a cube.
    kMiddle,
    /// The engine's bounds of distance and attributes, case by case. Tighter; ten microseconds.
    kCases,
};

/// Weights of some cubes as intervals. Memory is kept for the next ones, of any part.
class CubeBounds {
  public:
    /// What a thread bounds with; `scratch` only where the part's bounds ask queries.
    struct Tools {
        nearest::Engine::Scratch* scratch;
        KernelArguments* arguments;
        openfab_isa isa;
    };

    /// Of memory that so many cubes of the part can take.
    static int64_t most_bytes(const PrintPart& part, int64_t cubes);

    /// Cubes of `size` voxels a side, by their lowest voxels, part-relative. Returns 0 or a Halide
    /// error code.
    int bound(const PrintPart& part, int32_t size, std::span<const Vec3i> lowest, QueryBounds from,
              const Tools& tools);
    /// True where all cases of a cube give every slot the same single weight, which is then in
    /// `weights`: one for each slot.
    bool one_composition(size_t cube, std::vector<float>* weights) const;
    /// After kMiddle: a distance that lies in the cube's interval, signed, mm.
    float middle_distance(size_t cube) const { return 0.0f - middle_[cube]; }

  private:
    void find_middles(const PrintPart& part, int32_t size, std::span<const Vec3i> lowest,
                      nearest::Engine::Scratch* scratch);
    void add_entry(const PrintPart& part, const Vec3i& corner, const nearest::NearestCase& of,
                   float distance_lo, float distance_hi);
    void lay_out(const PrintPart& part);
    int run_kernel(const PrintPart& part, int32_t size, const Tools& tools);

    /// What the kernel bounds: an entry for each case of each cube; those of cube i are
    /// entries first_entry_[i] … first_entry_[i + 1].
    std::vector<size_t> first_entry_;
    std::vector<int32_t> corners_;  ///< [entry][axis]
    std::vector<float> distance_lo_, distance_hi_;
    std::vector<float> case_floats_;  ///< [entry][lo or hi][component]
    std::vector<int32_t> case_ints_;
    std::vector<float> float_lo_, float_hi_;  ///< [component][entry], as the kernel reads them
    std::vector<int32_t> int_lo_, int_hi_;
    std::vector<float> weight_lo_, weight_hi_;  ///< [slot][entry]
    nearest::NearestCase unknown_;              ///< of a part that asks no query, or has no surface
    nearest::BoxBounds box_;
    std::vector<nearest::PointGroup> points_;
    std::vector<nearest::PointAnswer> answers_;
    std::vector<float> middle_;  ///< unsigned distances
};

}  // namespace openfab::slab

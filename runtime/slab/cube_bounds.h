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
    /// From about the distance of the cube's middle; of the surface's attributes nothing is known.
    /// A tenth of a microsecond to one a cube.
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
    float middle_distance(size_t cube) const { return 0.0f - middles_[cube / 8].high[cube % 8]; }

    /// After kMiddle: a surface point about as near to the cube's middle as any, part-local mm.
    Vec3f point_near_middle(size_t cube) const {
        const auto& p = middles_[cube / 8].point;
        return {p[0][cube % 8], p[1][cube % 8], p[2][cube % 8]};
    }

  private:
    void find_middles(const PrintPart& part, int32_t size, std::span<const Vec3i> lowest,
                      nearest::Engine::Scratch* scratch);
    struct Range {
        float low, high;
    };
    Range around_middle(const PrintPart& part, size_t cube, float voxels) const;
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
    std::vector<nearest::PointBounds> middles_;
};

}  // namespace openfab::slab

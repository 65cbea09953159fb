// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The interval form of the volume stage over cubes of voxels: which of them can hold one
// composition only.

#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include "runtime/volume/kernel_arguments.h"
#include "runtime/volume/print_part.h"

namespace openfab::slab {

/// Where the intervals of what queries give come from.
enum class QueryBounds {
    /// From about the distance of the cube's middle, of blocks from about those of their corners;
    /// of the surface's attributes nothing is known. A tenth of a microsecond to one a cube.
    kDistance,
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

    /// Cubes of `size` voxels a side, by their lowest voxels, part-relative.
    abi::KernelStatus bound(const PrintPart& part, int32_t size, std::span<const Vec3i> lowest,
                            QueryBounds from, const Tools& tools);
    /// By kDistance the pieces of blocks (nearest::Engine::pieces): those of block i are cubes
    /// i * kPieces to i * kPieces + kPieces - 1.
    abi::KernelStatus bound_pieces(const PrintPart& part, std::span<const Vec3i> blocks,
                                   const Tools& tools);
    static constexpr size_t kPieces = std::tuple_size_v<decltype(nearest::BlockPieces::lowest)>;
    /// True where all cases of a cube give every slot the same single weight, which is then in
    /// `weights`: one for each slot.
    bool one_composition(size_t cube, std::vector<float>* weights) const;
    /// A distance that a cube with one case may have, signed, mm.
    float distance_of(size_t cube) const { return distance_lo_[first_entry_[cube]]; }

  private:
    /// What is known of the distance of a cube's middle.
    struct Middle {
        const PrintPart* part = nullptr;
        Vec3i lowest{};
        float low = 0, high = 0;  ///< mm
        Vec3f at{};               ///< mm
        Vec3f point{};            ///< of the surface, about as near as any
    };
    static constexpr size_t kKnownMiddles = 1024;  ///< of each size

    void begin(const PrintPart& part);
    Middle& known_middle(int32_t size, const Vec3i& lowest);
    void find_middles(const PrintPart& part, int32_t size, std::span<const Vec3i> lowest,
                      nearest::Engine::Scratch* scratch);
    struct Range {
        float low, high;
    };
    static Range around_middle(const PrintPart& part, const Middle& middle, float voxels);
    void add_middles(const PrintPart& part, int32_t size, std::span<const Vec3i> lowest,
                     nearest::Engine::Scratch* scratch);
    /// visit(block, bounds of its pieces)
    template <typename Visit>
    void each_block(const PrintPart& part, std::span<const Vec3i> blocks,
                    nearest::Engine::Scratch* scratch, const Visit& visit);
    void add_cases(const PrintPart& part, int32_t size, std::span<const Vec3i> lowest,
                   nearest::Engine::Scratch* scratch);
    void add_entry(const Vec3i& corner, const nearest::NearestCase& of, float distance_lo,
                   float distance_hi);
    void lay_out(const PrintPart& part);
    abi::KernelStatus run_kernel(const PrintPart& part, int32_t size, const Tools& tools);

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
    std::vector<nearest::PointGroup> points_, near_;
    std::vector<nearest::PointBounds> bounds_;
    std::vector<Middle> middles_;          ///< of the cubes in hand
    std::vector<Middle> known_;            ///< of the last ones, [size][place]
    std::vector<size_t> missing_;          ///< of those in hand, which were not known
    static constexpr size_t kBlocks = 64;  ///< that are bounded at a time
    std::vector<nearest::BlockBounds> blocks_;
};

}  // namespace openfab::slab

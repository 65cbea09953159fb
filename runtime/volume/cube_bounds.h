// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Evaluates the interval form of the volume stage over cubes of voxels, to find cubes with uniform
// weights, and cubes whose voxels need not know their nearest surface points.

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <tuple>
#include <vector>

#include "runtime/volume/kernel_arguments.h"
#include "runtime/volume/placed_part.h"

namespace openfab::volume {

/// The source of the intervals of query results.
enum class BoundSource {
    /// Approximate distances: of a cube's centre, or of a block's corners; surface attributes are
    /// unknown. 0.1 to 1 us a cube.
    kCenterDistance,
    /// The engine's bounds of distance and attributes, per case. Tighter; 10 us a cube.
    kPerCase,
};

/// Intervals of the weights of some cubes. Memory is reused from call to call, for any part.
class CubeBounds {
  public:
    /// Per-thread tools; `scratch` is null where the part's bounds need no queries.
    struct Tools {
        nearest::Engine::Scratch* scratch;
        KernelArguments* arguments;
        openfab_isa isa;
    };

    /// Returns the peak bytes for `cubes` cubes of this part.
    static int64_t most_bytes(const PlacedPart& part, int64_t cubes);

    /// Unsigned distances, mm; NaN where they are not known.
    struct Range {
        float low = std::numeric_limits<float>::quiet_NaN();
        float high = std::numeric_limits<float>::quiet_NaN();
        bool is_known() const { return low <= high; }
    };
    /// What is known of a cube beforehand.
    struct Known {
        Range distance;  ///< where it is known, it is taken instead of the engine's bounds per case
        /// Attributes that are one value in all of the cube, as a case whose other ranges are
        /// open; null: none.
        const nearest::NearestCase* attributes = nullptr;
        bool looks_by_them = false;  ///< `looks` takes no others from the cube's own cases
    };
    /// Cubes of `size` voxels a side, by their lowest voxels, part-relative.
    abi::KernelStatus bound(const PlacedPart& part, int32_t size, std::span<const Vec3i> lowest,
                            std::span<const Known> known, BoundSource source, const Tools& tools);
    /// Bounds the pieces of blocks (nearest::Engine::pieces) by kCenterDistance: those of block i
    /// are cubes i * kPieces to i * kPieces + kPieces - 1. `known`: of the blocks, their attributes.
    abi::KernelStatus bound_pieces(const PlacedPart& part, std::span<const Vec3i> blocks,
                                   std::span<const Known> known, const Tools& tools);
    /// Finds for each block a distance, nearly the least, beyond which no voxel of it has to know its
    /// nearest surface point: with that distance, and any attributes but those that are known, such a
    /// voxel is what it is, mm. kInfinity where there is none that helps. The part's bounds say looks.
    abi::KernelStatus find_reaches(const PlacedPart& part, std::span<const Vec3i> blocks,
                                   std::span<const Known> known, const Tools& tools,
                                   std::vector<float>* reaches);
    static constexpr size_t kPieces = std::tuple_size_v<decltype(nearest::BlockPieces::lowest)>;
    /// Returns whether all cases of a cube give every slot the same exact weight; writes the
    /// weights, one for each slot.
    bool is_uniform(size_t cube, std::vector<float>* weights) const;
    /// Returns whether some voxel of a cube may have to know its nearest surface point; where not,
    /// the distance `distance_of`, with any attributes but those of `attributes_of`, says as much.
    /// Known of pieces, and of cubes by kPerCase; true of others.
    bool looks(size_t cube) const {
        return first_blind_ == kNone || !(looks_[first_blind_ + cube] == 0);
    }
    /// Returns a possible signed distance of a piece, or of a cube of which `looks` is known, mm;
    /// 0 where its bounds say nothing.
    float distance_of(size_t cube) const;
    /// Returns the bounds of its distance.
    Range range_of(size_t cube) const;
    /// Gets the attributes of which `looks` knew that they are one value in all of the cube, as in
    /// Known; false if there are none.
    bool attributes_of(size_t cube, nearest::NearestCase* out) const;

  private:
    /// Bounds of the distance at a cube's centre.
    struct CenterDistance {
        const PlacedPart* part = nullptr;
        Vec3i lowest{};
        float low = 0, high = 0;  ///< mm
        Vec3f at{};               ///< the centre, mm
        Vec3f point{};            ///< a surface point, approximately the nearest
    };
    static constexpr size_t kCachedCenters = 1024;  ///< per size

    void begin(const PlacedPart& part);
    CenterDistance& cached_center(int32_t size, const Vec3i& lowest);
    void find_centers(const PlacedPart& part, int32_t size, std::span<const Vec3i> lowest,
                      nearest::Engine::Scratch* scratch);
    static Range distance_range(const PlacedPart& part, const CenterDistance& center, float voxels);
    void add_centers(const PlacedPart& part, int32_t size, std::span<const Vec3i> lowest,
                     nearest::Engine::Scratch* scratch);
    void add_cases(const PlacedPart& part, int32_t size, std::span<const Vec3i> lowest,
                   std::span<const Known> known, nearest::Engine::Scratch* scratch);
    /// Adds an entry for each cube, with all of its cases as one: attributes on which they agree.
    void add_blind_entries(std::span<const Vec3i> lowest, std::span<const Known> known);
    void find_same_attributes(size_t cube);
    const nearest::NearestCase& attributes_or_unknown(std::span<const Known> known,
                                                      size_t cube) const {
        const bool any = !known.empty() && known[cube].attributes != nullptr;
        return any ? *known[cube].attributes : unknown_;
    }
    size_t entry_of(size_t cube) const {
        return first_blind_ == kNone ? first_entry_[cube] : first_blind_ + cube;
    }
    void add_entry(const Vec3i& corner, const nearest::NearestCase& of, float distance_lo,
                   float distance_hi);
    void transpose_entries(const PlacedPart& part);
    abi::KernelStatus run_kernel(const PlacedPart& part, int32_t size, const Tools& tools);

    /// The kernel's input: an entry for each case of each cube; those of cube i are entries
    /// first_entry_[i] … first_entry_[i + 1].
    std::vector<size_t> first_entry_;
    static constexpr size_t kNone = std::numeric_limits<size_t>::max();
    size_t first_blind_ = kNone;    ///< of the entries that tell what `looks` says, one a cube
    std::vector<int32_t> corners_;  ///< [entry][axis]
    std::vector<float> distance_lo_, distance_hi_;
    std::vector<float> case_floats_;  ///< [entry][lo or hi][component]
    std::vector<int32_t> case_ints_;
    std::vector<float> float_lo_, float_hi_;  ///< [component][entry], as the kernel reads them
    std::vector<int32_t> int_lo_, int_hi_;
    std::vector<float> weight_lo_, weight_hi_;  ///< [slot][entry]
    std::vector<float> looks_;                  ///< [entry]
    std::vector<uint32_t> packed_;              ///< [output][entry], of a kernel with many outputs
    nearest::NearestCase unknown_;              ///< of a part without queries or without a surface
    nearest::NearestCase same_;                 ///< of the current cube
    nearest::BoxBounds box_;
    std::vector<nearest::PointPacket> points_, near_;
    std::vector<nearest::PointBounds> bounds_;
    std::vector<CenterDistance> centers_;  ///< of the current cubes
    std::vector<CenterDistance> cached_;   ///< of recent cubes, [size][slot]
    std::vector<size_t> missing_;          ///< current cubes that were not cached
    static constexpr size_t kBlocks = 64;  ///< blocks per call
    std::vector<nearest::BlockBounds> blocks_;
    std::vector<float> block_low_, block_high_;
    std::vector<std::array<int32_t, 2>> steps_;  ///< of reaches: one that looks, one that does not
    std::vector<float> weights_;
};

}  // namespace openfab::volume

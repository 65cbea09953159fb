// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pieces of blocks (nearest::Engine::pieces) that need no query, as what they are made of is the
// same whatever it would say: for any distance in the piece's interval the slab kernel gives that.
// Many of them hold one composition. One a thread.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/infinity.h"
#include "runtime/volume/cube_bounds.h"
#include "runtime/volume/placed_part.h"

namespace openfab::volume {

/// What a column of equal voxels is made of.
struct ConstantColumn {
    std::array<uint8_t, 8> codes{};
    std::vector<uint16_t> fractions;  ///< 8 a channel
    bool usable = false;              ///< no amount was negative or NaN
};

/// Computes codes and fractions of voxels of these weights, one for each slot, as the slab kernel
/// would give them.
abi::KernelStatus constant_column(const PlacedPart& part, openfab_isa isa, const float* weights,
                                  ConstantColumn* out);

/// What is tried on blocks before their voxels make queries.
struct CullTries {
    bool pieces = false;  ///< pieces, by approximate distances of their blocks' corners
    bool reach = false;   ///< queries are bounded where a voxel that is farther need not look
    bool any() const { return pieces || reach; }
};

/// The culled pieces of one block.
struct CulledBlock {
    uint32_t pieces = 0;  ///< a bit each
    std::array<float, CubeBounds::kPieces> distance{};
    /// OPENFAB_CODE_MIXED where mixed, or where the slab kernel has to count.
    std::array<uint8_t, CubeBounds::kPieces> code{};
    alignas(
        8) std::array<uint8_t, 64> culled{};     ///< voxels of culled pieces, laid out like `owned`
    alignas(8) std::array<uint8_t, 64> known{};  ///< those whose code is known
    float reach = kInfinity;  ///< a voxel farther from the surface takes this distance, mm
    /// Those of all of its voxels that are known (CubeBounds::Known); null: none.
    const nearest::NearestCase* attributes = nullptr;
};

/// Calls visit(column in the block, bits) for each column of a piece.
void for_each_column(const nearest::BlockPieces& pieces, size_t piece, const auto& visit) {
    const Vec3i from = pieces.lowest[piece], to = from + pieces.size;
    const auto bits = static_cast<uint8_t>((1u << to.z) - (1u << from.z));
    for (int32_t y = from.y; y < to.y; ++y) {
        for (int32_t x = from.x; x < to.x; ++x)
            visit(static_cast<size_t>(8 * y + x), bits);
    }
}

class PieceCull {
  public:
    /// Finds the culled pieces of blocks, which are given by their lowest voxels. All are of a block
    /// with a `blind` distance (PartCull::blind_distance), which is NaN for others; of those
    /// pieces are culled as `tries` says. `attributes`: of each block, those that are known.
    abi::KernelStatus run(const PlacedPart& part, std::span<const Vec3i> blocks, const float* blind,
                          const nearest::NearestCase* const* attributes, const CullTries& tries,
                          CubeBounds* bounds, const CubeBounds::Tools& tools, CulledBlock* out);

  private:
    static void cull(const nearest::BlockPieces& pieces, size_t piece, float distance, uint8_t code,
                     CulledBlock* block);
    abi::KernelStatus limit_queries(const PlacedPart& part, std::span<const Vec3i> blocks,
                                    CubeBounds* bounds, const CubeBounds::Tools& tools,
                                    CulledBlock* out);
    abi::KernelStatus find_pieces(const PlacedPart& part, size_t first_cube,
                                  const CubeBounds& bounds, openfab_isa isa, CulledBlock* block);
    abi::KernelStatus find_code(const PlacedPart& part, openfab_isa isa, uint8_t* code);

    struct KnownCode {
        std::vector<float> weights;
        uint8_t code;
    };
    std::vector<KnownCode> known_;  ///< of known_part_
    const PlacedPart* known_part_ = nullptr;
    std::vector<float> weights_;
    std::vector<Vec3i> bounded_;               ///< blocks that are not blind
    std::vector<size_t> which_;                ///< their indices
    std::vector<CubeBounds::Known> known_of_;  ///< of bounded_
    std::vector<float> reaches_;
    ConstantColumn constant_;
};

}  // namespace openfab::volume

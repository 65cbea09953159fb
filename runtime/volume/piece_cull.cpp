// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/volume/piece_cull.h"

#include <algorithm>
#include <cmath>

namespace openfab::volume {

abi::KernelStatus constant_column(const PlacedPart& part, openfab_isa isa, const float* weights,
                                  ConstantColumn* out) {
    const auto slots = static_cast<size_t>(part.slots());
    std::vector<float> amounts(8 * slots);
    for (size_t s = 0; s < slots; ++s)
        std::fill_n(&amounts[8 * s], 8, weights[s]);
    out->fractions.resize(8 * static_cast<size_t>(part.channels.count()));
    std::array<uint16_t, 8> unusable{};
    constexpr int32_t kFirst = 0;
    const abi::KernelStatus status =
        abi::normalise(isa, {&kFirst, 1}, part.channels, amounts.data(), 8, out->fractions.data(),
                       out->codes.data(), unusable.data());
    out->usable = status.ok() && unusable[0] == 0;
    return status;
}

abi::KernelStatus PieceCull::run(const PlacedPart& part, std::span<const Vec3i> blocks,
                                 const float* blind, const nearest::NearestCase* const* attributes,
                                 const CullTries& tries, CubeBounds* bounds,
                                 const CubeBounds::Tools& tools, CulledBlock* out) {
    bounded_.clear();
    known_of_.clear();
    which_.clear();
    for (size_t b = 0; b < blocks.size(); ++b) {
        CulledBlock& block = out[b];
        const bool all = !std::isnan(blind[b]);
        block.pieces = all ? ~0u : 0;
        block.distance.fill(all ? blind[b] : 0.0f);
        block.code.fill(uint8_t{OPENFAB_CODE_MIXED});
        block.culled.fill(all ? uint8_t{0xff} : uint8_t{0});
        block.known.fill(0);
        block.reach = kInfinity;
        block.attributes = attributes[b];
        if (all) continue;
        bounded_.push_back(blocks[b]);
        known_of_.push_back({{}, attributes[b], true});
        which_.push_back(b);
    }
    if (bounded_.empty()) return {};
    weights_.resize(static_cast<size_t>(part.slots()));
    abi::KernelStatus status;
    if (tries.pieces) {
        status = bounds->bound_pieces(part, bounded_, known_of_, tools);
        for (size_t i = 0; i < which_.size() && status.ok(); ++i) {
            status =
                find_pieces(part, i * CubeBounds::kPieces, *bounds, tools.isa, &out[which_[i]]);
        }
    }
    if (status.ok() && tries.reach) status = limit_queries(part, blocks, bounds, tools, out);
    return status;
}

void PieceCull::cull(const nearest::BlockPieces& pieces, size_t piece, float distance, uint8_t code,
                     CulledBlock* block) {
    block->pieces |= 1u << piece;
    block->distance[piece] = distance;
    block->code[piece] = code;
    const bool known = code != OPENFAB_CODE_MIXED;
    for_each_column(pieces, piece, [&](size_t column, uint8_t bits) {
        block->culled[column] |= bits;
        if (known) block->known[column] |= bits;
    });
}

abi::KernelStatus PieceCull::limit_queries(const PlacedPart& part, std::span<const Vec3i> blocks,
                                           CubeBounds* bounds, const CubeBounds::Tools& tools,
                                           CulledBlock* out) {
    std::erase_if(which_, [&](size_t b) { return out[b].pieces == ~0u; });
    if (which_.empty()) return {};
    bounded_.clear();
    known_of_.clear();
    for (const size_t b : which_) {
        bounded_.push_back(blocks[b]);
        known_of_.push_back({{}, out[b].attributes, true});
    }
    const abi::KernelStatus status =
        bounds->find_reaches(part, bounded_, known_of_, tools, &reaches_);
    for (size_t i = 0; i < which_.size() && status.ok(); ++i)
        out[which_[i]].reach = reaches_[i];
    return status;
}

abi::KernelStatus PieceCull::find_pieces(const PlacedPart& part, size_t first_cube,
                                         const CubeBounds& bounds, openfab_isa isa,
                                         CulledBlock* block) {
    const nearest::BlockPieces& pieces = part.engine().pieces();
    for (size_t p = 0; p < CubeBounds::kPieces; ++p) {
        const size_t cube = first_cube + p;
        const bool uniform = bounds.is_uniform(cube, &weights_);
        if (!uniform && bounds.looks(cube)) continue;
        uint8_t code{OPENFAB_CODE_MIXED};
        if (uniform) {
            const abi::KernelStatus status = find_code(part, isa, &code);
            if (!status.ok()) return status;
        }
        cull(pieces, p, bounds.distance_of(cube), code, block);
    }
    return {};
}

// The code of what weights_ say, from what is known of the part or by normalising it.
abi::KernelStatus PieceCull::find_code(const PlacedPart& part, openfab_isa isa, uint8_t* code) {
    constexpr size_t kMostKnown = 8;
    if (known_part_ != &part) known_.clear();
    known_part_ = &part;
    const auto known = std::ranges::find(known_, weights_, &KnownCode::weights);
    *code = known != known_.end() ? known->code : uint8_t{OPENFAB_CODE_MIXED};
    if (known != known_.end() || known_.size() == kMostKnown) return {};
    const abi::KernelStatus status = constant_column(part, isa, weights_.data(), &constant_);
    if (constant_.usable) *code = constant_.codes[0];
    known_.push_back({weights_, *code});
    return status;
}

}  // namespace openfab::volume

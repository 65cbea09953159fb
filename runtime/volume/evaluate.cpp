// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/volume/evaluate.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "base/check.h"
#include "base/clock.h"
#include "base/grow.h"
#include "base/infinity.h"

namespace openfab::volume {

namespace {

constexpr size_t kBlockValues = nearest::kBlockVoxels;
constexpr size_t kBatchValues = kBlockValues * BlockEvaluator::kBatch;

/// Calls visit(column in the block, bits) for each column of a piece.
void for_each_column(const nearest::BlockPieces& pieces, size_t piece, const auto& visit) {
    const Vec3i from = pieces.lowest[piece], to = from + pieces.size;
    const auto bits = static_cast<uint8_t>((1u << to.z) - (1u << from.z));
    for (int32_t y = from.y; y < to.y; ++y) {
        for (int32_t x = from.x; x < to.x; ++x)
            visit(static_cast<size_t>(8 * y + x), bits);
    }
}

}  // namespace

BlockEvaluator::BlockEvaluator(const openfab_stage_set& set, openfab_isa isa, size_t parts)
    : calls_(set, isa), isa_(isa), scratch_(parts), attribute_scratch_(parts), segments_(parts) {
    owned_.resize(64 * kBatch);
    demand_.resize(64 * kBatch);
    demanded_.resize(kBatchValues);
    tiles_.resize(static_cast<size_t>(calls_.tile_values()) * kBatch);
    codes_.resize(kBatchValues);
    distance_.resize(kBatchValues);
}

nearest::Engine::Scratch* BlockEvaluator::scratch(const PlacedPart& part) {
    std::unique_ptr<nearest::Engine::Scratch>& mine = scratch_[part.owner];
    if (mine == nullptr) mine = part.engine->make_scratch();
    return mine.get();
}

nearest::QueryCounts BlockEvaluator::query_counts() const {
    nearest::QueryCounts sum;
    for (const auto& s : scratch_) {
        if (s != nullptr) sum.add(s->counts);
    }
    sum.add(segments_.query_counts());
    return sum;
}

// Allocates the part's inputs, and notes which of them its volume kernel reads.
void BlockEvaluator::prepare(const PlacedPart& part) {
    const auto floats = static_cast<size_t>(part.nearest.floats());
    const auto ints = static_cast<size_t>(part.nearest.ints());
    grow(&values_, floats * kBatchValues);
    grow(&gradients_, part.volume.gradients ? floats * 3 * kBatchValues : 0);
    grow(&flat_, ints * kBatchValues);
    grow(&weights_, static_cast<size_t>(part.slots()) * kBatchValues);
    value_targets_.assign(floats, nullptr);
    gradient_targets_.assign(floats * 3, nullptr);
    flat_targets_.assign(ints, nullptr);
    const openfab_kernel& kernel = part.part->fablet->volume;
    for (int32_t i = 0; i < kernel.arg_count; ++i) {
        const openfab_arg& arg = kernel.args[i];
        if (arg.kind == OPENFAB_ARG_NEAREST) {
            const size_t c = part.nearest.index(arg.a, arg.b);
            if (part.nearest.is_float(arg.a)) {
                value_targets_[c] = &values_[c * kBatchValues];
            } else {
                flat_targets_[c] = &flat_[c * kBatchValues];
            }
        } else if (arg.kind == OPENFAB_ARG_NEAREST_GRAD) {
            const size_t c = part.nearest.index(arg.a, 0) * 3 + static_cast<size_t>(arg.b);
            gradient_targets_[c] = &gradients_[c * kBatchValues];
        }
    }
}

// Finds which of the owned voxels need their nearest surface point: all, if the fablet has no
// demand kernel.
abi::KernelStatus BlockEvaluator::find_demand(const PlacedPart& part, int32_t n) {
    const auto bytes = static_cast<size_t>(64 * n);
    std::copy_n(owned_.begin(), bytes, demand_.begin());
    const openfab_kernel& kernel = part.part->fablet->volume_demand;
    if (kernel.arg_count == 0) return {};
    arguments_.begin(kernel, part, corners_.data(), n, 8);
    for (int32_t i = 0; i < kernel.arg_count; ++i) {
        if (kernel.args[i].kind == OPENFAB_ARG_DEMAND) arguments_.set_blocks(i, demanded_.data());
    }
    if (const abi::KernelStatus status = arguments_.run(isa_); !status.ok()) return status;
    for (size_t byte = 0; byte < bytes; ++byte) {
        uint32_t bits = 0;
        for (size_t z = 0; z < 8; ++z)
            bits |= static_cast<uint32_t>(demanded_[8 * byte + z] & 1) << z;
        demand_[byte] &= static_cast<uint8_t>(bits);
    }
    return {};
}

// Pieces that are uniform for any result of a query need none: for every distance in the interval
// the volume kernel gives the same composition.
abi::KernelStatus BlockEvaluator::cull_pieces(const PlacedPart& part, int32_t n) {
    if (const abi::KernelStatus status =
            cube_bounds_.bound_pieces(part, blocks_, bound_tools(part));
        !status.ok())
        return status;
    piece_weights_.resize(static_cast<size_t>(part.slots()));
    const nearest::BlockPieces& pieces = part.engine->pieces();
    for (size_t block = 0; block < static_cast<size_t>(n); ++block) {
        for (size_t p = 0; p < CubeBounds::kPieces; ++p) {
            const size_t cube = block * CubeBounds::kPieces + p;
            if (!cube_bounds_.is_uniform(cube, &piece_weights_)) continue;
            culled_pieces_[block] |= 1u << p;
            culled_distance_[block][p] = cube_bounds_.distance_of(cube);
            uint8_t& code = culled_code_[block][p];
            if (const abi::KernelStatus status = find_culled_code(part, &code); !status.ok())
                return status;
            for_each_column(pieces, p, [&](size_t column, uint8_t bits) {
                demand_[64 * block + column] &= static_cast<uint8_t>(~bits);
                if (code != OPENFAB_CODE_MIXED) known_code_mask_[64 * block + column] |= bits;
            });
        }
    }
    return {};
}

// Returns the code of piece_weights_, from the part's known codes or by normalising a block of
// them.
abi::KernelStatus BlockEvaluator::find_culled_code(const PlacedPart& part, uint8_t* code) {
    constexpr size_t kMostKnown = 8;
    if (known_part_ != &part) known_codes_.clear();
    known_part_ = &part;
    const auto known = std::ranges::find(known_codes_, piece_weights_, &KnownCode::weights);
    *code = known != known_codes_.end() ? known->code : uint8_t{OPENFAB_CODE_MIXED};
    if (known != known_codes_.end() || known_codes_.size() == kMostKnown) return {};
    const abi::KernelStatus status =
        constant_block(part, piece_weights_.data(), codes_.data(), tiles_.data());
    if (std::ranges::count(unusable_.begin(), unusable_.begin() + 8, 0) == 8) *code = codes_[0];
    known_codes_.push_back({piece_weights_, *code});
    return status;
}

// Gives the culled pieces of a block a distance from their intervals.
void BlockEvaluator::fill_culled(const PlacedPart& part, int32_t index) {
    const auto block = static_cast<size_t>(index);
    float* out = &distance_[block * kBlockValues];
    const nearest::BlockPieces& pieces = part.engine->pieces();
    for (uint32_t left = culled_pieces_[block]; left != 0; left &= left - 1) {
        const auto p = static_cast<size_t>(std::countr_zero(left));
        for_each_column(pieces, p, [&](size_t column, uint8_t) {
            std::fill_n(out + 8 * column + pieces.lowest[p].z, pieces.size.z,
                        culled_distance_[block][p]);
        });
    }
}

// Shares the search between the queries of all blocks; not on a displaced surface, where it would
// pin the patches near all of them at once.
void BlockEvaluator::prepare_queries(const PlacedPart& part, int32_t n) {
    if (!part.surface->identity()) return;
    for (int32_t i = n; i-- > 0;) {
        const uint8_t* demand = &demand_[static_cast<size_t>(64 * i)];
        if (std::all_of(demand, demand + 64, [](uint8_t bits) { return bits == 0; }))
            blocks_.erase(blocks_.begin() + i);
    }
    part.engine->prepare(blocks_, scratch(part));
}

// Zeros the inputs of one block of the batch; the targets point to it.
void BlockEvaluator::clear_inputs(const PlacedPart& part, int32_t index) {
    const auto clear = [](const auto& targets) {
        for (auto* target : targets) {
            if (target != nullptr) std::fill_n(target, kBlockValues, 0);
        }
    };
    clear(value_targets_);
    clear(gradient_targets_);
    clear(flat_targets_);
    if (part.volume.distance)
        std::fill_n(&distance_[static_cast<size_t>(index) * kBlockValues], kBlockValues, 0.0f);
}

// Fills the inputs of one block of the batch, 0 where a voxel does not query; the targets point to
// it.
void BlockEvaluator::query(const PlacedPart& part, int32_t index) {
    const uint8_t* demand = &demand_[static_cast<size_t>(64 * index)];
    if (std::all_of(demand, demand + 64, [](uint8_t bits) { return bits == 0; })) {
        scratch(part)->counts.skipped += nearest::kBlockVoxels;
        clear_inputs(part, index);
        if (part.volume.distance) fill_culled(part, index);
        return;
    }
    nearest::BlockQuery query;
    const int32_t* corner = &corners_[static_cast<size_t>(3 * index)];
    query.block = {corner[0], corner[1], corner[2]};
    query.active = demand;
    part.engine->query(query, scratch(part), &answer_);
    if (part.volume.attributes || part.volume.gradients) {
        const nearest::AttributeTargets targets{
            value_targets_.data(), part.volume.gradients ? gradient_targets_.data() : nullptr,
            flat_targets_.data()};
        part.attributes->read(answer_, demand, targets, &attribute_scratch_[part.owner]);
    }
    if (part.volume.distance) {
        // Owned voxels are inside, so the distance is negative; taken from 0 so that none gives +0.
        // Voxels that do not query are infinitely far in the answer.
        float* out = &distance_[static_cast<size_t>(index) * kBlockValues];
        for (size_t v = 0; v < kBlockValues; ++v) {
            const float d2 = answer_.distance2[v];
            out[v] = 0.0f - std::sqrt(d2 < kInfinity ? d2 : 0.0f);
        }
        fill_culled(part, index);
    }
}

const void* BlockEvaluator::input(const PlacedPart& part, const openfab_arg& arg) const {
    switch (arg.kind) {
        case OPENFAB_ARG_DISTANCE:
            return distance_.data();
        case OPENFAB_ARG_NEAREST: {
            const size_t first = part.nearest.index(arg.a, arg.b) * kBatchValues;
            if (part.nearest.is_float(arg.a)) return &values_[first];
            return &flat_[first];
        }
        case OPENFAB_ARG_NEAREST_GRAD:
            return &gradients_[(part.nearest.index(arg.a, 0) * 3 + static_cast<size_t>(arg.b)) *
                               kBatchValues];
        default:
            return nullptr;
    }
}

abi::KernelStatus BlockEvaluator::run_volume(const PlacedPart& part, int32_t n, PrintfLog* log) {
    const openfab_kernel& kernel = part.part->fablet->volume;
    const int32_t slots = part.slots();
    const auto written = static_cast<int32_t>(
        std::count_if(kernel.args, kernel.args + kernel.arg_count,
                      [](const openfab_arg& arg) { return arg.kind == OPENFAB_ARG_WEIGHT; }));
    // A slot that the fablet never sets may have no output.
    if (written < slots)
        std::fill_n(weights_.begin(), static_cast<size_t>(n * slots) * kBlockValues, 0.0f);
    if (part.part->fablet->volume_segments.step_count > 0) {
        return segments_.run(
            part, isa_, corners_.data(), owned_.data(), n,
            [&](const openfab_arg& arg) { return input(part, arg); }, weights_.data(), log);
    }
    arguments_.begin(kernel, part, corners_.data(), n, 8);
    for (int32_t i = 0; i < kernel.arg_count; ++i) {
        if (kernel.args[i].kind == OPENFAB_ARG_WEIGHT) {
            arguments_.set_blocks(
                i, &weights_[static_cast<size_t>(kernel.args[i].a) * kBlockValues], slots * 512);
        } else if (!arguments_.is_set(i)) {
            arguments_.set_blocks(i, input(part, kernel.args[i]));
        }
    }
    return arguments_.run(isa_);
}

abi::KernelStatus BlockEvaluator::normalise(const PlacedPart& part, int32_t n) {
    uint8_t slices = 0;
    for (size_t i = 0; i < static_cast<size_t>(64 * n); ++i)
        slices |= owned_[i];
    if (std::has_single_bit(slices) && n > 1)
        return normalise_slice(part, n, std::countr_zero(slices));
    columns_.clear();
    for (size_t i = 0; i < static_cast<size_t>(64 * n); ++i) {
        if ((owned_[i] & ~known_code_mask_[i]) != 0) columns_.push_back(i);
    }
    // Packing a column costs about an eighth of what it saves.
    if (8 * columns_.size() < 7 * static_cast<size_t>(64 * n)) return normalise_columns(part, n);
    const abi::KernelStatus status =
        calls_.normalise(weights_.data(), part.slots(), part.slot_material.data(), owned_.data(), n,
                         tiles_.data(), codes_.data(), unusable_.data());
    for (int32_t i = 0; i < 8 * n; ++i)
        counts.unusable += unusable_[i];
    return status;
}

// Same as normalise, for the blocks in packed_owned_ and packed_weights_.
abi::KernelStatus BlockEvaluator::normalise_packed(const PlacedPart& part, int32_t n) {
    packed_codes_.resize(kBatchValues);
    packed_tiles_.resize(tiles_.size());
    const abi::KernelStatus status = calls_.normalise(
        packed_weights_.data(), part.slots(), part.slot_material.data(), packed_owned_.data(), n,
        packed_tiles_.data(), packed_codes_.data(), unusable_.data());
    for (int32_t i = 0; i < 8 * n; ++i)
        counts.unusable += unusable_[i];
    return status;
}

// Normalises a single slice (the first of a large print): eight blocks at a time, as the slices of
// one block. Other slices of a tile keep stale values, which are never read.
abi::KernelStatus BlockEvaluator::normalise_slice(const PlacedPart& part, int32_t n, int32_t z) {
    const auto slots = static_cast<size_t>(part.slots()),
               channels = static_cast<size_t>(calls_.channels());
    const int32_t packed = (n + 7) / 8;
    grow(&packed_weights_, kBatchValues * slots);
    if (n % 8 != 0)
        std::fill_n(packed_weights_.begin(), static_cast<size_t>(packed) * slots * kBlockValues,
                    0.0f);
    packed_owned_.assign(64 * static_cast<size_t>(packed), 0);
    const auto at = [](size_t block) { return block / 8; };
    for (size_t i = 0; i < static_cast<size_t>(n); ++i) {
        for (size_t v = 0; v < 64; ++v) {
            const auto bit = static_cast<uint8_t>(owned_[64 * i + v] >> z & 1);
            packed_owned_[64 * at(i) + v] |= static_cast<uint8_t>(bit << i % 8);
        }
        for (size_t s = 0; s < slots; ++s) {
            const float* from = &weights_[(i * slots + s) * kBlockValues] + z;
            float* to = &packed_weights_[(at(i) * slots + s) * kBlockValues] + i % 8;
            for (size_t v = 0; v < 64; ++v)
                to[8 * v] = from[8 * v];
        }
    }
    const abi::KernelStatus status = normalise_packed(part, packed);
    for (size_t i = 0; i < static_cast<size_t>(n); ++i) {
        const uint8_t* codes = &packed_codes_[at(i) * kBlockValues] + i % 8;
        for (size_t v = 0; v < 64; ++v)
            codes_[i * kBlockValues + 8 * v + static_cast<size_t>(z)] = codes[8 * v];
        const uint16_t* from = &packed_tiles_[at(i) * kBlockValues * channels] + i % 8;
        uint16_t* to = &tiles_[i * kBlockValues * channels] + z;
        for (size_t v = 0; v < 64 * channels; ++v)
            to[8 * v] = from[8 * v];
    }
    return status;
}

// Normalises only columns with unknown codes, packed into blocks; used where many codes are known.
abi::KernelStatus BlockEvaluator::normalise_columns(const PlacedPart& part, int32_t n) {
    const auto slots = static_cast<size_t>(part.slots()),
               tile_column = 8 * static_cast<size_t>(calls_.channels());
    const size_t packed = (columns_.size() + 63) / 64;
    grow(&packed_weights_, kBatchValues * slots);
    packed_owned_.assign(64 * packed, 0);
    for (size_t i = 0; i < columns_.size(); ++i) {
        const size_t from = columns_[i];
        packed_owned_[i] = owned_[from];
        for (size_t s = 0; s < slots; ++s) {
            std::memcpy(&packed_weights_[(i / 64 * slots + s) * kBlockValues + 8 * (i % 64)],
                        &weights_[(from / 64 * slots + s) * kBlockValues + 8 * (from % 64)],
                        8 * sizeof(float));
        }
    }
    const abi::KernelStatus status = columns_.empty()
                                         ? abi::KernelStatus()
                                         : normalise_packed(part, static_cast<int32_t>(packed));
    for (size_t i = 0; i < columns_.size(); ++i) {
        const size_t to = columns_[i];
        std::memcpy(&codes_[8 * to], &packed_codes_[8 * i], 8);
        std::memcpy(&tiles_[tile_column * to], &packed_tiles_[tile_column * i],
                    tile_column * sizeof(uint16_t));
    }
    // A part without queries has no engine and no culled pieces.
    for (size_t block = 0; block < static_cast<size_t>(n); ++block) {
        for (uint32_t left = culled_pieces_[block]; left != 0; left &= left - 1) {
            const auto p = static_cast<size_t>(std::countr_zero(left));
            const uint8_t code = culled_code_[block][p];
            if (code == OPENFAB_CODE_MIXED) continue;
            const nearest::BlockPieces& pieces = part.engine->pieces();
            for_each_column(pieces, p, [&](size_t column, uint8_t) {
                std::fill_n(&codes_[block * kBlockValues + 8 * column] + pieces.lowest[p].z,
                            pieces.size.z, code);
            });
        }
    }
    return status;
}

abi::KernelStatus BlockEvaluator::evaluate(const PlacedPart& part, int32_t slab,
                                           const OwnedBlock* blocks, int32_t n, bool try_pieces,
                                           dither::RowBand* band, PrintfLog* log) {
    OPENFAB_CHECK_GT(n, 0);
    OPENFAB_CHECK_LE(n, kBatch);
    const double start = seconds_now();
    prepare(part);
    blocks_.clear();
    for (int32_t i = 0; i < n; ++i) {
        int32_t* corner = &corners_[static_cast<size_t>(3 * i)];
        corner[0] = 8 * blocks[i].block - part.base.x;
        corner[1] = 8 * band->row - part.base.y;
        corner[2] = 8 * slab - part.base.z;
        blocks_.push_back({corner[0], corner[1], corner[2]});
        std::copy(blocks[i].owned.begin(), blocks[i].owned.end(),
                  &owned_[static_cast<size_t>(64 * i)]);
    }
    culled_pieces_.fill(0);
    known_code_mask_.fill(0);
    if (part.volume.any()) {
        if (const abi::KernelStatus status = find_demand(part, n); !status.ok()) return status;
        if (try_pieces && part.bounds.distance) {
            if (const abi::KernelStatus status = cull_pieces(part, n); !status.ok()) return status;
        } else {
            prepare_queries(part, n);
        }
    }
    for (int32_t i = 0; i < n && part.volume.any(); ++i) {
        query(part, i);
        const auto advance = [](auto& targets) {
            for (auto*& t : targets) {
                if (t != nullptr) t += kBlockValues;
            }
        };
        advance(value_targets_);
        advance(gradient_targets_);
        advance(flat_targets_);
    }
    const double queried = seconds_now();
    abi::KernelStatus status = run_volume(part, n, log);
    const double evaluated = seconds_now();
    if (!status.ok()) return status;
    status = normalise(part, n);
    if (!status.ok()) return status;
    for (int32_t i = 0; i < n; ++i) {
        const auto index = static_cast<size_t>(i);
        band->merge(blocks[i].block, blocks[i].owned.data(), &codes_[index * kBlockValues],
                    &tiles_[index * static_cast<size_t>(calls_.tile_values())], calls_.channels());
    }
    counts.evaluated += n;
    counts.seconds_nearest += queried - start;
    counts.seconds_volume += evaluated - queried;
    counts.seconds_normalise += seconds_now() - evaluated;
    return {};
}

abi::KernelStatus BlockEvaluator::constant_block(const PlacedPart& part, const float* weights,
                                                 uint8_t* codes, uint16_t* tile) {
    grow(&weights_, static_cast<size_t>(part.slots()) * kBatchValues);
    for (int32_t s = 0; s < part.slots(); ++s) {
        std::fill_n(weights_.begin() + static_cast<std::ptrdiff_t>(s * 512), kBlockValues,
                    weights[s]);
    }
    std::array<uint8_t, 64> all;
    all.fill(255);
    return calls_.normalise(weights_.data(), part.slots(), part.slot_material.data(), all.data(), 1,
                            tile, codes, unusable_.data());
}

}  // namespace openfab::volume

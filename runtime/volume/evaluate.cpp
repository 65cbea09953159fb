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

void place_fractions(const abi::Channels& channels, const uint16_t* from, uint16_t* to) {
    for (int32_t channel = 0; channel < channels.count(); ++channel) {
        const int32_t material = channels.material(channel);
        if (material >= 0) std::copy_n(from + 8 * channel, 8, to + 8 * material);
    }
}

BlockEvaluator::BlockEvaluator(openfab_isa isa, size_t parts)
    : isa_(isa), scratch_(parts), attribute_scratch_(parts), segments_(parts) {
    demanded_.resize(kBatchValues);
    distance_.resize(kBatchValues);
    codes_.resize(kBatchValues);
    unusable_.resize(kBatchValues);
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

// Allocates the part's inputs and outputs, and notes which inputs its slab kernel reads.
void BlockEvaluator::prepare(const PlacedPart& part) {
    const auto floats = static_cast<size_t>(part.nearest.floats());
    const auto ints = static_cast<size_t>(part.nearest.ints());
    grow(&values_, floats * kBatchValues);
    grow(&gradients_, part.volume.gradients ? floats * 3 * kBatchValues : 0);
    grow(&flat_, ints * kBatchValues);
    grow(&fractions_, static_cast<size_t>(part.channels.count()) * kBatchValues);
    value_targets_.assign(floats, nullptr);
    gradient_targets_.assign(floats * 3, nullptr);
    flat_targets_.assign(ints, nullptr);
    const openfab_kernel& kernel = part.part->fablet->slab;
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

// Lists the columns with owned voxels whose codes are not known.
void BlockEvaluator::list_columns(int32_t n) {
    columns_.clear();
    for (int32_t block = 0; block < n; ++block) {
        first_column_[static_cast<size_t>(block)] = columns_.size();
        for (int32_t i = 64 * block; i < 64 * block + 64; ++i) {
            const auto at = static_cast<size_t>(i);
            if ((owned_[at] & ~known_code_mask_[at]) != 0) columns_.push_back(i);
        }
    }
    first_column_[static_cast<size_t>(n)] = columns_.size();
}

// Leaves in demand_ the voxels that look at their nearest surface point: all, where the fablet has
// no kernel that tells.
abi::KernelStatus BlockEvaluator::find_demand(const PlacedPart& part, int32_t n) {
    const openfab_kernel& kernel = part.part->fablet->volume_demand;
    if (kernel.arg_count == 0 || columns_.empty()) return {};
    arguments_.begin(kernel, part, corners_.data(), n, 8);
    arguments_.set_groups(columns_);
    for (int32_t i = 0; i < kernel.arg_count; ++i) {
        if (kernel.args[i].kind == OPENFAB_ARG_DEMAND) arguments_.set_columns(i, demanded_.data());
    }
    if (const abi::KernelStatus status = arguments_.run(isa_); !status.ok()) return status;
    for (size_t i = 0; i < columns_.size(); ++i) {
        uint32_t bits = 0;
        for (size_t z = 0; z < 8; ++z)
            bits |= static_cast<uint32_t>(demanded_[8 * i + z] & 1) << z;
        demand_[columns_[i]] &= static_cast<uint8_t>(bits);
    }
    return {};
}

// Pieces that hold one composition whatever a query would say need none: for any distance in the
// interval the slab kernel gives that composition.
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

// The code of what piece_weights_ say, from what is known of the part or by normalising it.
abi::KernelStatus BlockEvaluator::find_culled_code(const PlacedPart& part, uint8_t* code) {
    constexpr size_t kMostKnown = 8;
    if (known_part_ != &part) known_codes_.clear();
    known_part_ = &part;
    const auto known = std::ranges::find(known_codes_, piece_weights_, &KnownCode::weights);
    *code = known != known_codes_.end() ? known->code : uint8_t{OPENFAB_CODE_MIXED};
    if (known != known_codes_.end() || known_codes_.size() == kMostKnown) return {};
    const abi::KernelStatus status = constant_column(part, piece_weights_.data(), &constant_);
    if (constant_.usable) *code = constant_.codes[0];
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
// hold the patches near all of them at once.
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

// `fractions`: of the listed columns, `channels` * 8 values each.
abi::KernelStatus BlockEvaluator::run_slab(const PlacedPart& part, int32_t n, int32_t channels,
                                           uint16_t* fractions) {
    const openfab_kernel& kernel = part.part->fablet->slab;
    arguments_.begin(kernel, part, corners_.data(), n, 8);
    arguments_.set_groups(columns_);
    for (int32_t i = 0; i < kernel.arg_count; ++i) {
        const openfab_arg& arg = kernel.args[i];
        switch (arg.kind) {
            case OPENFAB_ARG_CODE:
                arguments_.set_columns(i, codes_.data());
                break;
            case OPENFAB_ARG_UNUSABLE:
                arguments_.set_columns(i, unusable_.data());
                break;
            case OPENFAB_ARG_FRACTION:
                if (const int32_t material = part.channels.material(arg.a); material >= 0) {
                    arguments_.set_columns(i, fractions + static_cast<ptrdiff_t>(8 * material),
                                           8 * channels);
                } else {
                    arguments_.set_columns(i,
                                           &fractions_[static_cast<size_t>(arg.a) * kBatchValues]);
                }
                break;
            default:
                if (!arguments_.is_set(i)) arguments_.set_blocks(i, input(part, arg));
        }
    }
    return arguments_.run(isa_);
}

abi::KernelStatus BlockEvaluator::run_segments(const PlacedPart& part, int32_t n, int32_t channels,
                                               uint16_t* fractions, PrintfLog* log) {
    grow(&weights_, static_cast<size_t>(part.slots()) * kBatchValues);
    abi::KernelStatus status = segments_.run(
        part, isa_, corners_.data(), owned_.data(), n,
        [&](const openfab_arg& arg) { return input(part, arg); }, weights_.data(), kBatchValues,
        log);
    if (!status.ok()) return status;
    status = abi::normalise(isa_, columns_, part.channels, weights_.data(), kBatchValues,
                            fractions_.data(), codes_.data(), unusable_.data());
    const auto step = static_cast<ptrdiff_t>(8 * part.channels.count());
    for (size_t i = 0; i < columns_.size() && status.ok(); ++i) {
        const auto at = static_cast<ptrdiff_t>(i);
        place_fractions(part.channels, fractions_.data() + step * at,
                        fractions + ptrdiff_t{8} * channels * at);
    }
    return status;
}

// `fractions`: number in the band of the first listed column.
void BlockEvaluator::merge(const PlacedPart& part, const OwnedBlock* blocks, int32_t n,
                           int32_t fractions, dither::RowBand* band) {
    for (size_t i = 0; i < static_cast<size_t>(n); ++i) {
        const size_t first = first_column_[i], count = first_column_[i + 1] - first;
        band->merge(blocks[i].block, blocks[i].owned.data(),
                    {{columns_.data() + first, count},
                     &codes_[8 * first],
                     fractions + static_cast<int32_t>(first)});
        // A part without queries has no engine and no culled pieces.
        for (uint32_t left = culled_pieces_[i]; left != 0; left &= left - 1) {
            const auto p = static_cast<size_t>(std::countr_zero(left));
            const uint8_t code = culled_code_[i][p];
            if (code == OPENFAB_CODE_MIXED) continue;
            for_each_column(part.engine->pieces(), p, [&](size_t column, uint8_t bits) {
                const auto voxels = static_cast<uint8_t>(bits & blocks[i].owned[column]);
                band->fill_column(blocks[i].block, static_cast<int32_t>(column), voxels, code);
            });
        }
    }
    for (size_t i = 0; i < columns_.size(); ++i) {
        std::array<uint16_t, 8> unusable;
        std::memcpy(unusable.data(), &unusable_[8 * i], sizeof(unusable));
        if (unusable == std::array<uint16_t, 8>{}) continue;
        for (size_t z = 0; z < 8; ++z)
            counts.unusable += unusable[z] * (owned_[columns_[i]] >> z & 1);
    }
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
    demand_ = owned_;
    culled_pieces_.fill(0);
    known_code_mask_.fill(0);
    const bool cull = part.volume.any() && try_pieces && part.bounds.distance;
    abi::KernelStatus status;
    if (cull) status = cull_pieces(part, n);
    list_columns(n);
    if (status.ok() && part.volume.any()) {
        status = find_demand(part, n);
        if (!cull) prepare_queries(part, n);
    }
    for (int32_t i = 0; i < n && part.volume.any() && status.ok(); ++i) {
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
    const int32_t fractions = band->add_columns(columns_.size());
    if (status.ok() && !columns_.empty()) {
        uint16_t* to = band->fractions_at(fractions);
        status = part.part->fablet->volume_segments.step_count > 0
                     ? run_segments(part, n, band->channels, to, log)
                     : run_slab(part, n, band->channels, to);
    }
    if (!status.ok()) return status;
    merge(part, blocks, n, fractions, band);
    counts.evaluated += n;
    counts.seconds_nearest += queried - start;
    counts.seconds_slab += seconds_now() - queried;
    return {};
}

abi::KernelStatus BlockEvaluator::constant_column(const PlacedPart& part, const float* weights,
                                                  ConstantColumn* out) {
    const auto slots = static_cast<size_t>(part.slots());
    std::vector<float> amounts(8 * slots);
    for (size_t s = 0; s < slots; ++s)
        std::fill_n(&amounts[8 * s], 8, weights[s]);
    out->fractions.resize(8 * static_cast<size_t>(part.channels.count()));
    std::array<uint16_t, 8> unusable{};
    constexpr int32_t kFirst = 0;
    const abi::KernelStatus status =
        abi::normalise(isa_, {&kFirst, 1}, part.channels, amounts.data(), 8, out->fractions.data(),
                       out->codes.data(), unusable.data());
    out->usable = status.ok() && unusable[0] == 0;
    return status;
}

}  // namespace openfab::volume

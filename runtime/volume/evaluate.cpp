// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/volume/evaluate.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>

#include "base/at.h"
#include "base/check.h"
#include "base/count_bits.h"
#include "base/grow.h"
#include "base/stage_timer.h"

namespace openfab::volume {

namespace {

constexpr size_t kBlockValues = nearest::kBlockVoxels;
constexpr size_t kBatchValues = kBlockValues * BlockEvaluator::kBatch;
static_assert(64 * BlockEvaluator::kBatch <= OPENFAB_MOST_COLUMNS);

/// Fills a list of columns up to a length that the slab kernel takes.
void fill_up(std::vector<int32_t>* columns) {
    constexpr size_t kUnit = OPENFAB_LISTED_COLUMNS;
    if (!columns->empty())
        columns->resize((columns->size() + kUnit - 1) / kUnit * kUnit, columns->back());
}

}  // namespace

void RowRates::reset(int32_t width_vox, int32_t material_count, int32_t column_count) {
    width = width_vox;
    materials = material_count;
    columns = column_count;
    any = false;
    values.assign(static_cast<size_t>(width) * 64 * per_voxel(), 0.0f);
}

void place_fractions(const abi::Channels& channels, const uint16_t* from, uint16_t* to) {
    for (int32_t channel = 0; channel < channels.count(); ++channel) {
        const int32_t material = channels.material(channel);
        if (material >= 0) std::copy_n(from + 8 * channel, 8, to + 8 * material);
    }
}

BlockEvaluator::BlockEvaluator(openfab_isa isa, size_t parts)
    : counts(parts), isa_(isa), nearest_(parts), segments_(parts) {
    codes_.resize(kBatchValues);
    unusable_.resize(kBatchValues);
}

nearest::QueryCounts BlockEvaluator::query_counts() const {
    nearest::QueryCounts sum = nearest_.query_counts();
    sum.skipped += counts.known_blocks * nearest::kBlockVoxels;
    sum.add(segments_.query_counts());
    return sum;
}

void BlockEvaluator::take_blocks(const PlacedPart& part, int32_t slab, int32_t row,
                                 const OwnedBlock* blocks, int32_t n) {
    blocks_.clear();
    for (int32_t i = 0; i < n; ++i) {
        const Vec3i corner{8 * blocks[i].block - part.base.x, 8 * row - part.base.y,
                           8 * slab - part.base.z};
        for (int32_t axis = 0; axis < 3; ++axis)
            corners_[static_cast<size_t>(3 * i + axis)] = corner[axis];
        blocks_.push_back(corner);
        at(blind_, i) = blocks[i].blind_distance;
        at(attributes_, i) = blocks[i].attributes;
        std::copy(blocks[i].owned.begin(), blocks[i].owned.end(),
                  &owned_[static_cast<size_t>(64 * i)]);
    }
}

// Lists the columns with owned voxels whose codes are not known.
void BlockEvaluator::list_columns(int32_t n) {
    columns_.clear();
    for (size_t block = 0; block < static_cast<size_t>(n); ++block) {
        first_column_[block] = columns_.size();
        for (size_t column = 0; column < 64; ++column) {
            uint8_t open = owned_[64 * block + column];
            if (culls_) open &= static_cast<uint8_t>(~culled_[block].known[column]);
            if (open != 0) columns_.push_back(static_cast<int32_t>(64 * block + column));
        }
    }
    first_column_[static_cast<size_t>(n)] = columns_.size();
    fill_up(&columns_);
}

abi::KernelStatus BlockEvaluator::run_slab(const PlacedPart& part, int32_t first, int32_t count,
                                           std::span<const int32_t> columns, int32_t channels,
                                           uint16_t* fractions) {
    const openfab_kernel& kernel = part.part->fablet->slab;
    grow(&fractions_, static_cast<size_t>(8 * part.channels.count()));
    choices_.resize(kBatchValues);
    const size_t column = first_column_[static_cast<size_t>(first)];
    const int32_t values = static_cast<int32_t>(kBlockValues) * count;
    arguments_.begin(kernel, part, &corners_[static_cast<size_t>(3 * first)], count, 8);
    arguments_.set_groups(columns);
    for (int32_t i = 0; i < kernel.arg_count; ++i) {
        const openfab_arg& arg = kernel.args[i];
        if (kernel.packed != 0 && arg.kind == OPENFAB_ARG_CODE)
            return run_packed_slab(part, i, column, columns.size(), channels, fractions);
        switch (arg.kind) {
            case OPENFAB_ARG_CODE:
                arguments_.set_columns(i, &codes_[8 * column]);
                break;
            case OPENFAB_ARG_UNUSABLE:
                arguments_.set_columns(i, &unusable_[8 * column]);
                break;
            case OPENFAB_ARG_FRACTION:
                if (const int32_t material = part.channels.material(arg.a);
                    material >= 0 && fractions != nullptr) {
                    const auto at = 8 * (column * static_cast<size_t>(channels) +
                                         static_cast<size_t>(material));
                    arguments_.set_columns(i, fractions + at, 8 * channels);
                } else {
                    arguments_.set_columns(i, &fractions_[static_cast<size_t>(8 * arg.a)], 0);
                }
                break;
            case OPENFAB_ARG_CHOICE:
                arguments_.set_columns(i, &choices_[8 * column]);
                break;
            case OPENFAB_ARG_STATE:
                arguments_.set_values(i, segments_.state(arg.a), values);
                break;
            case OPENFAB_ARG_NEAREST:
            case OPENFAB_ARG_NEAREST_GRAD:
            case OPENFAB_ARG_DISTANCE:
                arguments_.set_values(i, field(part, arg, first), values);
                break;
            case OPENFAB_ARG_NEAREST_SOURCE:
                arguments_.set_source(i, nearest_.source());
                break;
            default:
                break;
        }
    }
    return arguments_.run(isa_);
}

// Runs a slab kernel whose outputs, from argument `first` on, are one buffer, and takes them apart.
abi::KernelStatus BlockEvaluator::run_packed_slab(const PlacedPart& part, int32_t first,
                                                  size_t column, size_t count, int32_t channels,
                                                  uint16_t* fractions) {
    const openfab_kernel& kernel = part.part->fablet->slab;
    const auto outputs = static_cast<size_t>(kernel.arg_count - first);
    grow(&packed_, 8 * outputs * count);
    arguments_.set_packed_columns(first, packed_.data(), static_cast<int32_t>(outputs));
    const abi::KernelStatus status = arguments_.run(isa_);
    const bool chooses = kernel.args[kernel.arg_count - 1].kind == OPENFAB_ARG_CHOICE;
    for (size_t i = 0; i < count && status.ok(); ++i) {
        const uint16_t* from = &packed_[8 * outputs * i];
        const size_t to = 8 * (column + i);
        for (size_t z = 0; z < 8; ++z) {
            codes_[to + z] = static_cast<uint8_t>(from[z]);
            unusable_[to + z] = from[8 + z];
            if (chooses) choices_[to + z] = static_cast<uint8_t>(from[8 * (outputs - 1) + z]);
        }
        if (fractions == nullptr) continue;
        place_fractions(part.channels, from + 16, fractions + static_cast<size_t>(channels) * to);
    }
    return status;
}

// Answers what the segments read of nearest surface points, for whole blocks.
abi::KernelStatus BlockEvaluator::ask_for_segments(const PlacedPart& part, int32_t n) {
    const openfab_fablet& fablet = *part.part->fablet;
    if (fablet.field_count == 0) return {};
    const auto voxels = kBlockValues * static_cast<size_t>(n);
    grow(&fields_, static_cast<size_t>(fablet.field_count) * kBatchValues);
    demand_.assign(voxels, 1);
    const openfab_kernel& kernel = fablet.volume_demand;
    if (kernel.arg_count > 0) {
        arguments_.begin(kernel, part, corners_.data(), n, 8);
        arguments_.set_groups(all_columns_);
        for (int32_t i = 0; i < kernel.arg_count; ++i) {
            if (kernel.args[i].kind == OPENFAB_ARG_DEMAND)
                arguments_.set_columns(i, demand_.data());
        }
        if (const abi::KernelStatus status = arguments_.run(isa_); !status.ok()) return status;
    }
    const openfab_nearest_request request{
        0, 64 * n, demand_.data(), 8, fields_.data(), static_cast<ptrdiff_t>(kBatchValues), 8};
    openfab_nearest_source* source = nearest_.source();
    return abi::KernelStatus::of_code(source->answer(source, &request));
}

/// Returns where the values of a field begin, of blocks from `first` on.
const float* BlockEvaluator::field(const PlacedPart& part, const openfab_arg& arg,
                                   int32_t first) const {
    const openfab_fablet& fablet = *part.part->fablet;
    const auto same = [&](const openfab_arg& field) {
        return field.kind == arg.kind && field.a == arg.a && field.b == arg.b;
    };
    const auto index =
        std::find_if(fablet.fields, fablet.fields + fablet.field_count, same) - fablet.fields;
    OPENFAB_CHECK_LT(index, fablet.field_count);
    return &fields_[static_cast<size_t>(index) * kBatchValues +
                    static_cast<size_t>(first) * kBlockValues];
}

/// Adds up the derivatives of each material's slots, in their order.
void BlockEvaluator::take_rates(const PlacedPart& part, int32_t first, int32_t count,
                                const OwnedBlock* blocks) {
    const auto slots = part.slots();
    rates->any = true;
    for (int32_t i = 0; i < count; ++i) {
        const OwnedBlock& block = blocks[first + i];
        for (size_t k = 0; k < rate_columns.size(); ++k) {
            if (rate_columns[k] < 0) continue;
            for (int32_t slot = 0; slot < slots; ++slot) {
                const int32_t material = part.part->slot_material[static_cast<size_t>(slot)];
                if (material == 0) continue;
                const int32_t state = 1 + slots * (1 + static_cast<int32_t>(k)) + slot;
                const auto* from = reinterpret_cast<const float*>(segments_.state(state)) +
                                   static_cast<size_t>(i) * kBlockValues;
                const int32_t to = rate_columns[k] * rates->materials + material - 1;
                for (int32_t column = 0; column < 64; ++column, from += 8) {
                    const uint8_t owned = block.owned[static_cast<size_t>(column)];
                    if (owned == 0) continue;
                    float* sums = rates->at(8 * block.block + column % 8, column / 8, to);
                    for (int32_t z = 0; z < 8; ++z)
                        sums[z] += (owned >> z & 1) != 0 ? from[z] : 0.0f;
                }
            }
        }
    }
}

abi::KernelStatus BlockEvaluator::run_segments(const PlacedPart& part, const OwnedBlock* blocks,
                                               int32_t n, int32_t channels, uint16_t* fractions,
                                               segments::PrintfLog* log) {
    abi::KernelStatus status = ask_for_segments(part, n);
    const int32_t most = VolumeSegments::most_blocks(part);
    for (int32_t first = 0; first < n && status.ok(); first += most) {
        const int32_t count = std::min(most, n - first);
        const auto begin = static_cast<size_t>(first), end = static_cast<size_t>(first + count);
        listed_.clear();
        for (size_t i = first_column_[begin]; i < first_column_[end]; ++i)
            listed_.push_back(columns_[i] - 64 * first);
        if (listed_.empty()) continue;
        // What it is filled up with is written where the columns of the next blocks go later.
        fill_up(&listed_);
        const auto input = [&](const openfab_arg& arg) -> const void* {
            return field(part, arg, first);
        };
        status = segments_.run(part, isa_, &corners_[3 * begin], &owned_[64 * begin], count, input,
                               log, stop);
        if (!status.ok()) break;
        if (rates != nullptr) take_rates(part, first, count, blocks);
        status = part.part->fablet->slab.arg_count > 0
                     ? run_slab(part, first, count, listed_, channels, fractions)
                     : normalise_states(part, first, channels, fractions);
    }
    return status;
}

abi::KernelStatus BlockEvaluator::normalise_states(const PlacedPart& part, int32_t first,
                                                   int32_t channels, uint16_t* fractions) {
    grow(&fractions_, static_cast<size_t>(part.channels.count()) * kBatchValues);
    const size_t column = first_column_[static_cast<size_t>(first)];
    const abi::KernelStatus status = abi::normalise(
        isa_, listed_, part.channels, reinterpret_cast<const float*>(segments_.state(1)),
        segments_.state(1) - segments_.state(0), fractions_.data(), &codes_[8 * column],
        &unusable_[8 * column]);
    const auto step = static_cast<size_t>(8 * part.channels.count());
    for (size_t i = 0; i < listed_.size() && status.ok(); ++i) {
        place_fractions(part.channels, &fractions_[step * i],
                        fractions + 8 * static_cast<size_t>(channels) * (column + i));
    }
    return status;
}

void BlockEvaluator::count_columns(const PlacedPart& part) {
    const auto columns = static_cast<int64_t>(columns_.size());
    counts.columns += columns;
    // Fields are floats; of a voxel there are a code, a count, and fractions.
    counts.nearest_bytes += columns * 8 * 4 * part.part->fablet->field_count;
    counts.slab_bytes += columns * 8 * (3 + 2 * part.channels.count());
}

void BlockEvaluator::merge(const PlacedPart& part, const OwnedBlock* blocks, int32_t n,
                           const uint8_t* codes, int32_t fractions, dither::RowBand* band) const {
    for (size_t i = 0; i < static_cast<size_t>(n); ++i) {
        const size_t first = first_column_[i], count = first_column_[i + 1] - first;
        band->merge(blocks[i].block, blocks[i].owned.data(),
                    {{columns_.data() + first, count},
                     codes + 8 * first,
                     fractions + static_cast<int32_t>(first)});
        for (uint32_t left = culls_ ? culled_[i].pieces : 0; left != 0; left &= left - 1) {
            const auto p = static_cast<size_t>(std::countr_zero(left));
            const uint8_t code = culled_[i].code[p];
            if (code == OPENFAB_CODE_MIXED) continue;
            for_each_column(part.engine().pieces(), p, [&](size_t column, uint8_t bits) {
                const auto voxels = static_cast<uint8_t>(bits & blocks[i].owned[column]);
                band->fill_column(blocks[i].block, static_cast<int32_t>(column), voxels, code);
            });
        }
    }
}

int64_t BlockEvaluator::count_empty(const PlacedPart& part, int32_t n) const {
    constexpr std::array<uint8_t, 64> none{};
    int64_t count = 0;
    for (size_t block = 0; block < static_cast<size_t>(n); ++block) {
        const uint8_t* owned = &owned_[64 * block];
        alignas(8) std::array<uint8_t, 64> empty{};
        const uint8_t* known = culls_ ? culled_[block].known.data() : none.data();
        for (size_t i = first_column_[block]; i < first_column_[block + 1]; ++i) {
            uint64_t codes;
            std::memcpy(&codes, &codes_[8 * i], 8);
            constexpr uint64_t kLow = 0x0101010101010101u, kSeven = 0x7f * kLow;
            const uint64_t zero = ~(((codes & kSeven) + kSeven) | codes | kSeven);
            const size_t at = static_cast<size_t>(columns_[i]) % 64;
            // The bit of byte z, as bit z.
            empty[at] = static_cast<uint8_t>((zero >> 7) * 0x0102040810204080u >> 56) & owned[at] &
                        static_cast<uint8_t>(~known[at]);
        }
        for (uint32_t left = culls_ ? culled_[block].pieces : 0; left != 0; left &= left - 1) {
            const auto p = static_cast<size_t>(std::countr_zero(left));
            if (culled_[block].code[p] != 0) continue;
            for_each_column(part.engine().pieces(), p, [&](size_t column, uint8_t bits) {
                empty[column] |= bits & owned[column];
            });
        }
        count += count_bits(empty);
    }
    return count;
}

void BlockEvaluator::count_unusable(int32_t n, PartVoxels* voxels) const {
    for (size_t i = 0; i < first_column_[static_cast<size_t>(n)]; ++i) {
        std::array<uint16_t, 8> unusable;
        std::memcpy(unusable.data(), &unusable_[8 * i], sizeof(unusable));
        if (unusable == std::array<uint16_t, 8>{}) continue;
        // What is known was not evaluated for itself.
        const auto at = static_cast<size_t>(columns_[i]);
        const int known = culls_ ? culled_[at / 64].known[at % 64] : 0;
        for (size_t z = 0; z < 8; ++z)
            voxels->unusable += unusable[z] * ((owned_[at] & ~known) >> z & 1);
    }
}

abi::KernelStatus BlockEvaluator::evaluate(const PlacedPart& part, int32_t slab,
                                           const OwnedBlock* blocks, int32_t n,
                                           const CullTries& tries, dither::RowBand* band,
                                           dither::RowBand* mixtures, segments::PrintfLog* log) {
    OPENFAB_CHECK_GT(n, 0);
    OPENFAB_CHECK_LE(n, kBatch);
    const StageTimer timer(Stage::kSlab, &counts.seconds_slab);
    take_blocks(part, slab, band->row, blocks, n);
    const bool any_blind = std::any_of(blind_.begin(), blind_.begin() + n,
                                       [](float distance) { return !std::isnan(distance); });
    culls_ = part.volume.any() && (tries.any() || any_blind) && part.bounds.distance;
    abi::KernelStatus status;
    if (culls_)
        status = piece_cull_.run(part, blocks_, blind_.data(), attributes_.data(), tries,
                                 &cube_bounds_, bound_tools(part), culled_.data());
    if (!status.ok()) return status;
    list_columns(n);
    const bool segments = part.part->fablet->volume_segments.step_count > 0;
    if (segments) {
        all_columns_.resize(static_cast<size_t>(64 * n));
        std::iota(all_columns_.begin(), all_columns_.end(), 0);
    }
    nearest_.begin({&part,
                    blocks_,
                    {owned_.data(), static_cast<size_t>(64 * n)},
                    segments ? all_columns_ : columns_,
                    {culled_.data(), culls_ ? static_cast<size_t>(n) : 0}});
    // A fablet's own rule leaves nothing mixed in the band.
    dither::RowBand* const kept = part.own_dither ? mixtures : band;
    // Segments fill up one list after the other.
    const size_t room = segments ? std::min(columns_.size() + OPENFAB_LISTED_COLUMNS - 1,
                                            static_cast<size_t>(64 * n))
                                 : columns_.size();
    const int32_t fractions = kept != nullptr ? kept->add_columns(room) : 0;
    if (!columns_.empty()) {
        uint16_t* to = kept != nullptr ? kept->fractions_at(fractions) : nullptr;
        status = segments ? run_segments(part, blocks, n, band->channels, to, log)
                          : run_slab(part, 0, n, columns_, band->channels, to);
    }
    if (!status.ok()) return status;
    merge(part, blocks, n, part.own_dither ? choices_.data() : codes_.data(), fractions, band);
    if (mixtures != nullptr) {
        int32_t number = fractions;
        if (kept != mixtures && !columns_.empty()) {
            number = mixtures->add_columns(columns_.size());
            std::copy_n(band->fractions_at(fractions),
                        columns_.size() * static_cast<size_t>(8 * band->channels),
                        mixtures->fractions_at(number));
        }
        merge(part, blocks, n, codes_.data(), number, mixtures);
    }
    PartVoxels& voxels = counts.by_part[static_cast<size_t>(part.index)];
    count_unusable(n, &voxels);
    voxels.empty += count_empty(part, n);
    counts.evaluated += n;
    count_columns(part);
    for (size_t i = 0; i < static_cast<size_t>(n) && culls_; ++i)
        counts.known_blocks += first_column_[i] == first_column_[i + 1] ? 1 : 0;
    return {};
}

}  // namespace openfab::volume

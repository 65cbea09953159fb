// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/process/bleed/bleed.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <utility>

#include "abi/stage_table.h"
#include "base/at.h"
#include "base/check.h"
#include "runtime/process/bleed/messages.h"

namespace openfab::process {

namespace {

constexpr float kWhole = 65535.0f;
constexpr size_t kMostBits = 64;
/// Block columns that are computed at a time: so few that what they take stays in a cache.
constexpr int32_t kRunBlocks = 8;

}  // namespace

Bleed::Bleed(std::vector<PairSpread> pairs, int32_t undo_steps, bool show)
    : kernels_(pairs), place_(256, -1), undo_steps_(undo_steps), show_(show) {
    for (size_t place = 0; place < kernels_.channels.size(); ++place)
        place_[kernels_.channels[place]] = static_cast<int32_t>(place);
    for (const BleedKernels::Pair& pair : kernels_.pairs)
        pair_bits_.push_back(bit_of(kernels_.channels[pair.a]) | bit_of(kernels_.channels[pair.b]));
    leaves_parts_ = show && place_[0] >= 0;
    // One more to find how much of it each voxel can take.
    const int32_t times = (undo_steps > 0 ? undo_steps + 1 : 0) + (show ? 1 : 0);
    for (int axis = 0; axis < 3; ++axis)
        reach_[axis] = times * kernels_.radius[axis];
}

Result<void> Bleed::begin(const EffectGrid& grid) {
    if (grid.ruled_fablet.empty()) return {};
    return user_error(fmt::format(messages::kBleedWithoutMixtures, grid.ruled_fablet));
}

uint64_t Bleed::bit_of(int32_t channel) const {
    const int32_t place = at(place_, channel);
    // Those beyond share a bit, which then says only that any of them may be there.
    return place < 0 ? 0 : uint64_t{1} << std::min(static_cast<size_t>(place), kMostBits - 1);
}

bool Bleed::may_change(uint64_t present) const {
    return std::any_of(pair_bits_.begin(), pair_bits_.end(),
                       [&](uint64_t pair) { return (present & pair) == pair; });
}

int64_t Bleed::spread_bytes() const {
    const int64_t x = 8 * kRunBlocks + 2 * reach_.x, y = 8 + 2 * reach_.y, z = 8 + 2 * reach_.z;
    const auto fields = static_cast<int64_t>(5 * kernels_.channels.size() + 3);
    return x * y * z * fields * static_cast<int64_t>(sizeof(float));
}

void Bleed::note(const dither::RowBand& band, std::vector<uint64_t>* notes) const {
    notes->assign(static_cast<size_t>(band.blocks), bit_of(0));
    for (int32_t block = band.first_block; block < band.end_block; ++block) {
        uint64_t bits = 0;
        for (int32_t y = 0; y < 8; ++y) {
            const uint8_t* marks = band.mixed_row(y);
            const size_t row = static_cast<size_t>(y) * static_cast<size_t>(band.width());
            for (int32_t x = 8 * block; x < 8 * block + 8; ++x) {
                const uint8_t* codes = &band.codes[(row + static_cast<size_t>(x)) * 8];
                uint64_t eight;
                std::memcpy(&eight, codes, 8);
                if (marks[x] == 0 && eight == codes[0] * 0x0101010101010101u) {
                    bits |= bit_of(codes[0]);
                    continue;
                }
                for (size_t z = 0; z < 8; ++z)
                    bits |= (marks[x] >> z & 1) != 0 ? 0 : bit_of(codes[z]);
                if (marks[x] == 0) continue;
                const auto column = static_cast<size_t>(band.columns[row + static_cast<size_t>(x)]);
                const auto channels = static_cast<size_t>(band.channels);
                const uint16_t* from = &band.fractions[column * 8 * channels];
                for (const uint8_t channel : kernels_.channels) {
                    if (channel >= channels) continue;
                    for (size_t z = 0; z < 8; ++z) {
                        if ((marks[x] >> z & 1) != 0 && from[8 * channel + z] != 0)
                            bits |= bit_of(channel);
                    }
                }
            }
        }
        (*notes)[static_cast<size_t>(block)] = bits;
    }
}

/// Finds what is present in each block of the row and those within reach, and returns the blocks that may
/// have to be computed.
Vec2<int32_t> Bleed::present_around(const NearBands& near, std::vector<uint64_t>* around) const {
    const dither::RowBand& own = *near.bands[near.bands.size() / 2].band;
    std::vector<uint64_t> any(static_cast<size_t>(own.blocks), 0);
    Vec2<int32_t> written{own.first_block, own.end_block};
    for (const NearBands::One& one : near.bands) {
        for (size_t block = 0; block < any.size(); ++block)
            any[block] |= one.band != nullptr ? (*one.notes)[block] : bit_of(0);
        if (one.band == nullptr || one.band->first_block >= one.band->end_block || !leaves_parts_)
            continue;
        if (written.x >= written.y) written = {one.band->first_block, one.band->end_block};
        written = {std::min(written.x, one.band->first_block),
                   std::max(written.y, one.band->end_block)};
    }
    const int32_t reach = reach_blocks().x;
    if (leaves_parts_ && written.x < written.y)
        written = {std::max(written.x - reach, 0), std::min(written.y + reach, own.blocks)};
    around->assign(any.size(), 0);
    for (int32_t block = 0; block < own.blocks; ++block) {
        for (int32_t x = block - reach; x <= block + reach; ++x)
            (*around)[static_cast<size_t>(block)] |=
                x < 0 || x >= own.blocks ? bit_of(0) : at(any, x);
    }
    return written;
}

void Bleed::spread(const NearBands& near, const Vec3i& size, dither::RowBand* out) const {
    BleedScratch* scratch = scratches_.take([] { return std::make_unique<BleedScratch>(); });
    apply(near, size, scratch, out);
    scratches_.give(scratch);
}

void Bleed::apply(const NearBands& near, const Vec3i& size, BleedScratch* scratch,
                  dither::RowBand* out) const {
    const dither::RowBand& own = *near.bands[near.bands.size() / 2].band;
    *out = own;
    const Vec2<int32_t> written = present_around(near, &scratch->present);
    if (written.x >= written.y) return;
    out->first_block = written.x;
    out->end_block = written.y;
    const auto changes = [&](int32_t block) { return may_change(at(scratch->present, block)); };
    const Vec3i slab_size{size.x, std::min(8, size.y - 8 * near.row),
                          std::min(8, size.z - 8 * near.slab)};
    for (int32_t first = written.x; first < written.y;) {
        if (!changes(first)) {
            ++first;
            continue;
        }
        int32_t end = first + 1;
        while (end < written.y && end - first < kRunBlocks && changes(end))
            ++end;
        const Vec3i lowest{8 * first - reach_.x, 8 * near.row - reach_.y, 8 * near.slab - reach_.z};
        scratch->window.reset(
            {8 * (end - first) + 2 * reach_.x, 8 + 2 * reach_.y, 8 + 2 * reach_.z},
            kernels_.channels.size());
        load(near, size, lowest, &scratch->window);
        scratch->window.run(kernels_, undo_steps_, show_);
        store(scratch->window, lowest, {first, end}, slab_size, out);
        first = end;
    }
}

/// Fills the window, whose lowest voxel is `lowest`, with fractions.
void Bleed::load(const NearBands& near, const Vec3i& size, const Vec3i& lowest,
                 BleedWindow* window) const {
    const Vec3i near_blocks = reach_blocks(), extent = window->size();
    const int32_t rows = 2 * near_blocks.y + 1;
    const auto put = [&](int32_t channel, size_t at, float value) {
        const int32_t place = openfab::at(place_, channel);
        if (place >= 0) window->fractions(static_cast<size_t>(place))[at] = value;
    };
    for (int32_t z = 0; z < extent.z; ++z) {
        const int32_t slab = (lowest.z + z + 8 * kMostReach) / 8 - kMostReach - near.slab;
        const int32_t in_slab = (lowest.z + z) & 7;
        for (int32_t y = 0; y < extent.y; ++y) {
            const int32_t row = (lowest.y + y + 8 * kMostReach) / 8 - kMostReach - near.row;
            const int32_t in_row = (lowest.y + y) & 7;
            const dither::RowBand* band =
                at(near.bands, (slab + near_blocks.z) * rows + row + near_blocks.y).band;
            const bool outside = band == nullptr || lowest.z + z < 0 || lowest.z + z >= size.z ||
                                 lowest.y + y < 0 || lowest.y + y >= size.y;
            const size_t at = window->at(0, y, z);
            for (int32_t i = 0; i < extent.x; ++i) {
                const int32_t x = lowest.x + i;
                const size_t to = at + static_cast<size_t>(i);
                if (outside || x < 0 || x >= size.x) {
                    put(0, to, 1.0f);
                    continue;
                }
                const auto voxel = static_cast<size_t>(in_row * band->width() + x);
                if ((band->mixed_row(in_row)[x] >> in_slab & 1) == 0) {
                    put(band->codes[voxel * 8 + static_cast<size_t>(in_slab)], to, 1.0f);
                    continue;
                }
                const uint16_t* from =
                    &band->fractions[static_cast<size_t>(band->columns[voxel]) *
                                         static_cast<size_t>(8 * band->channels) +
                                     static_cast<size_t>(in_slab)];
                for (const uint8_t channel : kernels_.channels) {
                    if (channel < band->channels)
                        put(channel, to, static_cast<float>(from[8 * channel]) / kWhole);
                }
            }
        }
    }
}

/// Takes the fractions of some blocks out of the window, those of materials that do not bleed as they
/// are. `slab_size`: of the grid along x, of the row along y and of the slab along z.
void Bleed::store(const BleedWindow& window, const Vec3i& lowest, const Vec2<int32_t>& blocks,
                  const Vec3i& slab_size, dither::RowBand* out) const {
    const size_t places = kernels_.channels.size();
    const auto channels = static_cast<size_t>(out->channels);
    std::array<uint16_t, kMostBits * 2 + 1> amounts;
    OPENFAB_CHECK_LT(places, amounts.size());
    for (int32_t y = 0; y < slab_size.y; ++y) {
        uint8_t* marks = out->mixed_row(y);
        for (int32_t x = 8 * blocks.x; x < std::min(8 * blocks.y, slab_size.x); ++x) {
            uint8_t* codes = out->codes_at(x, y);
            int32_t& column = at(out->columns, y * out->width() + x);
            const uint8_t before = marks[x];
            const int32_t before_column = column;
            int32_t made = -1;
            for (int32_t z = 0; z < slab_size.z; ++z) {
                const bool was_mixed = (before >> z & 1) != 0;
                const auto old = [&](size_t channel) -> uint16_t {
                    if (!was_mixed) return codes[z] == channel ? 65535 : 0;
                    if (channel >= channels) return 0;
                    return out->fractions_at(before_column)[8 * channel + static_cast<size_t>(z)];
                };
                int32_t sum = 0;
                for (const uint8_t channel : kernels_.channels)
                    sum += old(channel);
                if (sum == 0) continue;
                const size_t from = window.at(x - lowest.x, reach_.y + y, reach_.z + z);
                int32_t rest = sum;
                size_t largest = 0;
                for (size_t place = 0; place < places; ++place) {
                    const float value = window.fractions(place)[from];
                    const auto amount = static_cast<int32_t>(
                        std::floor(std::min(std::max(value, 0.0f), 1.0f) * kWhole + 0.5f));
                    amounts[place] = static_cast<uint16_t>(amount);
                    rest -= amount;
                    if (amounts[place] > amounts[largest]) largest = place;
                }
                amounts[largest] = static_cast<uint16_t>(std::max(amounts[largest] + rest, 0));
                if (amounts[largest] == 65535) {
                    codes[z] = kernels_.channels[largest];
                    marks[x] = static_cast<uint8_t>(marks[x] & ~(1 << z));
                    continue;
                }
                if (made < 0) {
                    made = out->add_columns(1);
                    if (before != 0) {
                        std::memcpy(out->fractions_at(made), out->fractions_at(before_column),
                                    8 * channels * sizeof(uint16_t));
                    }
                }
                uint16_t* to = out->fractions_at(made) + z;
                // A voxel of one material has no fractions of its own in its column.
                for (size_t channel = 0; channel < channels && !was_mixed; ++channel)
                    to[8 * channel] = 0;
                for (size_t place = 0; place < places; ++place)
                    to[8 * kernels_.channels[place]] = amounts[place];
                codes[z] = OPENFAB_CODE_MIXED;
                marks[x] = static_cast<uint8_t>(marks[x] | 1 << z);
            }
            if (made < 0) continue;
            column = made;
            out->any_mixed = true;
            at(out->mixed_blocks, x / 8) = 1;
        }
    }
}

}  // namespace openfab::process

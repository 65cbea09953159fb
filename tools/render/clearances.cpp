// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/render/clearances.h"

#include <algorithm>
#include <array>

namespace openfab::render {

namespace {

constexpr int32_t kSide = Volume::kSide;
constexpr int32_t kReach = Clearances::kMost;
/// Of voxels around a block, from kReach - 1 before it to kReach after it.
constexpr int32_t kRows = kSide + 2 * kReach - 1;

/// A row a bit for each voxel, or dual cell, along x; rows y fastest.
using Rows = std::array<uint32_t, static_cast<size_t>(kRows) * kRows>;

size_t row_index(int32_t y, int32_t z) {
    return static_cast<size_t>(z) * kRows + static_cast<size_t>(y);
}

/// The voxels of a block that are inside: a row a byte, y fastest.
using Inside = std::array<uint8_t, static_cast<size_t>(kSide) * kSide>;

/// Leaves those whose next ones, up to `more` along each axis, are set, too; `count` rows a side become count - more.
void narrow(int32_t more, int32_t* count, Rows* rows) {
    const int32_t left = *count - more;
    for (int32_t z = 0; z < *count; ++z) {
        for (int32_t y = 0; y < *count; ++y) {
            uint32_t& row = (*rows)[row_index(y, z)];
            const uint32_t all = row;
            for (int32_t i = 1; i <= more; ++i)
                row &= all >> i;
        }
    }
    for (int32_t z = 0; z < *count; ++z) {
        for (int32_t y = 0; y < left; ++y) {
            for (int32_t i = 1; i <= more; ++i)
                (*rows)[row_index(y, z)] &= (*rows)[row_index(y + i, z)];
        }
    }
    for (int32_t z = 0; z < left; ++z) {
        for (int32_t y = 0; y < left; ++y) {
            for (int32_t i = 1; i <= more; ++i)
                (*rows)[row_index(y, z)] &= (*rows)[row_index(y, z + i)];
        }
    }
    *count = left;
}

/// Gives those whose rows are set their clearances, and `more`.
void add_clearances(Rows rows, int32_t more, std::array<uint8_t, Volume::kBlockVoxels>* clearance) {
    int32_t count = kRows;
    narrow(1, &count, &rows);  // dual cells
    for (int32_t level = 0; level < kReach; ++level) {
        if (level > 0) narrow(2, &count, &rows);
        const int32_t first = kReach - 1 - level;
        for (int32_t z = 0; z < kSide; ++z) {
            for (int32_t y = 0; y < kSide; ++y) {
                const uint32_t row = rows[row_index(first + y, first + z)] >> first;
                for (int32_t x = 0; x < kSide; ++x) {
                    uint8_t& to = (*clearance)[static_cast<size_t>((z * kSide + y) * kSide + x)];
                    if ((row >> x & 1) != 0) to = static_cast<uint8_t>(more + level + 1);
                }
            }
        }
    }
}

}  // namespace

Clearances::Clearances(const Volume& volume) : blocks_(volume.blocks()) {
    const Vec3i& blocks = blocks_;
    const auto index_of = [&](int32_t x, int32_t y, int32_t z) {
        return index_in(blocks, {x, y, z});
    };
    // First what is inside: all, nothing, or which of the mixed.
    constexpr uint32_t kNothing = kUniform | static_cast<uint32_t>(kVoid + kMost);
    constexpr uint32_t kAll = kUniform | static_cast<uint32_t>(kMost);
    std::vector<uint32_t> inside(index_of(0, 0, blocks.z), kNothing);
    std::vector<Inside> mixed;
    for (int32_t z = 0; z < blocks.z; ++z) {
        for (int32_t y = 0; y < blocks.y; ++y) {
            for (int32_t x = 0; x < blocks.x; ++x) {
                Inside one{};
                inside[index_of(x, y, z)] = volume.inside({x, y, z}, one.data())
                                                ? static_cast<uint32_t>(mixed.size())
                                            : one[0] != 0 ? kAll
                                                          : kNothing;
                if (inside[index_of(x, y, z)] < kUniform) mixed.push_back(one);
            }
        }
    }
    entries_ = inside;
    const auto row_of = [&](int32_t bx, int32_t y, int32_t z) -> uint32_t {
        const uint32_t entry = inside[index_of(bx, y >> 3, z >> 3)];
        if (entry == kNothing) return 0;
        if (entry == kAll) return 0xff;
        return mixed[entry][static_cast<size_t>((z & 7) * kSide + (y & 7))];
    };
    for (int32_t z = 1; z + 1 < blocks.z; ++z) {
        for (int32_t y = 1; y + 1 < blocks.y; ++y) {
            for (int32_t x = 1; x + 1 < blocks.x; ++x) {
                const uint32_t own = inside[index_of(x, y, z)];
                bool is_alone = own >= kUniform;
                for (int32_t i = 0; i < 27 && is_alone; ++i)
                    is_alone =
                        inside[index_of(x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1)] == own;
                if (is_alone) continue;
                Rows rows;
                for (int32_t k = 0; k < kRows; ++k) {
                    for (int32_t j = 0; j < kRows; ++j) {
                        const int32_t vy = y * kSide + j - (kReach - 1);
                        const int32_t vz = z * kSide + k - (kReach - 1);
                        rows[row_index(j, k)] = row_of(x - 1, vy, vz) >> (kSide - (kReach - 1)) |
                                                row_of(x, vy, vz) << (kReach - 1) |
                                                row_of(x + 1, vy, vz) << (kSide + kReach - 1);
                    }
                }
                std::array<uint8_t, Volume::kBlockVoxels> clearance{};
                add_clearances(rows, 0, &clearance);
                for (uint32_t& row : rows)
                    row = ~row;
                add_clearances(rows, kVoid, &clearance);
                entries_[index_of(x, y, z)] = static_cast<uint32_t>(pool_.size() / kBlockBytes);
                for (size_t i = 0; i < clearance.size(); i += 2)
                    pool_.push_back(static_cast<uint8_t>(clearance[i] | clearance[i + 1] << 4));
            }
        }
    }
}

Clearances::Kind Clearances::kind(const Vec3i& block) const {
    bool is_inside = false;
    bool is_outside = false;
    const auto see = [&](int32_t value) {
        is_inside = is_inside || value < kVoid;
        is_outside = is_outside || value > kVoid || value == 0;
    };
    const uint32_t entry = entry_of(block);
    if ((entry & kUniform) != 0) {
        see(static_cast<int32_t>(entry & ~kUniform));
    } else {
        const Vec3i low{block.x * kSide, block.y * kSide, block.z * kSide};
        for (int32_t z = -1; z < kSide && !(is_inside && is_outside); ++z) {
            for (int32_t y = -1; y < kSide; ++y) {
                for (int32_t x = -1; x < kSide; ++x)
                    see(at(low.x + x, low.y + y, low.z + z).value);
            }
        }
    }
    return is_inside && is_outside ? Kind::kSurface : is_inside ? Kind::kInside : Kind::kOutside;
}

}  // namespace openfab::render

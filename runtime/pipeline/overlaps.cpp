// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/overlaps.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <tuple>

#include "base/check.h"
#include "runtime/pipeline/messages.h"

namespace openfab::pipeline {

namespace {

constexpr size_t kMostPairs = 1000;
constexpr size_t kMostLines = 8;

bool before(const Vec3i& a, const Vec3i& b) {
    return std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x);
}

}  // namespace

void Overlaps::add(int32_t earlier, int32_t later, const Count& count) {
    const auto found = counts_.find({earlier, later});
    if (found == counts_.end()) {
        if (counts_.size() < kMostPairs) counts_[{earlier, later}] = count;
        return;
    }
    found->second.voxels += count.voxels;
    if (before(count.block, found->second.block)) found->second.block = count.block;
}

void Overlaps::add(const Overlaps& other) {
    for (const auto& [pair, count] : other.counts_)
        add(pair.first, pair.second, count);
}

std::vector<std::string> Overlaps::report(const std::vector<part::Part>& parts,
                                          const part::Grid& grid) const {
    std::vector<std::pair<std::pair<int32_t, int32_t>, Count>> pairs(counts_.begin(),
                                                                     counts_.end());
    std::stable_sort(pairs.begin(), pairs.end(), [](const auto& a, const auto& b) {
        return a.second.voxels > b.second.voxels;
    });
    const double voxel_ml = grid.pitch_mm.x * grid.pitch_mm.y * grid.pitch_mm.z * 1e-3;
    std::vector<std::string> lines;
    for (const auto& [pair, count] : pairs) {
        if (lines.size() == kMostLines) {
            lines.push_back(fmt::format(messages::kMorePairsOverlap, pairs.size() - kMostLines));
            break;
        }
        Vec3d at;
        for (int a = 0; a < 3; ++a)
            at[a] = grid.origin_mm[a] + (count.block[a] + 4) * grid.pitch_mm[a];
        lines.push_back(fmt::format(messages::kPartsOverlap, parts[pair.first].name, pair.first,
                                    parts[pair.second].name, pair.second, count.voxels,
                                    static_cast<double>(count.voxels) * voxel_ml, at.x, at.y,
                                    at.z));
    }
    return lines;
}

void RowClaims::reset(int32_t columns, int32_t first, int32_t end) {
    first_ = std::min(first, columns);
    const auto blocks = static_cast<size_t>(std::max(end - first_, 0));
    claimed_.assign(blocks * 8, 0);
    explained_.assign(blocks * 8, 0);
    claimant_.assign(blocks, -1);
    index_ = -1;
}

void RowClaims::begin_part(const part::Part& part, int32_t index) {
    if (index_ >= 0 && part.priority != priority_) {
        explained_ = claimed_;
        std::fill(claimant_.begin(), claimant_.end(), -1);
    }
    priority_ = part.priority;
    index_ = index;
    shared_ = 0;
}

uint64_t RowClaims::take(int32_t block, int32_t y, uint64_t voxels) {
    OPENFAB_DCHECK(index_ >= 0);  // a part has begun
    uint64_t& claimed = claimed_[row_index(block, y)];
    const uint64_t left = voxels & ~claimed;
    shared_ += std::popcount(voxels & claimed & ~explained_[row_index(block, y)]);
    claimed |= voxels;
    return left;
}

void RowClaims::end_block(int32_t block, const Vec3i& corner, Overlaps* overlaps) {
    int32_t& claimant = claimant_[static_cast<size_t>(block - first_)];
    // Parts of one priority come from the last of the build list to the first.
    if (shared_ > 0 && claimant >= 0) overlaps->add(index_, claimant, {shared_, corner});
    shared_ = 0;
    claimant = index_;
}

}  // namespace openfab::pipeline

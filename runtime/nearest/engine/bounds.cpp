// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/infinity.h"
#include "runtime/nearest/engine.h"

namespace openfab::nearest {

void BoxBounds::add(float distance_lo, std::span<const float> float_lo,
                    std::span<const float> float_hi, std::span<const int32_t> int_lo,
                    std::span<const int32_t> int_hi) {
    int32_t k = 0;
    while (k < count && !(std::ranges::equal(cases[k].int_lo, int_lo) &&
                          std::ranges::equal(cases[k].int_hi, int_hi))) {
        ++k;
    }
    if (k == count && count < kMaxCases) {
        NearestCase& fresh = cases[static_cast<size_t>(count++)];
        fresh.distance_lo = distance_lo;
        fresh.float_lo.assign(float_lo.begin(), float_lo.end());
        fresh.float_hi.assign(float_hi.begin(), float_hi.end());
        fresh.int_lo.assign(int_lo.begin(), int_lo.end());
        fresh.int_hi.assign(int_hi.begin(), int_hi.end());
        return;
    }
    NearestCase& into = cases[static_cast<size_t>(std::min(k, kMaxCases - 1))];
    into.distance_lo = std::min(into.distance_lo, distance_lo);
    for (size_t c = 0; c < float_lo.size(); ++c) {
        into.float_lo[c] = std::min(into.float_lo[c], float_lo[c]);
        into.float_hi[c] = std::max(into.float_hi[c], float_hi[c]);
    }
    for (size_t c = 0; c < int_lo.size(); ++c) {
        into.int_lo[c] = std::min(into.int_lo[c], int_lo[c]);
        into.int_hi[c] = std::max(into.int_hi[c], int_hi[c]);
    }
}

void Engine::bound_points(std::span<const PointPacket> packets, std::span<const PointPacket>, float,
                          Scratch* scratch, PointBounds* bounds) const {
    std::vector<PointAnswer> answers(packets.size());
    query_points(packets, kInfinity, scratch, answers.data());
    for (size_t g = 0; g < packets.size(); ++g) {
        for (size_t l = 0; l < 8; ++l)
            bounds[g].low[l] = bounds[g].high[l] = std::sqrt(answers[g].distance2[l]);
        for (auto& coordinate : bounds[g].point)
            std::fill_n(coordinate, 8, std::numeric_limits<float>::quiet_NaN());
    }
}

void Engine::prepare(std::span<const Vec3i>, Scratch*) const {}

const BlockPieces& Engine::pieces() const {
    static const BlockPieces pieces = [] {
        BlockPieces made;
        made.size = {4, 2, 2};
        for (int32_t i = 0; i < 32; ++i)
            made.lowest[i] = {4 * (i & 1), i & 6, i >> 2 & 6};
        return made;
    }();
    return pieces;
}

void Engine::bound_blocks(std::span<const Vec3i> blocks, Scratch* scratch,
                          BlockBounds* bounds) const {
    const BlockPieces& cut = pieces();
    BlockAnswer answer;
    for (size_t i = 0; i < blocks.size(); ++i) {
        query({.block = blocks[i]}, scratch, &answer);
        for (size_t q = 0; q < cut.lowest.size(); ++q) {
            float low = kInfinity, high = 0;
            const Vec3i from = cut.lowest[q], to = from + cut.size;
            for (int32_t y = from.y; y < to.y; ++y) {
                for (int32_t x = from.x; x < to.x; ++x) {
                    for (int32_t z = from.z; z < to.z; ++z) {
                        const float d = std::sqrt(answer.distance2[(y * 8 + x) * 8 + z]);
                        low = std::min(low, d);
                        high = std::max(high, d);
                    }
                }
            }
            bounds[i].low[q] = low;
            bounds[i].high[q] = high;
        }
    }
}

void Engine::bound_whole_blocks(std::span<const Vec3i> blocks, Scratch* scratch, float* low,
                                float* high) const {
    constexpr size_t kAtOnce = 64;
    std::array<BlockBounds, kAtOnce> bounds;
    for (size_t first = 0; first < blocks.size(); first += kAtOnce) {
        const auto some = blocks.subspan(first, std::min(kAtOnce, blocks.size() - first));
        bound_blocks(some, scratch, bounds.data());
        for (size_t i = 0; i < some.size(); ++i) {
            low[first + i] = *std::ranges::min_element(bounds[i].low);
            high[first + i] = *std::ranges::max_element(bounds[i].high);
        }
    }
}

}  // namespace openfab::nearest

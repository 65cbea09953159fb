// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Loops whose results do not depend on the number of threads: what is summed is summed in blocks that
// the grid alone decides, in order.

#include <tbb/parallel_for.h>

#include <cstdint>
#include <vector>

#include "mechanics/solver/field.h"

namespace openfab::mechanics {

/// Calls f(i) for i in 0 ... count - 1, at once where it may.
template <typename F>
void for_each_index(int32_t count, const F& f) {
    tbb::parallel_for(int32_t{0}, count, [&](int32_t i) { f(i); });
}

/// Layers of elements in a block.
constexpr int32_t kLayerBlock = 4;

/// Calls f(begin, end) for blocks of layers of elements, so that no two that run at once touch the same
/// plane of nodes and each plane gets its contributions in the same order.
template <typename F>
void for_layer_blocks(int32_t layers, bool periodic, const F& f) {
    const int32_t blocks = (layers + kLayerBlock - 1) / kLayerBlock;
    const auto run = [&](int32_t b) {
        const int32_t begin = b * kLayerBlock;
        f(begin, begin + kLayerBlock < layers ? begin + kLayerBlock : layers);
    };
    // The last block of an odd number ends where the first, of the same parity, begins.
    const bool last_alone = periodic && blocks % 2 == 1 && blocks > 1;
    const int32_t rest = last_alone ? blocks - 1 : blocks;
    for_each_index((rest + 1) / 2, [&](int32_t i) { run(2 * i); });
    for_each_index(rest / 2, [&](int32_t i) { run(2 * i + 1); });
    if (last_alone) run(blocks - 1);
}

/// Sums f(i), a double, over i, in order.
template <typename F>
double sum_over(int32_t count, const F& f) {
    std::vector<double> part(static_cast<size_t>(count));
    for_each_index(count, [&](int32_t i) { part[static_cast<size_t>(i)] = f(i); });
    double sum = 0;
    for (const double p : part)
        sum += p;
    return sum;
}

/// Calls f(component, y, z, nodes) for each row of fields of C components, in parallel over planes.
template <int C, typename F>
void for_rows(const Grid& g, const F& f) {
    for_each_index(g.nodes[2], [&](int32_t z) {
        for (int32_t y = 0; y < g.nodes[1]; ++y)
            for (int c = 0; c < C; ++c)
                f(c, y, z, g.nodes[0]);
    });
}

}  // namespace openfab::mechanics

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/inspection/components.h"

#include <algorithm>

#include "base/at.h"

#include "tools/inspection/sets.h"

namespace openfab::inspection {

namespace {

/// Voxels of a row next to each other.
struct Run {
    int32_t begin = 0, end = 0;
};

/// The runs of all rows, in the order of z, y, x.
struct Runs {
    std::vector<Run> all;
    std::vector<size_t> rows;  ///< [z][y]: the first of a row, and one more

    Runs(const Bits& bits, uint8_t mask) {
        const auto count = static_cast<size_t>(bits.size.y) * static_cast<size_t>(bits.size.z);
        rows.reserve(count + 1);
        rows.push_back(0);
        for (size_t row = 0; row < count; ++row) {
            const uint8_t* const voxels =
                bits.values.data() + row * static_cast<size_t>(bits.size.x);
            for (int32_t x = 0; x < bits.size.x;) {
                const auto is_set = [&](int32_t at) { return (voxels[at] & mask) != 0; };
                while (x < bits.size.x && !is_set(x))
                    ++x;
                if (x == bits.size.x) break;
                const int32_t begin = x;
                while (x < bits.size.x && is_set(x))
                    ++x;
                all.push_back({begin, x});
            }
            rows.push_back(all.size());
        }
    }
};

/// Unites the runs of two rows that touch, within `slack` voxels along x.
void unite_rows(const Runs& runs, size_t row, size_t other, int32_t slack, Sets* sets) {
    size_t i = runs.rows[row], k = runs.rows[other];
    while (i < runs.rows[row + 1] && k < runs.rows[other + 1]) {
        const Run &a = runs.all[i], &b = runs.all[k];
        if (a.begin < b.end + slack && b.begin < a.end + slack)
            sets->unite(static_cast<int32_t>(i), static_cast<int32_t>(k));
        // That which ends first meets no other.
        if (a.end < b.end)
            ++i;
        else
            ++k;
    }
}

}  // namespace

std::vector<Cluster> components(const Bits& bits, Touch touch, Box<int32_t>* labels, uint8_t mask) {
    const Vec3i& size = bits.size;
    const Runs runs(bits, mask);
    Sets sets;
    for (size_t i = 0; i < runs.all.size(); ++i)
        sets.add();
    const bool corners = touch == Touch::kCorners;
    const auto row_of = [&](int32_t y, int32_t z) {
        return static_cast<size_t>(z) * static_cast<size_t>(size.y) + static_cast<size_t>(y);
    };
    for (int32_t z = 0; z < size.z; ++z) {
        for (int32_t y = 0; y < size.y; ++y) {
            const int32_t slack = corners ? 1 : 0;
            if (y > 0) unite_rows(runs, row_of(y, z), row_of(y - 1, z), slack, &sets);
            if (z == 0) continue;
            for (int32_t dy = corners ? -1 : 0; dy <= (corners ? 1 : 0); ++dy) {
                if (y + dy >= 0 && y + dy < size.y)
                    unite_rows(runs, row_of(y, z), row_of(y + dy, z - 1), slack, &sets);
            }
        }
    }
    *labels = Box<int32_t>(size, 0);
    std::vector<int32_t> number(sets.size(), -1);
    std::vector<Cluster> clusters;
    for (int32_t z = 0; z < size.z; ++z) {
        for (int32_t y = 0; y < size.y; ++y) {
            const size_t row = row_of(y, z);
            int32_t* const to = labels->values.data() + row * static_cast<size_t>(size.x);
            for (size_t i = runs.rows[row]; i < runs.rows[row + 1]; ++i) {
                int32_t& of = at(number, sets.find(static_cast<int32_t>(i)));
                if (of < 0) {
                    of = static_cast<int32_t>(clusters.size());
                    clusters.emplace_back();
                }
                const Run& run = runs.all[i];
                std::fill(to + run.begin, to + run.end, of + 1);
                at(clusters, of).add({run.begin, y, z}, run.end - run.begin, size);
            }
        }
    }
    return clusters;
}

}  // namespace openfab::inspection

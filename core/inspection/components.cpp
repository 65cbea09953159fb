// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "inspection/components.h"

#include "inspection/sets.h"

namespace openfab::inspection {

std::vector<Cluster> components(const Bits& bits, Touch touch, Box<int32_t>* labels, uint8_t mask) {
    // Those before a voxel in the order of z, y, x.
    std::vector<Vec3i> before;
    for (int32_t z = -1; z <= 0; ++z) {
        for (int32_t y = -1; y <= 1; ++y) {
            for (int32_t x = -1; x <= 1; ++x) {
                const bool earlier = z < 0 || (z == 0 && (y < 0 || (y == 0 && x < 0)));
                const bool face = z * z + y * y + x * x == 1;
                if (earlier && (face || touch == Touch::kCorners)) before.push_back({x, y, z});
            }
        }
    }
    *labels = Box<int32_t>(bits.size, -1);
    Sets sets;
    const Vec3i& size = bits.size;
    for (int32_t z = 0; z < size.z; ++z) {
        for (int32_t y = 0; y < size.y; ++y) {
            for (int32_t x = 0; x < size.x; ++x) {
                const size_t at = bits.at(x, y, z);
                if ((bits.values[at] & mask) == 0) continue;
                int32_t label = -1;
                for (const Vec3i& d : before) {
                    if (!bits.holds(x + d.x, y + d.y, z + d.z)) continue;
                    const int32_t other = labels->values[bits.at(x + d.x, y + d.y, z + d.z)];
                    if (other < 0) continue;
                    if (label < 0)
                        label = other;
                    else if (label != other)
                        sets.unite(label, other);
                }
                labels->values[at] = label < 0 ? sets.add() : label;
            }
        }
    }
    std::vector<int32_t> number(sets.size(), -1);
    std::vector<Cluster> found;
    for (int32_t z = 0; z < size.z; ++z) {
        for (int32_t y = 0; y < size.y; ++y) {
            for (int32_t x = 0; x < size.x; ++x) {
                int32_t& label = labels->values[bits.at(x, y, z)];
                if (label < 0) {
                    label = 0;
                    continue;
                }
                int32_t& of = number[static_cast<size_t>(sets.find(label))];
                if (of < 0) {
                    of = static_cast<int32_t>(found.size());
                    found.emplace_back();
                }
                label = of + 1;
                found[static_cast<size_t>(of)].add({x, y, z}, size);
            }
        }
    }
    return found;
}

}  // namespace openfab::inspection

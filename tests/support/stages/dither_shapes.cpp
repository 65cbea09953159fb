// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/stages/dither_shapes.h"

#include <algorithm>
#include <cmath>

namespace openfab::testing {

using reference::FractionField;

namespace {

bool solid(const FractionField& field, const Vec3i& v) {
    if (v.x < 0 || v.y < 0 || v.z < 0) return false;
    if (v.x >= field.size.x || v.y >= field.size.y || v.z >= field.size.z) return false;
    return field.at(v.x, v.y, v.z)[0] == 0;
}

template <typename F>
void each_voxel(const Vec3i& size, const F& f) {
    for (int32_t z = 0; z < size.z; ++z) {
        for (int32_t y = 0; y < size.y; ++y) {
            for (int32_t x = 0; x < size.x; ++x)
                f(Vec3i{x, y, z});
        }
    }
}

}  // namespace

std::vector<uint16_t> quantised(const std::vector<double>& others) {
    std::vector<uint16_t> fractions(2, 0);
    int32_t left = 65535;
    for (double share : others) {
        fractions.push_back(static_cast<uint16_t>(std::lround(share * 65535)));
        left -= fractions.back();
    }
    fractions[1] = static_cast<uint16_t>(left);
    return fractions;
}

FractionField shaped(const Vec3i& size, const std::vector<uint16_t>& mixture,
                     const Inside& inside) {
    FractionField field = reference::make_field(size, static_cast<int32_t>(mixture.size()) - 1);
    each_voxel(size, [&](const Vec3i& v) {
        uint16_t* f = field.at(v.x, v.y, v.z);
        if (inside(v)) {
            std::copy(mixture.begin(), mixture.end(), f);
        } else {
            f[0] = 65535;
        }
    });
    return field;
}

FractionField box(const Vec3i& size, const std::vector<uint16_t>& mixture) {
    return shaped(size, mixture, [](const Vec3i&) { return true; });
}

FractionField ball(double radius, const std::vector<uint16_t>& mixture) {
    const int32_t side = 2 * static_cast<int32_t>(radius) + 4;
    const auto square = [&](int32_t i) {
        const double from_middle = i + 0.5 - side / 2.0;
        return from_middle * from_middle;
    };
    return shaped({side, side, side}, mixture, [&](const Vec3i& v) {
        return square(v.x) + square(v.y) + square(v.z) < radius * radius;
    });
}

double share_of(const FractionField& field, const std::vector<uint8_t>& codes, uint8_t code,
                const Inside& where) {
    int64_t voxels = 0, found = 0;
    size_t i = 0;
    each_voxel(field.size, [&](const Vec3i& v) {
        const uint8_t printed = codes[i++];
        if (!solid(field, v) || !where(v)) return;
        ++voxels;
        found += printed == code ? 1 : 0;
    });
    return static_cast<double>(found) / static_cast<double>(voxels);
}

std::array<double, 6> face_shares(const FractionField& field, const std::vector<uint8_t>& codes,
                                  uint8_t code, int32_t depth) {
    const int32_t x = field.size.x - 1 - depth, y = field.size.y - 1 - depth,
                  z = field.size.z - 1 - depth;
    const Inside faces[6] = {
        [=](const Vec3i& v) { return v.x == depth; }, [=](const Vec3i& v) { return v.x == x; },
        [=](const Vec3i& v) { return v.y == depth; }, [=](const Vec3i& v) { return v.y == y; },
        [=](const Vec3i& v) { return v.z == depth; }, [=](const Vec3i& v) { return v.z == z; }};
    std::array<double, 6> shares{};
    for (size_t i = 0; i < 6; ++i)
        shares[i] = share_of(field, codes, code, faces[i]);
    return shares;
}

std::array<double, 8> skin_shares(const FractionField& field, const std::vector<uint8_t>& codes,
                                  uint8_t code) {
    std::array<int64_t, 8> voxels{}, found{};
    size_t i = 0;
    each_voxel(field.size, [&](const Vec3i& v) {
        const uint8_t printed = codes[i++];
        const auto at = [&](int32_t dx, int32_t dy, int32_t dz) {
            return solid(field, {v.x + dx, v.y + dy, v.z + dz});
        };
        if (!at(0, 0, 0)) return;
        if (at(-1, 0, 0) && at(1, 0, 0) && at(0, -1, 0) && at(0, 1, 0) && at(0, 0, -1) &&
            at(0, 0, 1))
            return;
        const auto octant = static_cast<size_t>((2 * v.x >= field.size.x ? 1 : 0) +
                                                (2 * v.y >= field.size.y ? 2 : 0) +
                                                (2 * v.z >= field.size.z ? 4 : 0));
        ++voxels[octant];
        found[octant] += printed == code ? 1 : 0;
    });
    std::array<double, 8> shares{};
    for (size_t k = 0; k < 8; ++k)
        shares[k] = static_cast<double>(found[k]) / static_cast<double>(voxels[k]);
    return shares;
}

}  // namespace openfab::testing

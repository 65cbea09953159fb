// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/opening.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/color.h"
#include "tools/viewer/tile.h"

namespace openfab::viewer {

namespace {

constexpr int32_t kMostSlices = 16, kFewestSlices = 4;
constexpr int64_t kMostBytes = 160 << 20;  ///< of unpacked slices, as long as there are enough
/// A picture is looked at in so many fields along each side, by so many voxels along each of theirs.
constexpr int32_t kFields = 48, kSamples = 6;
/// What a field that shows anything is worth beside one that differs from its neighbours.
constexpr double kVisibleWeight = 0.02;
constexpr double kClearlyMore = 1.1;

struct Field {
    std::array<double, 3> color{};  ///< sRGB of the mean
    bool visible = false;
};

/// Colours in linear light, times alpha, and alpha.
using Light = std::array<double, 4>;

std::array<Light, 256> lights_of(const pipeline::PrintInfo& info) {
    std::array<Light, 256> made{};
    for (size_t m = 0; m < info.materials.size(); ++m) {
        if (static_cast<int32_t>(m + 1) == info.support_code) continue;
        const std::array<uint8_t, 4>& rgba = info.materials[m].preview;
        Light& light = made[m + 1];
        // Clear materials are drawn as any other in a slice.
        for (size_t c = 0; c < 3; ++c)
            light[c] = srgb_to_linear(rgba[c] / 255.0);
        light[3] = 1;
    }
    return made;
}

Field field_of(const pipeline::SliceView& view, const std::array<Light, 256>& lights, int32_t bits,
               int32_t u, int32_t v) {
    const auto place = [](int32_t field, int32_t sample, int32_t voxels) {
        return static_cast<int32_t>((int64_t{field} * kSamples + sample) * voxels /
                                    (int64_t{kFields} * kSamples));
    };
    Light sum{};
    for (int32_t j = 0; j < kSamples; ++j) {
        for (int32_t i = 0; i < kSamples; ++i) {
            const Light& one =
                lights[view.code(place(u, i, view.width), place(v, j, view.height), bits)];
            for (size_t c = 0; c < sum.size(); ++c)
                sum[c] += one[c];
        }
    }
    Field field;
    field.visible = sum[3] * 2 > kSamples * kSamples;
    for (size_t c = 0; c < 3 && field.visible; ++c)
        field.color[c] = srgb_of(sum[c] / sum[3]) / 255.0;
    return field;
}

double distance(const Field& a, const Field& b) {
    if (!a.visible || !b.visible) return 0;
    double sum = 0;
    for (size_t c = 0; c < 3; ++c)
        sum += std::abs(a.color[c] - b.color[c]);
    return sum;
}

/// How much a slice shows: the differences between neighbours, and how much of it is visible.
double worth_of(const pipeline::SliceView& view, const std::array<Light, 256>& lights,
                int32_t bits) {
    std::vector<Field> fields;
    for (int32_t v = 0; v < kFields; ++v) {
        for (int32_t u = 0; u < kFields; ++u)
            fields.push_back(field_of(view, lights, bits, u, v));
    }
    double worth = 0;
    for (size_t i = 0; i < fields.size(); ++i) {
        if (fields[i].visible) worth += kVisibleWeight;
        if (i % kFields + 1 < kFields) worth += distance(fields[i], fields[i + 1]);
        if (i + kFields < fields.size()) worth += distance(fields[i], fields[i + kFields]);
    }
    return worth;
}

}  // namespace

int32_t opening_slice(SliceStore* store) {
    const prints::PrintFile& file = store->file();
    const pipeline::PrintInfo& info = file.info();
    const int32_t whole = file.whole_slices();
    if (whole <= 0) return info.slice_begin;
    const auto looked_at = static_cast<int32_t>(std::clamp<int64_t>(
        kMostBytes / std::max<int64_t>(file.slice_bytes(), 1), kFewestSlices, kMostSlices));
    std::vector<int32_t> slices{info.slice_begin + whole / 2};
    for (int32_t i = 0; i < looked_at; ++i)
        slices.push_back(info.slice_begin +
                         static_cast<int32_t>((int64_t{2} * i + 1) * whole / (2 * looked_at)));
    const std::array<Light, 256> lights = lights_of(info);
    int32_t best = slices.front();
    double most = 0;
    for (const int32_t z : slices) {
        double worth = 0;
        // One that is damaged is told when somebody looks at it.
        (void)store->visit(z, [&](const uint8_t* rows) {
            worth =
                worth_of({z, rows, file.row_bytes(), info.size.x, info.size.y}, lights, info.bits);
        });
        if (worth > most * kClearlyMore) {
            most = worth;
            best = z;
        }
    }
    return best;
}

}  // namespace openfab::viewer

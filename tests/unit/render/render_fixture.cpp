// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/render/render_fixture.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

namespace openfab::testing {

render::Volume make_volume(const Vec3i& size, const Vec3d& pitch_mm, const CodeAt& code,
                           const Vec3i& cell) {
    constexpr int64_t kMemory = 1'000'000'000;
    render::VolumeBuilder builder({size, pitch_mm, {0, 0, 0}, cell, {1, 2, 3, 4, 5}}, kMemory, 7);
    std::vector<uint8_t> slice(static_cast<size_t>(size.x) * static_cast<size_t>(size.y));
    for (int32_t z = 0; z < size.z; ++z) {
        for (int32_t y = 0; y < size.y; ++y) {
            for (int32_t x = 0; x < size.x; ++x)
                slice[static_cast<size_t>(y * size.x + x)] = code(x, y, z);
        }
        EXPECT_TRUE(builder.add(z, slice.data()));
    }
    render::Volume volume;
    EXPECT_TRUE(builder.finish(&volume));
    return volume;
}

render::Optics make_optics(const std::vector<render::MaterialOptics>& materials,
                           double refractive_index, double roughness) {
    render::Optics optics;
    optics.surface = {refractive_index, roughness};
    optics.by_code.emplace_back();
    optics.by_code.insert(optics.by_code.end(), materials.begin(), materials.end());
    return optics;
}

render::Scene white_room() {
    render::Scene scene;
    scene.light.dome = {1, 1, 1};
    scene.backdrop.seen = {1, 1, 1};
    return scene;
}

Estimate estimate(const render::Tracer& tracer, int32_t paths, const Vec3d& from_mm,
                  const std::function<Vec3d(render::Random*)>& aim, uint64_t seed) {
    return estimate_from(
        tracer, paths, [&](const Vec3d&) { return from_mm; }, aim, seed);
}

Estimate estimate_from(const render::Tracer& tracer, int32_t paths,
                       const std::function<Vec3d(const Vec3d&)>& from,
                       const std::function<Vec3d(render::Random*)>& aim, uint64_t seed) {
    render::Rgb sum{};
    render::Rgb squares{};
    const auto start = [&](int32_t path) {
        render::Random random(seed, 0, static_cast<uint64_t>(path));
        const Vec3d direction = aim(&random);
        return render::PathStart{from(direction), direction, random};
    };
    EXPECT_TRUE(tracer.trace(paths, std::atomic<bool>(false), start,
                             [&](int32_t, const render::Rgb& light, bool) {
                                 for (size_t c = 0; c < 3; ++c) {
                                     sum[c] += light[c];
                                     squares[c] += light[c] * light[c];
                                 }
                             }));
    Estimate out;
    for (size_t c = 0; c < 3; ++c) {
        out.mean[c] = sum[c] / paths;
        const double variance = squares[c] / paths - out.mean[c] * out.mean[c];
        out.error[c] = std::sqrt(std::max(0.0, variance) / paths);
    }
    return out;
}

}  // namespace openfab::testing

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Volumes from functions, and means of many paths through them.

#include <cstdint>
#include <functional>

#include "tools/render/tracer.h"

namespace openfab::testing {

using CodeAt = std::function<uint8_t(int32_t x, int32_t y, int32_t z)>;

/// A volume at its own pitch; voxel (0, 0, 0) begins at the origin of space.
render::Volume make_volume(const Vec3i& size, const Vec3d& pitch_mm, const CodeAt& code,
                           const Vec3i& cell = {1, 1, 1});

/// Materials of one code after void.
render::Optics make_optics(const std::vector<render::MaterialOptics>& materials,
                           double refractive_index = 1, double roughness = 0);

/// Light of radiance 1 from everywhere.
render::Scene white_room();

struct Estimate {
    render::Rgb mean{};
    render::Rgb error{};  ///< standard deviation of the mean
};
/// Traces `paths` rays from a point; `aim` gives the direction of each.
Estimate estimate(const render::Tracer& tracer, int32_t paths, const Vec3d& from_mm,
                  const std::function<Vec3d(render::Random*)>& aim, uint64_t seed = 1);
/// The same, from a point that depends on the direction.
Estimate estimate_from(const render::Tracer& tracer, int32_t paths,
                       const std::function<Vec3d(const Vec3d&)>& from,
                       const std::function<Vec3d(render::Random*)>& aim, uint64_t seed = 1);

}  // namespace openfab::testing

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Random small worlds, of all kinds of geometry and many features, with what each of their voxels must be by brute
// force: the closed form of every solid at every voxel's centre.

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"

namespace openfab::testing {

/// How an object is placed: scaled, turned about x, y and z, moved; the innermost step first.
struct PoseStep {
    Vec3d scale{1, 1, 1}, rotate_deg, translate_mm;
};

/// An object in a build, as the brute force sees it.
struct RandomPart {
    std::function<double(const Vec3d&)> distance;  ///< signed, in mm of the mesh
    std::vector<PoseStep> pose;
    Vec3d stretch{1, 1, 1};  ///< of part space, against the mesh
    bool uneven = false;     ///< the stretch differs by axis
    int priority = 0;
    int pattern = 0;  ///< 1: a skin, 2: stripes
    double skin = 0, width = 1;
    Vec3d along;
    std::array<uint8_t, 3> codes{};  ///< of shell, left and right
    /// A piece of it: where side * (normal · p - at) > 0, in mm of the mesh; 0: all.
    int side = 0;
    Vec3d normal;
    double at = 0;
    /// Of a depth that is measured to micropolygons: in voxels next to edges, and the least radius, for chords.
    double depth_voxels = 0, radius_mm = 1e30;
};

struct RandomWorld {
    std::string text;                          ///< of w.fab.json
    std::map<std::string, std::string> files;  ///< beside it
    std::vector<RandomPart> parts;             ///< in build order
    double voxel_mm = 0.2;
    int draft = 1;
    bool programs = false;
    std::vector<std::string_view> refusals;  ///< messages that may refuse it
};

RandomWorld random_world(uint64_t seed);

/// What a voxel must be: a code, or -1 where it is too near to a surface or an edge of a pattern.
int expected_code(const std::vector<RandomPart>& parts, const Vec3d& centre_mm, double pitch_mm);

}  // namespace openfab::testing

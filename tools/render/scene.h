// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Everything around a print: lamps, what lies behind it, the camera. Lengths are the build's
// millimetres. Radiance is such that a white diffuser that faces the usual lamps has 1.

#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "tools/render/optics.h"

namespace openfab::render {

/// A round lamp so far away that it is a part of the sky.
struct Lamp {
    Vec3d to_lamp;      ///< unit
    double cosine = 1;  ///< of half its angle
    Rgb radiance{};
    /// The solid angle.
    double extent() const;
};

struct Light {
    Rgb dome{};  ///< radiance from everywhere
    std::vector<Lamp> lamps;
};

/// A diffuse plane under or behind the print.
struct Backdrop {
    bool is_plane = false;
    Vec3d point_mm, normal;  ///< unit, to the print's side
    Rgb albedo{};
    Rgb seen{};  ///< radiance where a ray of the camera meets nothing
};

struct Camera {
    Vec3d eye_mm;
    Vec3d right, up, forward;  ///< unit
    double half_width = 0.25;  ///< tangents of half the angles of view
    double half_height = 0.25;
    /// The direction through a place of the picture: 0 … 1 from the left and from the top.
    Vec3d direction(double x, double y) const;
};

struct Scene {
    Light light;
    Backdrop backdrop;
    Camera camera;
};

/// What the command line says.
struct SceneOptions {
    std::string view = "model:30:30";
    std::string light = "studio";
    std::string backdrop = "#c8c8c8";
    double zoom = 1;
    double aspect = 1;  ///< width over height
};

/// Puts camera and lamps around the box of a print.
Result<Scene> make_scene(const SceneOptions& options, const Box3d& solid_mm);

/// Describes a scene and the surface as JSON, to make the same picture with another program.
std::string describe_scene(const Scene& scene, const SurfaceOptics& surface);

}  // namespace openfab::render

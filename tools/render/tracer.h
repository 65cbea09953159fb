// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Traces light backwards through a print: from the camera to a lamp, by refraction and reflection at
// the outer surface, absorption and scattering inside.
//
// Flights inside are drawn against a majorant of the extinction, which is constant in a macrocell and
// the same for all channels (delta tracking). At each tentative collision the path goes on straight or
// scatters, with probabilities that follow what its channels weigh by then (spectral tracking: Kutz,
// Habel, Li and Novak 2017, "Spectral and decomposition tracking for rendering heterogeneous volumes"),
// so that the mean of its weights never grows: no speckle comes from colours that are absorbed
// differently. Absorption lowers weights, and light ones end by Russian roulette. All of it is without
// bias.

#include <cstdint>
#include <vector>

#include "tools/render/optics.h"
#include "tools/render/random.h"
#include "tools/render/scene.h"
#include "tools/render/volume.h"

namespace openfab::render {

/// Immutable; one for all threads.
class Tracer {
  public:
    /// `volume` must outlive it. A macrocell is `macro_blocks` blocks wide: 1, 2 or 4.
    Tracer(const Volume* volume, const Optics& optics, Scene scene, int32_t macro_blocks = 1);

    /// Returns the light that comes along one random path to `from_mm`, in air, out of `direction`
    /// (unit). `met` tells whether the print was there.
    Rgb trace(const Vec3d& from_mm, const Vec3d& direction, Random* random, bool* met) const;

    /// Traces through a place of the picture, 0 … 1 from the left and from the top.
    Rgb trace_picture(double x, double y, Random* random, bool* met) const;

  private:
    struct Macrocell {
        float majorant = 0;  ///< per mm
        Volume::Kind kind = Volume::Kind::kOutside;
    };
    struct Material {
        double extinction[3], scattering[3];
        double anisotropy;
    };
    /// A path's head. Positions are in the volume's coordinates, directions in millimetres.
    struct Ray {
        Vec3d at;
        Vec3d direction;  ///< unit
        Vec3d step;       ///< voxels per mm along it
        bool inside = false;
    };
    enum class Event { kAway, kSurface, kCollision };
    struct Exits;

    void aim(const Vec3d& direction, Ray* ray) const;
    /// Returns the millimetres to where a ray from outside enters the box of blocks, or infinity.
    double enter(const Ray& ray) const;
    /// Moves the ray to what it meets next within `most_mm`. A tentative collision is drawn where
    /// `random` is given.
    Event walk(double most_mm, Random* random, Ray* ray, double* majorant) const;
    bool find_surface(const Ray& ray, const Exits& exits, double from, double to,
                      double* where) const;
    Vec3d slope(const Vec3d& at) const;         ///< of coverage per mm, exact in the dual cell
    Vec3d smooth_slope(const Vec3d& at) const;  ///< over a voxel
    double coverage(const Vec3d& at) const;
    double distance_to_backdrop(const Ray& ray) const;
    /// Lets the ray bounce; returns false where there is no surface to bounce off.
    bool bounce(Ray* ray, Random* random) const;
    bool collide(const Ray& ray, double majorant, Random* random, Rgb* weight, Vec3d* turned) const;
    /// The light out of a direction: of one that a diffuse surface drew with the density `diffuse` (else
    /// 0) the share that lamp_light leaves to it.
    Rgb sky(const Vec3d& direction, double diffuse) const;
    /// Light from the lamps at a place of the backdrop, per albedo.
    Rgb lamp_light(const Ray& ray, Random* random) const;

    const Volume& volume_;
    Scene scene_;
    SurfaceOptics surface_;
    std::vector<Material> materials_;
    std::vector<Macrocell> cells_;
    Vec3i cell_count_;
    int32_t cell_shift_ = 3;  ///< of coordinates to macrocells
    Vec3d per_mm_;            ///< voxels
    double apart_mm_ = 0;     ///< from the surface, where a ray goes on: far below a free path
};

}  // namespace openfab::render

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Traces light backwards through a print: from the camera to a lamp, by refraction and reflection at
// the outer surface, absorption and scattering inside (flights.h). Absorption lowers weights, and light
// ones end by Russian roulette. All of it is without bias.

#include <atomic>
#include <cstdint>
#include <functional>
#include <vector>

#include "tools/render/flights.h"
#include "tools/render/optics.h"
#include "tools/render/random.h"
#include "tools/render/scene.h"
#include "tools/render/skin.h"
#include "tools/render/volume.h"

namespace openfab::render {

/// Where a path begins, in air, and the direction (unit) out of which its light comes.
struct PathStart {
    Vec3d from_mm, direction;
    Random random;
};

/// Immutable; one for all threads.
class Tracer {
  public:
    /// `volume` must outlive it. A macrocell is `macro_blocks` blocks wide: 1, 2 or 4. `instruction_set` limits that of
    /// its flights (best_flight).
    Tracer(const Volume* volume, const Optics& optics, Scene scene, int32_t macro_blocks = 1,
           int instruction_set = 2);

    // Flights have its address.
    Tracer(const Tracer&) = delete;
    Tracer& operator=(const Tracer&) = delete;

    using Start = std::function<PathStart(int32_t path)>;
    /// Takes the light of a path, and whether it met the print.
    using Finish = std::function<void(int32_t path, const Rgb& light, bool met)>;
    /// Traces paths 0 ... count - 1, which finish in any order. None depends on the others.
    /// Returns false, with some of them left out, soon after `stop` is set.
    bool trace(int32_t count, const std::atomic<bool>& stop, const Start& start,
               const Finish& finish) const;

    /// The start of a path through a place of the picture, 0 ... 1 from the left and from the top.
    PathStart start_in_picture(double x, double y, const Random& random) const {
        return {scene_.camera.eye_mm, scene_.camera.direction(x, y), random};
    }

  private:
    struct Path {
        Ray ray;
        Rgb weight{1, 1, 1};
        Rgb light{};
        Random random{0, 0, 0};
        bool is_direct = true;  ///< has met nothing
        bool met = false;       ///< the print
        double diffuse = 0;     ///< density of the direction, where it comes from the backdrop
        int32_t surfaces = 0;
        int32_t number = 0;
    };

    void aim(const Vec3d& direction, Ray* ray) const;
    static bool meets(const void* tracer, Lanes* lanes, int32_t lane, float mm);
    double distance_to_backdrop(const Ray& ray) const;
    /// Lets the ray bounce; returns false where there is no surface to bounce off.
    bool bounce(Ray* ray, Random* random) const;
    /// Leads a path on until it is inside; returns false where it ended.
    bool enter_print(Path* path) const;
    bool meet_surface(Path* path) const;
    void take_sky(Path* path) const;
    /// Plays for light weights; returns false where the path ends.
    bool play(Path* path) const;
    Vec3i cell_of(const Vec3d& at) const;
    void put(const Path& path, int32_t lane, Lanes* lanes) const;
    void take(const Lanes& lanes, int32_t lane, Path* path) const;
    /// The light out of a direction: of one that a diffuse surface drew with the density `diffuse` (else
    /// 0) the share that lamp_light leaves to it.
    Rgb sky(const Vec3d& direction, double diffuse) const;
    /// Light from the lamps at a place of the backdrop, per albedo.
    Rgb lamp_light(const Ray& ray, Random* random) const;

    const Volume& volume_;
    Scene scene_;
    SurfaceOptics surface_;
    Medium medium_;
    Skin skin_;
    Vec3i cell_count_;
    Fly fly_;
};

}  // namespace openfab::render

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A solid in its own place that is asked for signed distances, and a copy of it that stands somewhere in what grows.
// Threads share both.

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "abi/fablet_table.h"
#include "base/pool.h"
#include "base/result.h"
#include "runtime/part/part.h"
#include "runtime/solid/solid.h"

namespace openfab::solid {

class Standing {
  public:
    /// What is nearest to a point; without surface all but the distance is 0.
    struct Found {
        float distance = 0;  ///< negative inside; +inf without surface
        Vec3f position, normal;
    };

    /// `part`: of which `solid` is made, in its own place.
    Standing(std::shared_ptr<const part::Part> part, std::shared_ptr<Solid> solid,
             const QuerySetUp& queries);

    /// Answers points of the solid's own space, mm. With `surface` positions and normals, too.
    void ask(std::span<const Vec3d> points, bool surface, Found* out) const;

    /// Returns a box that holds it, in its own space.
    const Box3f& bounds() const { return bounds_; }
    /// Returns points of its surface that reach farthest, or corners of its box.
    const std::vector<Vec3f>& extremes() const { return extremes_; }
    const Solid& solid() const { return *solid_; }
    /// Returns about how many bytes it takes.
    size_t bytes() const;

  private:
    struct Tools {
        std::unique_ptr<Scratch> scratch;
        std::vector<nearest::PointPacket> points;
        std::vector<nearest::PointAnswer> answers;
    };

    const std::shared_ptr<const part::Part> part_;
    const std::shared_ptr<Solid> solid_;
    part::Grid grid_;
    std::array<float, OPENFAB_FRAME_COUNT> frame_{};
    std::unique_ptr<Placed> placed_;
    Box3f bounds_;
    std::vector<Vec3f> extremes_;
    mutable Pool<Tools> tools_;
};

/// A solid that stands in what grows: turned, moved, perhaps mirrored, and scaled alike along all axes.
struct GrownBody {
    std::shared_ptr<const Standing> solid;
    Vec3d at;                   ///< where its origin is, mm of part space
    std::array<Vec3d, 3> axes;  ///< where its axes point; orthogonal, of length 1
    double scale = 1;

    /// Takes the axes, of whose lengths the scale is made. Returns what is wrong with them.
    Complaint set_axes(const std::array<Vec3f, 3>& axes);
    /// Returns a point of part space in the solid's own.
    Vec3d to_solid(const Vec3d& p) const {
        const Vec3d d = p - at;
        return {dot(d, axes[0]) / scale, dot(d, axes[1]) / scale, dot(d, axes[2]) / scale};
    }
    Vec3d from_solid(const Vec3d& p) const { return at + turned(p) * scale; }
    Vec3d turned(const Vec3d& v) const { return axes[0] * v.x + axes[1] * v.y + axes[2] * v.z; }
    /// Returns a box that holds it, part space.
    Box3f box() const;
    /// Returns a box of points of it, part space.
    Box3f reached() const;
    /// Answers points of part space.
    void ask(std::span<const Vec3d> points, bool surface, std::vector<Standing::Found>* out) const;
    float distance(const Vec3d& p) const;
};

/// Returns by how much the distance of a body may be wrong, `d` away or within `reach` of there: rule 16, with a margin.
inline float body_slack(float d, float reach) {
    constexpr float kRelative = 0x1p-13f;
    return kRelative * (std::fabs(d) + reach);
}

}  // namespace openfab::solid

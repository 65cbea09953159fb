// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The objects that a shape's stage asks for distances (part::ShapeStage::bodies), as solids in their own
// places. Threads share it.

#include <array>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "abi/fablet_table.h"
#include "runtime/nearest/engine.h"
#include "runtime/part/shape_stage.h"
#include "runtime/solid/kind.h"
#include "runtime/solid/solid.h"

namespace openfab::solid {

/// What may be made for bounds of distances.
enum class Effort : uint8_t {
    kBox,   ///< nothing: a distance is no larger than that to the farthest corner of the body's box
    kNear,  ///< no micropolygons of bodies whose distances are bounded without
    kGrid,  ///< distances at points of a grid, some cells apart, which bound those around; of dense points
    kExact,  ///< all that is needed
};

class ShapeBodies {
  public:
    /// Scratch memory of one thread.
    class Tools {
      public:
        friend class ShapeBodies;

      private:
        std::vector<std::unique_ptr<Scratch>> scratch_;
        std::vector<nearest::PointPacket> points_;
        std::vector<nearest::PointAnswer> answers_;
        std::vector<nearest::PointBounds> ranges_;
        std::array<std::vector<float>, 3> moved_lo_, moved_hi_;
        std::vector<int8_t> sides_;
        /// By body: distances at points of the grid, by the bits of their places.
        std::vector<std::unordered_map<uint64_t, float>> grid_;
    };

    /// `stage` is the part with these bodies, which must outlive it.
    ShapeBodies(const part::ShapeStage& stage, const Bodies& solids, double cell_mm,
                openfab_isa isa);

    /// Computes the signed distances, mm, to a body at n points of the stage, part-local, by axis;
    /// infinite where a coordinate is NaN, or beyond nearest::kMaxCoordinate.
    void distances(size_t body, const std::array<const float*, 3>& points, size_t n, Tools* tools,
                   float* out) const;
    /// Whether bounds of distances to a body are cheaper than distances, which take its micropolygons.
    bool any_quick() const;
    /// Computes bounds of them over n boxes; both NaN where nothing is known.
    void bounds(size_t body, const std::array<const float*, 3>& lo,
                const std::array<const float*, 3>& hi, size_t n, Effort effort, Tools* tools,
                float* out_lo, float* out_hi) const;
    /// Returns the bytes that trees of bodies will still take once all exist, and what of them is diced.
    int64_t query_bytes() const;
    /// Returns an error if a body is impossible.
    Result<void> status() const;

  private:
    struct Body {
        std::shared_ptr<Solid> solid;
        std::array<float, OPENFAB_FRAME_COUNT> frame{};
        std::unique_ptr<Placed> placed;
        Vec3d move;  ///< from points of the stage to those of the body
        /// Bounds of distances take no micropolygons, and their signs are those of values (Solid::sides).
        bool quick = false;
        bool empty = false;  ///< has no surface: distances are infinite
    };
    void box_bounds(size_t body, const std::array<const float*, 3>& lo,
                    const std::array<const float*, 3>& hi, size_t n, float* out_lo,
                    float* out_hi) const;
    void grid_bounds(size_t body, const std::array<const float*, 3>& lo,
                     const std::array<const float*, 3>& hi, size_t n, Tools* tools, float* out_lo,
                     float* out_hi) const;
    void give_signs(size_t body, const std::array<const float*, 3>& lo,
                    const std::array<const float*, 3>& hi, size_t n, Tools* tools, float* out_lo,
                    float* out_hi) const;
    bool find_sides(size_t body, const std::array<const float*, 3>& lo,
                    const std::array<const float*, 3>& hi, size_t n, Tools* tools) const;
    void load(size_t body, const std::array<const float*, 3>& points, size_t n, Tools* tools) const;
    /// Bounds how far micropolygons are from points, without these.
    void near_distances(size_t body, const std::array<const float*, 3>& points, size_t n,
                        Tools* tools, float* out_lo, float* out_hi) const;

    part::Grid grid_;
    std::vector<Body> bodies_;
};

}  // namespace openfab::solid

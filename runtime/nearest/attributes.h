// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The @nearest inputs of the volume stage: attribute values at the nearest points of a block, and
// how they change from voxel to voxel (the footprint of a texture look-up).

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "runtime/nearest/engine.h"
#include "runtime/surface/surface.h"

namespace openfab::nearest {

/// Where the values go: arrays of 512 in the order of BlockAnswer, one for each flattened component
/// of the fablet's
/// @nearest inputs, floats and others apart (the order of MicroMesh). A null pointer, or a null
/// array, is not written. Voxels that did not ask, or have no surface in reach, get 0.
struct AttributeTargets {
    float* const* values = nullptr;  ///< [float component] -> 512
    float* const* gradients =
        nullptr;  ///< [float component * 3 + axis] -> 512: change for one voxel step along i, j, k
    uint32_t* const* flat = nullptr;  ///< [int component] -> 512, 32-bit patterns
};

/// The same for 8 points, and the surface there. A null pointer, or a null array, is not written;
/// lanes without an answer get 0.
struct PointTargets {
    float* position[3] = {};  ///< part-local mm: v0 + (bary1 (v1 - v0) + bary2 (v2 - v0))
    /// Unit, outward, of the winning micropolygon, rounded once from double; 0 where it has no
    /// area.
    float* normal[3] = {};
    float* const* values = nullptr;   ///< [float component] -> 8
    uint32_t* const* flat = nullptr;  ///< [int component] -> 8, 32-bit patterns
};

class AttributeReader {
  public:
    /// Copies the attributes of identity patches; the surface must outlive the reader. `geometry`:
    /// positions or normals will be read, even where there is no attribute.
    AttributeReader(const surface::Surface& surface,
                    const std::array<float, OPENFAB_FRAME_COUNT>& frame, bool geometry = false);
    /// The same surface standing elsewhere: shares the copies. Scratch of one serves both.
    AttributeReader(const AttributeReader& other,
                    const std::array<float, OPENFAB_FRAME_COUNT>& frame);

    /// One a thread: holds the patch that was read last.
    class Scratch {
        friend class AttributeReader;
        int32_t patch_ = -1;
        std::shared_ptr<const surface::MicroMesh> micro_;
    };

    /// Float components: a0 + bary1 (a1 - a0) + bary2 (a2 - a0), added from the left. Others: the
    /// triangle's own. Gradients: of the linear interpolant in the triangle's plane, zero along its
    /// normal, zero for a triangle without area. `demand` as in BlockQuery.
    void read(const BlockAnswer& answer, const uint8_t* demand, const AttributeTargets& targets,
              Scratch* scratch) const;
    void read_points(const PointAnswer& answer, const PointTargets& targets,
                     Scratch* scratch) const;

  private:
    /// One triangle's corners and attributes, wherever they are kept.
    struct Source {
        const float* position[3];
        const float* attribute[3];
        const uint32_t* flat;
    };
    void set_steps(const std::array<float, OPENFAB_FRAME_COUNT>& frame);
    Source find(int32_t patch, int32_t triangle, Scratch* scratch) const;

    const surface::Surface& surface_;
    std::array<float, 9> steps_;  ///< part-local mm: STEP_I, STEP_J, STEP_K
    int32_t float_components_;
    int32_t int_components_;
    /// Of identity patches.
    struct Copies {
        std::vector<int32_t>
            first;  ///< of each patch: its first triangle below, or -1 where it is diced on demand
        std::vector<float> positions;   ///< [triangle][corner][3]
        std::vector<float> attributes;  ///< [triangle][corner][float component]
        std::vector<uint32_t> flat;     ///< [triangle][int component]
    };
    std::shared_ptr<const Copies> copies_;
};

}  // namespace openfab::nearest

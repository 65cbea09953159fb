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
#include "runtime/nearest/targets.h"
#include "runtime/surface/surface.h"

namespace openfab::nearest {

/// Interpolates the @nearest inputs of one surface in one frame. Threads share it, each with a
/// Scratch of its own.
class AttributeReader {
  public:
    /// Copies the attributes of identity patches; the surface must outlive the reader. Set
    /// `geometry` if positions or normals will be read, which needs copies even without attributes.
    AttributeReader(const surface::Surface& surface,
                    const std::array<float, OPENFAB_FRAME_COUNT>& frame, bool geometry = false);
    /// Reads the same surface in another frame: shares the copies. Scratch of one serves both.
    AttributeReader(const AttributeReader& other,
                    const std::array<float, OPENFAB_FRAME_COUNT>& frame);

    /// Scratch memory of one thread: holds patches that were read last, as neighbouring voxels
    /// change between a few.
    class Scratch {
        friend class AttributeReader;
        static constexpr size_t kPatches = 64;
        /// Larger patches share one slot.
        static constexpr size_t kSmall = 256;
        struct Held {
            int32_t patch = -1;
            std::shared_ptr<const surface::MicroMesh> micro;
        };
        std::array<Held, kPatches> held_;  ///< by patch number
        Held large_;
    };

    /// Writes the components at the answers of a block. Floats are a0 + bary1 (a1 - a0) + bary2 (a2
    /// - a0), added from the left; ints are the triangle's own. Gradients are those of the linear
    /// interpolant in the triangle's plane: zero along its normal, and for a triangle without area.
    /// `active` as in BlockQuery.
    void read(const BlockAnswer& answer, const uint8_t* active, const AttributeTargets& targets,
              Scratch* scratch) const;
    /// Writes the components, positions and normals at the answers of a packet.
    void read_points(const PointAnswer& answer, const PointTargets& targets,
                     Scratch* scratch) const;

  private:
    /// Pointers to one triangle's corners and attributes.
    struct Source {
        const float* position[3];
        const float* attribute[3];
        const uint32_t* flat;
    };
    void set_steps(const std::array<float, OPENFAB_FRAME_COUNT>& frame);
    const surface::MicroMesh& held(int32_t patch, int32_t triangle, Scratch* scratch) const;
    Source find(int32_t patch, int32_t triangle, Scratch* scratch) const;

    const surface::Surface& surface_;
    std::array<float, 9> steps_;  ///< part-local mm: STEP_I, STEP_J, STEP_K
    int32_t float_components_;
    int32_t int_components_;
    /// Copies of the identity patches.
    struct Copies {
        /// [patch]: its first triangle in the arrays below, or -1 if it is diced on demand
        std::vector<int32_t> first;
        std::vector<float> positions;   ///< [triangle][corner][3]
        std::vector<float> attributes;  ///< [triangle][corner][float component]
        std::vector<uint32_t> flat;     ///< [triangle][int component]
    };
    std::shared_ptr<const Copies> copies_;
};

}  // namespace openfab::nearest

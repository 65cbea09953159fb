// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reference engine for whole parts: Embree finds the triangles that may be nearest, which are then
// evaluated one by one. It shares neither hierarchy nor traversal with the block engine, and is
// fast enough for every voxel of a part where plain loops are not. Link openfab_test_embree, where
// Embree was found.

#include <array>
#include <memory>

#include "runtime/nearest/engine.h"

namespace openfab::testing {

/// Returns the same bits as the brute-force engine. Every triangle that could win by its distance
/// in float is considered: Embree searches up to the best distance in double plus twice the
/// permitted error between the two (rule 16). Only the `ranges` of the surface must outlive the
/// engine.
class EmbreeEngine : public nearest::Engine {
  public:
    /// Further results of a query, valid until the scratch is used again.
    class Scratch : public nearest::Engine::Scratch {
      public:
        /// Distance of each active voxel in double arithmetic; infinite without surface within the
        /// radius.
        std::array<double, nearest::kBlockVoxels> exact_mm;
        /// The last winner: the next search starts from it, which changes no answer.
        int64_t last = -1;
    };

    /// Returns how much a distance in float may differ from `exact_mm`.
    virtual double allowed_mm(double exact_mm) const = 0;
    virtual int64_t triangle_count() const = 0;
};

/// Makes the engine. It holds all micropolygons, 250 bytes each with Embree's.
std::unique_ptr<EmbreeEngine> make_embree_engine(
    const surface::Surface& surface, const std::array<float, OPENFAB_FRAME_COUNT>& frame);

}  // namespace openfab::testing

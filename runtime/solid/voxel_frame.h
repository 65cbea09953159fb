// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Voxel centres in part-local mm, and boxes that hold those of a box of voxels, exactly.

#include <algorithm>
#include <array>

#include "abi/fablet_table.h"
#include "base/vec.h"

namespace openfab::solid {

class VoxelFrame {
  public:
    explicit VoxelFrame(const std::array<float, OPENFAB_FRAME_COUNT>& frame) : frame_(frame) {}

    /// Returns the centre of a part-relative voxel along an axis, by the formula of
    /// abi/fablet_table.h.
    float centre(size_t a, float x, float y, float z) const {
        return ((x * frame_[OPENFAB_FRAME_STEP_I + a] + y * frame_[OPENFAB_FRAME_STEP_J + a]) +
                z * frame_[OPENFAB_FRAME_STEP_K + a]) +
               frame_[OPENFAB_FRAME_ORIGIN + a];
    }
    /// Returns the box of the centres of voxels lo … hi, both included. Each operation of the formula
    /// is monotone, rounded, too.
    Box3f box(const Vec3i& lo, const Vec3i& hi) const {
        Box3f out;
        for (size_t a = 0; a < 3; ++a) {
            float low[3], high[3];
            for (int axis = 0; axis < 3; ++axis) {
                const float step = frame_[static_cast<size_t>(3 * axis) + a];
                const float first = (static_cast<float>(lo[axis]) + 0.5f) * step;
                const float last = (static_cast<float>(hi[axis]) + 0.5f) * step;
                low[axis] = std::min(first, last);
                high[axis] = std::max(first, last);
            }
            const float origin = frame_[OPENFAB_FRAME_ORIGIN + a];
            out.lo[static_cast<int>(a)] = ((low[0] + low[1]) + low[2]) + origin;
            out.hi[static_cast<int>(a)] = ((high[0] + high[1]) + high[2]) + origin;
        }
        return out;
    }

    /// Whether axes of voxels are those of the part: then coordinate a of a centre depends on index a alone, and grows.
    bool is_straight() const {
        for (size_t axis = 0; axis < 3; ++axis)
            for (size_t a = 0; a < 3; ++a)
                if (axis == a ? !(frame_[3 * axis + a] > 0) : frame_[3 * axis + a] != 0)
                    return false;
        return true;
    }
    /// Of such a frame: where the centre of voxel 0 would be, and the way to the next.
    double first(size_t a) const {
        return static_cast<double>(frame_[OPENFAB_FRAME_ORIGIN + a]) + 0.5 * step(a);
    }
    double step(size_t a) const { return static_cast<double>(frame_[3 * a + a]); }

  private:
    std::array<float, OPENFAB_FRAME_COUNT> frame_;
};

}  // namespace openfab::solid

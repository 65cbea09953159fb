// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The colours of the last three slices, by which rectangles of faces are divided.

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "backends/boundary/rectangle.h"

namespace openfab::boundary {

class ColorLayers {
  public:
    /// Memory for each voxel of a slice, in bytes.
    static constexpr int64_t kBytesPerColumn = 3 * sizeof(uint32_t);

    ColorLayers(int32_t width, int32_t height) : width_(static_cast<size_t>(width)) {
        for (std::vector<uint32_t>& layer : layers_)
            layer.resize(width_ * static_cast<size_t>(height));
    }

    /// `colors`: of the voxels of slice z, x first, then y from the lowest.
    void fill(int32_t z, const uint32_t* colors) {
        std::vector<uint32_t>& layer = layers_[slot(z)];
        std::copy(colors, colors + layer.size(), layer.begin());
    }

    /// Visits the parts of a rectangle within which neither side changes its colour, with their colours. Runs
    /// along u grow along v while they are the same. Void, of code 0, has the colour 0.
    template <typename Visit>
    void split(const Rectangle& whole, Visit visit) {
        growing_.clear();
        for (int32_t v = whole.v0; v < whole.v1; ++v) {
            next_.clear();
            size_t at = 0;
            const auto close = [&](int32_t before) {
                for (; at < growing_.size() && growing_[at].u0 < before; ++at)
                    visit(growing_[at]);
            };
            for (int32_t u = whole.u0; u < whole.u1;) {
                Rectangle run = face(whole, u, v);
                for (++u; u < whole.u1 && continues(run, face(whole, u, v)); ++u)
                    run.u1 = u + 1;
                close(run.u0);
                if (at < growing_.size() && growing_[at].u0 == run.u0 &&
                    growing_[at].u1 == run.u1 && continues(growing_[at], run))
                    run.v0 = growing_[at++].v0;
                next_.push_back(run);
            }
            close(whole.u1);
            growing_.swap(next_);
        }
        for (const Rectangle& r : growing_)
            visit(r);
    }

  private:
    static size_t slot(int32_t z) { return static_cast<size_t>(z + 3) % 3; }
    static bool continues(const Rectangle& a, const Rectangle& b) {
        return a.low_color == b.low_color && a.high_color == b.high_color;
    }

    uint32_t at(const Vec3i& voxel) const {
        return layers_[slot(voxel.z)]
                      [static_cast<size_t>(voxel.y) * width_ + static_cast<size_t>(voxel.x)];
    }

    /// The face of the rectangle whose lowest corner is (u, v).
    Rectangle face(const Rectangle& whole, int32_t u, int32_t v) const {
        Rectangle out = whole;
        out.u0 = u, out.u1 = u + 1;
        out.v0 = v, out.v1 = v + 1;
        Vec3i voxel;
        voxel[whole.u_axis()] = u;
        voxel[whole.v_axis()] = v;
        voxel[whole.axis] = whole.plane;
        out.high_color = whole.high == 0 ? 0 : at(voxel);
        --voxel[whole.axis];
        out.low_color = whole.low == 0 ? 0 : at(voxel);
        return out;
    }

    size_t width_;
    std::array<std::vector<uint32_t>, 3> layers_;  ///< by z modulo 3
    std::vector<Rectangle> growing_, next_;
};

}  // namespace openfab::boundary

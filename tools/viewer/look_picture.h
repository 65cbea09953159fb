// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Values of nodes as the page gets them: pictures over a plane or a surface, curves along a line, numbers in a voxel.

#include <cstdint>
#include <string>
#include <vector>

#include "base/json_text.h"
#include "base/vec.h"
#include "tools/viewer/printed_values.h"

namespace openfab::viewer {

/// Where places stand in a picture: those of a plane across an axis as the page shows it, those of a surface from the
/// front right, above.
class LookPicture {
  public:
    /// `axis`: 0 to 2, a plane across it; 3: a surface.
    LookPicture(const std::vector<Vec3d>& places, double pixel_mm, int axis);

    /// Writes "width", "height", "pixel_mm" and "inside".
    void write_frame(JsonText* out) const;
    /// Writes "low", "high" and "values" of a node.
    void write(const PrintedValue& value, JsonText* out) const;

  private:
    double pixel_mm_;
    int width_ = 0, height_ = 0;
    std::vector<int64_t> nearest_;  ///< the place in each pixel; -1: none
};

/// Values along a line.
class LookCurve {
  public:
    /// Of places `step_mm` apart along `axis`, the first at `from_mm`.
    LookCurve(const std::vector<Vec3d>& places, int axis, double from_mm, double step_mm,
              int count);

    /// Writes "axis", "from_mm" and "step_mm".
    void write_frame(JsonText* out) const;
    /// Writes "low", "high" and "values": of each place all numbers, null where there is no material or no number.
    void write(const PrintedValue& value, JsonText* out) const;

  private:
    int axis_;
    double from_mm_, step_mm_;
    std::vector<int64_t> there_;
};

/// Writes "values" of a node in one voxel; as text what is no number.
void write_voxel(const PrintedValue& value, JsonText* out);

}  // namespace openfab::viewer

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Preview pictures of a print, gathered while its slices pass.
//
//   top        from +z. A viewer sees a little way into resin, so a column's colour is the mean
//              over the outermost run of voxels, down to kSightEndMm, with weights that fall to
//              half over kSightMm; then soft shading by the height field.
//   bottom     same from -z, +x to the left, with stronger shading: relief.
//   section    cut along x at the middle row.
//   slice:N    one slice.
//   front, right, back, left  from that side and 5 degrees above it, as model:0:5, :90:5, …
//   model:TURN:TILT  from above at an angle, with cut=x|y|xy opened: model_view.h
//   light=transmitted  light from behind: with t the solid thickness of a column and t_min, t_max
//              over all covered columns, T = max(0, 1 - ((t - t_min) / (t_max - t_min))^2).
//              Transmission falls with the square of the thickness, as the OpenFab paper's
//              postcard assumes; absolute brightness is left out, since it depends on the lamp.
//
// Means are taken in linear light, and the PNG is sRGB with the print's coverage as alpha.

#include <memory>

#include "backends/common/tee_sink.h"
#include "backends/preview/picture.h"
#include "backends/preview/preview_spec.h"

namespace openfab::preview {

constexpr double kSightMm = 0.1;
constexpr double kSightEndMm = 0.4;

/// Returns the maximum memory that one preview gathers, for the budget; drawing it at the end takes
/// kDrawBytes. Both are for the largest grids; a postcard takes a third.
int64_t gathered_bytes(const PreviewSpec& spec);
constexpr int64_t kColumnBytes = 28'000'000;
constexpr int64_t kDrawBytes = 64'000'000;

/// Makes a preview, which writes its file when the print ends, even early; or passes its picture
/// to `take`, if given. begin() fails for a slice that the print does not have.
std::unique_ptr<backends::SliceObserver> make_preview(const PreviewSpec& spec,
                                                      TakePicture take = {});

}  // namespace openfab::preview

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Parses `--preview FILE.png[,view=VIEW][,light=transmitted][,cut=x|y|xy]`, where VIEW is top, bottom, front,
// right, back, left, section, slice:N or model:TURN:TILT.

#include <cstdint>
#include <string>

#include "base/result.h"

namespace openfab::preview {

enum class View {
    kTop,      ///< from +z: +x right, +y up
    kBottom,   ///< from -z, as after turning the print about its vertical axis: +x left, +y up
    kSection,  ///< cut along x at the middle row: +x right, +z up
    kSlice,    ///< one slice as it is printed: +x right, +y up
    kModel,    ///< from above at an angle, or from a side; clear materials are transparent
};

/// The part that kModel cuts away to show the inside: of the print's box, the half that faces the
/// viewer in x or y, or the quarter that does in both.
enum class Cut { kNone, kX, kY, kXY };

struct PreviewSpec {
    std::string file;
    View view = View::kTop;
    int32_t slice = 0;         ///< kSlice: its z
    double turn_deg = 30;      ///< kModel: 0 looks along +y, 90 along -x
    double tilt_deg = 30;      ///< kModel: above the horizon, 5 … 90
    Cut cut = Cut::kNone;      ///< kModel
    bool transmitted = false;  ///< top or bottom only: light from behind
};

Result<PreviewSpec> parse_preview(const std::string& text);
/// Parses what follows the file, as `view=bottom,light=transmitted`, for a host that draws into memory: the
/// file is empty.
Result<PreviewSpec> parse_view(const std::string& text);

}  // namespace openfab::preview

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What `--preview FILE.png[,view=front|back|section|slice:N][,light=transmitted]` asks for.

#include <cstdint>
#include <string>

#include "runtime/base/result.h"

namespace openfab::preview {

enum class View {
    kFront,    ///< from +z: +x right, +y up
    kBack,     ///< from -z, as after turning the print about its vertical axis: +x left, +y up
    kSection,  ///< cut along x at the middle row: +x right, +z up
    kSlice,    ///< one slice as it is printed: +x right, +y up
};

struct PreviewSpec {
    std::string file;
    View view = View::kFront;
    int32_t slice = 0;         ///< kSlice: its z
    bool transmitted = false;  ///< front or back only: light from behind
};

Result<PreviewSpec> parse_preview(const std::string& text);

}  // namespace openfab::preview

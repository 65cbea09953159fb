// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The tray of a machine that `--fit` names.

#include <string>

#include "base/result.h"
#include "base/vec.h"

namespace openfab::tools {

struct MachineTray {
    Vec3d size_mm;        ///< before the machine's scale, which enlarges what it prints
    Vec3d low_mm;         ///< where it begins there, counted from the tray's corner
    std::string printer;  ///< the profile's name; empty where a size was given
};

/// Reads `--fit`: a printer, or a size such as 490x390x200mm.
Result<MachineTray> machine_tray(const std::string& fit);

/// Reads a length of an option, which may be 0.
Result<double> length_option(const char* option, const std::string& text);

}  // namespace openfab::tools

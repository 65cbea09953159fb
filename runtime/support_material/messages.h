// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of support: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for. Tests name rows, so
// wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::support_material::messages {

// depth_map
OPENFAB_MESSAGE(kSupportTakesMemory, "support does not fit the memory budget: its depth map takes more than {}, up to {}; allow more, as `--memory 4GB`, or print with `--support off`")

}  // namespace openfab::support_material::messages

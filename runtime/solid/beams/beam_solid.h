// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The geometry of beams: the union of round cones and balls (part::Part::beams).

#include "runtime/solid/kind.h"

namespace openfab::solid {

extern const Kind kBeamKind;

}  // namespace openfab::solid

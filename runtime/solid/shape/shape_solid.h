// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The geometry of a shape: a function of a point, negative inside (part::Part::shape).

#include "runtime/solid/kind.h"

namespace openfab::solid {

extern const Kind kShapeKind;

}  // namespace openfab::solid

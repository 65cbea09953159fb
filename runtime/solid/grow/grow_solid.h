// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The geometry of what grows by rules: beams that are made where something asks for them (part::Part::shape, of a
// stage that grows).

#include "runtime/solid/kind.h"

namespace openfab::solid {

extern const Kind kGrowKind;

}  // namespace openfab::solid

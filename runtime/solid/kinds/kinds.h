// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The kinds of solids that a print may hold.

#include "runtime/solid/kind.h"

namespace openfab::solid {

/// Returns the kind of a part's geometry. Every part has one.
const Kind& kind_of(const part::Part& part);

}  // namespace openfab::solid

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The slot of the output of a bounds stage that belongs to none, for passes.

#include "abi/looks.h"

namespace openfab::ir {

using abi::kLooksSlot;

}  // namespace openfab::ir

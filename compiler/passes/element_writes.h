// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The half of cut_elements that finds what a kernel writes.

#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// Takes states out of what a kernel writes that are elements of an array, of which one gets a value by
/// an index, or all a value or those of another array. Returns the steps that write them after the
/// kernel. What these read gets states, which are appended and written by the kernel.
std::vector<openfab_elements> take_writes(ir::Stage* kernel, std::vector<ir::Type>* states);

}  // namespace openfab::passes

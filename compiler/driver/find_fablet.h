// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "compiler/ir/ir.h"

namespace openfab::driver {

/// Returns the fablet of a name, or the only one where `name` is empty; else null, and `fault` says what there is.
const ir::Fablet* find_fablet(const ir::Module& module, const std::string& name,
                              std::string* fault);

}  // namespace openfab::driver

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Derivatives of fractions by uniforms: of a program that is asked for them, and where a fablet jumps.

#include <cstdint>
#include <string>
#include <vector>

#include "compiler/diag/sink.h"
#include "compiler/ir/ir.h"

namespace openfab::driver {

/// Replaces the volume of a fablet that declares uniforms of these names (abi/element_name.h) by one with derivatives
/// (passes/form_jacobian.h), and says in which directions, by the indices of floats among the uniform values, one
/// uniform after the other in the order of the names. Warns where the fractions jump. Returns false after errors.
bool differentiate(const std::vector<std::string>& names, ir::Fablet* fablet,
                   std::vector<int32_t>* directions, diag::Sink* sink);

/// Warns where the fractions of a fablet jump by its uniforms, or by those of some names, and names what is smooth
/// instead.
void warn_of_jumps(const ir::Fablet& fablet, diag::Sink* sink,
                   const std::vector<std::string>& names = {});

}  // namespace openfab::driver

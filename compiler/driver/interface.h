// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a world has to know of a module's fablets, as text.

#include <string>

#include "compiler/ir/ir.h"

namespace openfab::driver {

/// Returns a module's interface as JSON:
/// `{"fablets":[{"name","has_surface","uniforms":[{"name","type","kind":"value|texture2d|material|
/// texture3d|object","components","array_length","default":[…] (all elements in order) or
/// null,"annotations":{…},"enum":its name,"choices":[{"name","label","value"}] if its values have names}],"surface_inputs":[{"name","type","default"}],
/// "surface_outputs":[{"name","type","copies":input or
/// null}],"nearest":[{"name","type","from":surface output or null}], "uses_void"}]}` and a newline.
/// A float that is not a JSON number is written as a string.
std::string describe(const ir::Module& module);

}  // namespace openfab::driver

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "compiler/check/tree.h"

namespace openfab::check {

/// Returns the attribute of this name that a stage's attributes have, and its type; nothing if they have none.
std::optional<Attribute> find_attribute(std::string_view name, const Type& attributes, Type* type);

}  // namespace openfab::check

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Units of length as files name them.

#include <optional>
#include <string>

namespace openfab::texture {

/// The size in mm of a unit by its sign or its name, as writers of files spell it; nothing for any other.
std::optional<double> named_length_mm(const std::string& name);

}  // namespace openfab::texture

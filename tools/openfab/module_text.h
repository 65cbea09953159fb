// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pieces of modules that are made of tables.

#include <string>

namespace openfab::tools {

/// `sole_modulus` makes SOLE_MODULUS; empty where that is no name.
std::string constant_name(const std::string& stem);
/// Puts words into lines of a comment.
std::string comment(const std::string& text);

}  // namespace openfab::tools

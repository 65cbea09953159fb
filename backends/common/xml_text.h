// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Text in XML files.

#include <string>

namespace openfab::backends {

/// Escapes text of an attribute or element. Characters that XML does not allow are replaced.
std::string escape_xml(const std::string& text);

}  // namespace openfab::backends

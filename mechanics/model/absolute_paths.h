// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Values of a world for another folder.

#include <filesystem>

#include "base/json_text.h"

namespace openfab::mechanics {

/// Writes a value of a world with the paths in it made absolute.
void write_absolute(const JsonValue& value, const std::filesystem::path& folder, JsonText* out);

}  // namespace openfab::mechanics

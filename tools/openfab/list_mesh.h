// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What `openfab info` and `openfab import --list` say of a mesh file.

#include <filesystem>
#include <optional>
#include <string>

#include "base/result.h"

namespace openfab::tools {

struct ListOptions {
    std::optional<double> unit_mm;
    bool y_up = false, repair = false, json = false;
    int64_t memory_bytes = 0;
};

/// Shows the bodies, unit, looks and pictures of a file, and what is left out of it.
Result<void> list_mesh(const std::filesystem::path& file, const ListOptions& options);

}  // namespace openfab::tools

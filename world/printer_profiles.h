// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The profiles of world/printers, embedded at build time so that a print binary needs no files
// beside it.

#include <string_view>
#include <vector>

namespace openfab::scene {

struct PrinterProfile {
    std::string_view name;
    std::string_view text;
};

/// Sorted by name.
const std::vector<PrinterProfile>& printer_profiles();

}  // namespace openfab::scene

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Random legal schedules of a fablet's kernels, as files.

#include <filesystem>
#include <random>

namespace openfab::testing {

/// Writes a schedule for each kernel of the only fablet of `source` into a folder, one file a
/// pipeline; returns false where the file has several fablets.
bool write_random_schedules(const std::filesystem::path& source,
                            const std::filesystem::path& folder, std::mt19937* random);

}  // namespace openfab::testing

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Random legal schedules of a file's kernels, as files.

#include <filesystem>
#include <random>

namespace openfab::testing {

/// Writes a schedule for each pipeline of the fablets of `source` into a folder.
void write_random_schedules(const std::filesystem::path& source,
                            const std::filesystem::path& folder, std::mt19937* random);

}  // namespace openfab::testing

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The figures of a print as JSON (`--stats`).

#include <filesystem>
#include <string>

#include "base/result.h"
#include "runtime/pipeline/print.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::report {

/// One JSON object, indented, snake_case keys; ends with a new line. Volumes are millilitres, times
/// seconds, rates millions of voxels a second of the tight box and of solid voxels, of those slices
/// that no earlier print had written.
std::string statistics_json(const slab::PrintStatistics& statistics,
                            const backends::PrintInfo& info);

/// Writes it to a file, which it replaces.
Result<void> write_statistics(const std::filesystem::path& file,
                              const slab::PrintStatistics& statistics,
                              const backends::PrintInfo& info);

}  // namespace openfab::report

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Makes OpenVDB files of prints and of fractions.

#include <cstdint>
#include <string>

#include "base/result.h"

namespace openfab::tools {

/// Writes the slices of an .ofr file (`-`: standard input) as one grid of int32, `material`: the codes,
/// whose names are in its metadata as `material_1` and so on. A slab of eight slices lies in memory,
/// and the grid. Needs a complete print.
Result<void> make_vdb_of_print(const std::string& print, const std::string& vdb,
                               int64_t memory_bytes);

/// Writes an array of `--fractions`, with the JSON beside it, as one grid of float for each material,
/// of its name. Needs a complete array.
Result<void> make_vdb_of_fractions(const std::string& array, const std::string& vdb,
                                   int64_t memory_bytes);

}  // namespace openfab::tools

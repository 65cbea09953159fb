// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Sources of a world as the page gets and changes them, and what the compiler says of them.

#include <filesystem>
#include <string>
#include <vector>

#include "base/json_text.h"
#include "base/result.h"
#include "client/fablet_compiler.h"

namespace openfab::viewer {

/// Writes diagnostics as an array. `sources` are the files that the page knows by number; -1 is another.
void write_diagnostics(const std::vector<client::Diagnostic>& diagnostics,
                       const std::vector<std::filesystem::path>& sources, JsonText* out);

/// Reads a file below one of `roots`, if there are any: what was a file of the world when that was
/// loaded may have become a link to another since.
Result<std::string> read_source(const std::filesystem::path& file,
                                const std::vector<std::filesystem::path>& roots = {});

/// Returns by what the page knows whether a source is still what it has read.
std::string stamp_of(const std::string& text);

}  // namespace openfab::viewer

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where a hand has put the nodes of a fablet's graph: a file beside the fablet, as the page writes it
// (page/graph_places.js). It may be deleted without loss; nothing of a print depends on it.

#include <filesystem>
#include <string>
#include <vector>

#include "base/json.h"
#include "base/result.h"

namespace openfab::viewer {

/// Returns what is kept of a fablet's graph as JSON; `{}` if that is nothing, or nothing that can be read.
std::string graph_places(const std::filesystem::path& fablet,
                         const std::vector<std::filesystem::path>& roots);
/// Keeps another object; one without tabs removes the file.
Result<void> keep_graph_places(const std::filesystem::path& fablet,
                               const std::vector<std::filesystem::path>& roots,
                               const JsonValue& places);

}  // namespace openfab::viewer

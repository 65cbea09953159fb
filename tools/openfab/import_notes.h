// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What an import tells of a file whose world is made.

#include <optional>
#include <string>
#include <vector>

#include "mesh/load/load_mesh.h"

namespace openfab::tools {

/// What the command line says already.
struct Known {
    bool y_up = false;
    std::optional<double> scale;  ///< of a size that was asked for
};

/// Adds notes of what was assumed of the file, and of what its bodies do to each other.
void add_notes(const mesh::LoadedBodies& loaded, const std::string& file, const Known& known,
               std::vector<std::string>* notes);

}  // namespace openfab::tools

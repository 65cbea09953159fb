// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which stock fablet makes a body look as in its file, or whether the one that is asked for can.

#include <string>
#include <vector>

#include "mesh/load/load_mesh.h"
#include "tools/openfab/import.h"
#include "tools/openfab/import_looks.h"

namespace openfab::tools {

enum class Mapping { kPlanar = 0, kBox = 1, kTriplanar = 2 };
Mapping mapping_of(const ImportOptions& options);

/// Returns how each body is made. Errors: options that do not go together, a fablet that needs
/// coordinates, colours or a picture that are missing.
Result<std::vector<BodyLook>> choose_looks(const mesh::LoadedBodies& loaded,
                                           const std::string& file, const ImportOptions& options,
                                           std::vector<std::string>* notes);

}  // namespace openfab::tools

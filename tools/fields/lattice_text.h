// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "mesh/model/beams.h"

namespace openfab::tools {

/// Returns beams, with their ends and without attributes, as a text that `{"beams": …}` reads
/// (mesh/read/beams_text.h).
std::string lattice_text(const mesh::Beams& beams);

}  // namespace openfab::tools

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The displacement of a 3MF mesh as a surface stage.

#include <string>
#include <vector>

#include "base/result.h"
#include "mesh/read/threemf_build.h"
#include "tools/fields/fablet_text.h"

namespace openfab::tools {

struct DisplacedText {
    std::string
        stage;  ///< of the attributes `displace` and `displace_n` that the reader of meshes makes
    std::vector<FieldMap> maps;
    double most_mm = 0;  ///< how far a point may move
};

/// `to_mm` brings the object to part space.
Result<DisplacedText> displaced_text(const mesh::ThreemfPlaced& placed, const Affine3d& to_mm,
                                     const std::string& file);

}  // namespace openfab::tools

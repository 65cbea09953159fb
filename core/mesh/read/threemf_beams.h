// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "mesh/model/look.h"
#include "mesh/read/beams_text.h"
#include "mesh/read/threemf_lattice_beams.h"

namespace openfab::mesh {

struct ReadThreemfBeams {
    std::vector<ThreemfBeams> lattices;
    bool has_meshes = false;  ///< the build places triangles, too
    double unit_mm = 1;
    std::vector<LeftOut> left_out;
};

/// Reads the beam lattices of a 3MF file. Errors name the part and its line.
Result<ReadThreemfBeams> parse_threemf_beams(std::string_view bytes, const std::string& file,
                                             int64_t memory_bytes);

/// The lattice of this name, or all as one if `body` is empty.
Result<ReadBeams> parse_threemf_beams(std::string_view bytes, const std::string& file,
                                      const std::string& body, int64_t memory_bytes);

}  // namespace openfab::mesh

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

namespace openfab::mesh {

/// A lattice that the build of a 3MF file places.
struct ThreemfBeams {
    std::string name;  ///< of its object, unique in the file; "lattice" where it has none
    Beams beams;  ///< in the file's unit; the int attribute `set` numbers beam sets, 0 for none
    std::vector<std::string> sets;  ///< their names, from number 1
};

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

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The beams of one lattice of a 3MF file: caps, balls, beams that are too short, numbers of sets.

#include <cstdint>
#include <string>
#include <vector>

#include "base/affine.h"
#include "base/result.h"
#include "mesh/model/beams.h"
#include "mesh/read/threemf_extensions.h"
#include "mesh/read/threemf_model.h"

namespace openfab::mesh {

/// A lattice that the build of a 3MF file places.
struct ThreemfBeams {
    std::string name;  ///< of its object, unique in the file; "lattice" where it has none
    Beams beams;  ///< in the file's unit; the int attribute `set` numbers beam sets, 0 for none
    std::vector<std::string> sets;  ///< their names, from number 1
};

/// "object `NAME`".
std::string lattice_place(const std::string& name);

/// Returns the beams of an object that has a lattice, under a map that scales alike in all directions; none
/// are left if all are too short. `name` is for messages, and is not put into the result; what is left out
/// is added to `*told`. Decreases `*memory_bytes`; an error if it is not enough.
Result<ThreemfBeams> lattice_beams(const ThreemfObject& object, const Affine3d& map,
                                   const std::string& name, const std::string& file,
                                   int64_t* memory_bytes, ThreemfTold* told);

}  // namespace openfab::mesh

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/result.h"
#include "mesh/read/beams_text.h"

namespace openfab::mesh {

/// Parses beams in an archive of NumPy arrays (numpy.savez): `nodes` (n, 3), `struts` (m, 2), numbers of
/// nodes, of which two alike make a ball, `radii` of nodes (n,), of struts' ends (m, 2), or one; each
/// other array is an attribute, floats (n,) or (n, 2 to 4) of nodes, integers (m,) of struts. Errors name
/// the array.
Result<ReadBeams> parse_beams_npz(std::string_view bytes, const std::string& file,
                                  int64_t memory_bytes);

}  // namespace openfab::mesh

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Memory that a mesh takes while it is read and checked. A small file may describe a large mesh, so
// readers count before they allocate, and refuse what does not fit. Estimates come from counts,
// never from the allocator: a file is refused on every machine, or on none.

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/result.h"
#include "mesh/model/mesh_source.h"

namespace openfab::mesh {

/// Sizes of a mesh.
struct MeshCounts {
    int64_t vertices = 0;
    int64_t triangles = 0;
    int64_t values = 0;       ///< floats and integers of all attributes
    int64_t attributes = 0;   ///< attributes with a value for each corner
    int64_t group_bytes = 0;  ///< MeshSource::group_bytes
};

MeshCounts counts_of(const MeshSource& source);
MeshCounts counts_of(const Mesh& mesh);

/// Returns the bytes of a mesh itself.
int64_t mesh_bytes(const MeshCounts& counts);

/// Returns the peak bytes while prepare_mesh and the search for crossing triangles work on it, the
/// mesh included.
int64_t preparing_bytes(const MeshCounts& counts);

/// Returns the peak bytes while vectors of `held` bytes grow one value at a time, doubling and
/// copying.
int64_t growing_bytes(int64_t held);

/// "FILE: the mesh of 12 triangles takes 34 MB to read, and 12 MB are allowed; …"
Error too_large_to_read(const std::string& file, int64_t triangles, int64_t needed,
                        int64_t allowed);

}  // namespace openfab::mesh

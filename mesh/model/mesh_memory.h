// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a mesh takes while it is read and checked. A small file may ask for a large mesh, so readers
// count before they make, and what does not fit is refused before it is there. By counts, never by
// what the allocator says: the same file is refused on every machine, or on none.

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/result.h"
#include "mesh/model/mesh_source.h"

namespace openfab::scene {

struct MeshCounts {
    int64_t vertices = 0;
    int64_t triangles = 0;
    int64_t values = 0;       ///< floats and integers of all attributes
    int64_t attributes = 0;   ///< that have a value for each corner
    int64_t group_bytes = 0;  ///< MeshSource::group_bytes
};

MeshCounts counts_of(const MeshSource& source);
MeshCounts counts_of(const Mesh& mesh);

/// What is kept of it.
int64_t mesh_bytes(const MeshCounts& counts);

/// The most that is there at once while prepare_mesh and the search for crossing triangles work on
/// it, itself included.
int64_t preparing_bytes(const MeshCounts& counts);

/// The most that is there while lists grow one value at a time: they double, and are copied then.
int64_t growing_bytes(int64_t held);

/// "FILE: the mesh of 12 triangles takes 34 MB to read, and 12 MB are allowed; …"
Error too_large_to_read(const std::string& file, int64_t triangles, int64_t needed,
                        int64_t allowed);

}  // namespace openfab::scene

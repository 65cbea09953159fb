// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The bodies of a file: what is printed as an object of its own.
//
// A unit is what the reader gave as a body, or, where the faces of each of its looks are a closed
// surface by themselves, those of a look. A closed unit is a body. Open units that share open edges
// are one, and so are a hollow and what it is in.

#include <cstdint>
#include <string>
#include <vector>

#include "mesh/model/mesh_source.h"

namespace openfab::mesh {

struct FoundBody {
    std::string name;  ///< no two equal
    BodyRole role = BodyRole::kPart;
    int32_t assembly = 0;
    bool joined = false;  ///< of several units, whose vertices may be welded
    bool flat = false;    ///< it encloses no volume
};

struct FoundBodies {
    std::vector<FoundBody> bodies;  ///< in the order of the file; at least one
    std::vector<int32_t> of_group;  ///< by group of the source; empty: all is the first body's
    /// Which body a triangle is of.
    int32_t of_triangle(const MeshSource& source, size_t triangle) const {
        return of_group.empty() ? 0 : of_group[source.face_groups[triangle]];
    }
};

/// Finds the bodies of a source, as read. A file of one unit takes no time.
FoundBodies find_bodies(const MeshSource& source);

/// Takes the triangles of bodies out of a source, each with what belongs to it, but without the
/// looks, which all share; `wanted`: their indices, each once.
std::vector<MeshSource> split_bodies(const MeshSource& source, const FoundBodies& found,
                                     const std::vector<int32_t>& wanted);

/// Takes what is printed of a source: all bodies of the role kPart, as one mesh. The others are
/// left out, with a warning.
void keep_parts(const FoundBodies& found, MeshSource* source);

}  // namespace openfab::mesh

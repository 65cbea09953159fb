// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Beams: a solid that is the union of round cones and balls between nodes, as trusses, lattices,
// foams and trees are. In millimetres of mesh space.

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "base/vec.h"
#include "mesh/model/mesh.h"

namespace openfab::mesh {

/// How a beam ends.
enum class BeamEnd : uint8_t {
    kBall,  ///< both ends: the beam is the hull of the balls at its ends, a round cone
    kFlat,  ///< a cone cut across, without a cap
    kDome,  ///< a cone cut across, with half a ball on it
};

/// A beam between two nodes; a ball where both are one.
struct Beam {
    std::array<int32_t, 2> nodes{};
    std::array<float, 2> radii{};  ///< mm
    std::array<BeamEnd, 2> ends{BeamEnd::kBall, BeamEnd::kBall};
};

/// A named attribute. Floats are of nodes, interpolated along beams; ints are of beams.
struct BeamAttribute {
    std::string name;
    bool is_int = false;
    int32_t components = 1;
    std::vector<float> values;  ///< is_int false: [node][component]
    std::vector<int32_t> ints;  ///< is_int true: [beam][component]
};

struct Beams {
    std::vector<Vec3d> nodes;  ///< mm
    std::vector<Beam> beams;
    std::vector<BeamAttribute> attributes;
};

/// The largest number of nodes, and of beams.
constexpr int64_t kMostBeams = std::numeric_limits<int32_t>::max() / 4;

/// Returns the box of the beams.
Box3d box_of(const Beams& beams);

/// Returns the box of one beam of these ends under the rows of a linear map, around its mapped nodes.
void add_beam_box(const Beams& beams, const Beam& beam, const Affine3d& map, Box3d* box);

/// Returns the bytes that they hold.
int64_t beam_bytes(const Beams& beams);

/// Returns a box of triangles that stands for the beams where a mesh is asked for, with attributes of
/// their names and types, all 0.
Mesh box_mesh(const std::string& name, const Beams& beams);

}  // namespace openfab::mesh

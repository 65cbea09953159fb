// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What parts are made of, by kind. runtime/solid/kinds has the solid of each, in the same order.

#include <memory>
#include <variant>

namespace openfab::part {

struct PartBeams;
struct ProgramTable;
struct ShapeStage;

/// The part's mesh, which in all other kinds is a box around what is printed.
struct MeshGeometry {};

struct BeamGeometry {
    std::shared_ptr<const PartBeams> beams;
    const void* shared() const { return beams.get(); }
};

/// What is inside by the values of a @Shape stage.
struct ShapeGeometry {
    std::shared_ptr<const ShapeStage> stage;
    const void* shared() const { return stage.get(); }
};

/// What grows by the rules of a @Grow stage, or by a program of the user's, whose table is the stage's fablet.
struct GrownGeometry {
    std::shared_ptr<const ShapeStage> stage;
    std::shared_ptr<const ProgramTable> program;  ///< null: rules
    const void* shared() const { return stage.get(); }
};

/// `shared` of a kind is the address that parts of one geometry share.
using Geometry = std::variant<MeshGeometry, BeamGeometry, ShapeGeometry, GrownGeometry>;

}  // namespace openfab::part

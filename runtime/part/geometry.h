// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What parts are made of, by kind. runtime/solid/kinds has the solid of each, in the same order.

#include <array>
#include <memory>
#include <variant>

namespace openfab::part {

struct PartBeams;
struct ProgramTable;
struct ShapeStage;

/// The symmetric factor of a placement (base/polar.h).
using StretchBy = std::array<double, 9>;

/// The part's mesh, which in all other kinds is a box around what is printed.
struct MeshGeometry {
    static constexpr bool kReachIsKnown = true;
    static bool stretches_whole(const StretchBy& /*by*/) { return false; }
};

struct BeamGeometry {
    static constexpr bool kReachIsKnown = true;
    std::shared_ptr<const PartBeams> beams;
    const void* shared() const { return beams.get(); }
    static bool stretches_whole(const StretchBy& by);
};

/// What is inside by the values of a @Shape stage.
struct ShapeGeometry {
    static constexpr bool kReachIsKnown = true;
    std::shared_ptr<const ShapeStage> stage;
    const void* shared() const { return stage.get(); }
    static bool stretches_whole(const StretchBy& by);
};

/// What grows by the rules of a @Grow stage, or by a program of the user's, whose table is the stage's fablet.
struct GrownGeometry {
    static constexpr bool kReachIsKnown = false;
    std::shared_ptr<const ShapeStage> stage;
    std::shared_ptr<const ProgramTable> program;  ///< null: rules
    const void* shared() const { return stage.get(); }
    static bool stretches_whole(const StretchBy& by) {
        return by != StretchBy{1, 0, 0, 0, 1, 0, 0, 0, 1};
    }
};

/// `shared` of a kind is the address that parts of one geometry share; what `stretches_whole` is not made
/// stretched, but stretched once it is made; `kReachIsKnown` of what is known to end before it is made.
using Geometry = std::variant<MeshGeometry, BeamGeometry, ShapeGeometry, GrownGeometry>;

}  // namespace openfab::part

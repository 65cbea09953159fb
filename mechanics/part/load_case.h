// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Load cases of a world: what is held and what pushes, by faces of its build; or, of current and of heat,
// what is kept at a voltage or a temperature, and where flows go in.
//
//   "cases": {"carry": {"held": [{"side": "-x"}, {"object": "bolt", "along": "z"}],
//                       "loads": [{"box_mm": [[30, 0, 0], [40, 8, 10]], "force_N": [0, 0, -20]}],
//                       "gravity_m_s2": [0, 0, -9.81]},
//             "sense": {"held": [{"side": "-x", "volt": 0}, {"side": "+x", "volt": 5}]},
//             "warm": {"held": [{"side": "-z", "celsius": 20}], "loads": [{"object": "chip", "watt": 2}]}}

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/json.h"
#include "base/result.h"

namespace openfab::mechanics {

using Vec3 = std::array<double, 3>;

/// Faces of the surface that all of what is given chooses, in the coordinates of the build.
struct FaceChoice {
    std::string object;  ///< within a voxel of it; empty: wherever
    std::optional<std::array<Vec3, 2>> box_mm;
    std::optional<Vec3> point_mm, normal;  ///< on this plane, looking along the normal
    std::optional<int> side;               ///< outermost there: 0 ... 5 of -x +x -y +y -z +z
    std::optional<int> facing;             ///< look there
    SourceLocation location;
    std::string text;  ///< how a message calls it
};

struct Holding {
    FaceChoice faces;
    std::array<bool, 3> along{true, true, true};
    Vec3 move_mm{};
    std::optional<double> level;  ///< volts, or degrees
};

struct Load {
    FaceChoice faces;
    std::optional<Vec3> force_N, torque_Nmm;
    std::optional<double> pressure_MPa;
    std::optional<double> inflow;  ///< A or W
};

enum class CaseKind { kForces, kCurrent, kHeat };

struct LoadCase {
    std::string name;
    CaseKind kind = CaseKind::kForces;
    std::vector<Holding> held;
    std::vector<Load> loads;
    std::optional<Vec3> gravity_m_s2;
    SourceLocation location;
    /// Objects that choose faces.
    std::vector<std::string> objects() const;
};

/// `name` may be empty where the world has one case only.
Result<LoadCase> read_load_case(const std::filesystem::path& world, const std::string& name);
/// An error where a case is not of forces, or where it is, and is wanted as one of flows.
Result<void> check_kind(const LoadCase& load_case, bool flows);
/// Of a world's text; `file` is for messages.
Result<LoadCase> parse_load_case(const std::string& text, const std::string& file,
                                 const std::string& name);

}  // namespace openfab::mechanics

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The meshes and surface stages of the property tests of dicing and of coverage.

#include <random>
#include <string>
#include <vector>

#include "tests/support/meshes/meshes.h"
#include "tests/support/surface/hand_fablet.h"

namespace openfab::testing {

/// Moves every vertex by up to `amount_mm`, rotates the corners of triangles and shuffles their
/// order, and gives each triangle a face number of 0 to 2. A closed mesh stays closed, but may
/// intersect itself.
inline mesh::Mesh shaken(mesh::Mesh mesh, uint32_t seed, double amount_mm) {
    std::mt19937 random(seed);
    const auto number = [&](uint32_t below) { return static_cast<uint32_t>(random() % below); };
    for (Vec3d& p : mesh.positions) {
        for (int axis = 0; axis < 3; ++axis)
            p[axis] += amount_mm * (number(2001) / 1000.0 - 1);
    }
    const size_t count = mesh.triangles.size();
    std::vector<size_t> order(count);
    for (size_t i = 0; i < count; ++i)
        order[i] = i;
    for (size_t i = count; i > 1; --i)
        std::swap(order[i - 1], order[number(static_cast<uint32_t>(i))]);
    mesh::Mesh out = mesh;
    for (size_t i = 0; i < count; ++i) {
        const size_t turn = number(3);
        const auto turned = [&](const std::array<int32_t, 3>& v) {
            return std::array<int32_t, 3>{v[turn], v[(turn + 1) % 3], v[(turn + 2) % 3]};
        };
        out.triangles[i] = turned(mesh.triangles[order[i]]);
        for (size_t a = 0; a < mesh.attributes.size(); ++a) {
            if (mesh.attributes[a].is_int) {
                out.attributes[a].faces[i] = static_cast<int32_t>(number(3));
            } else {
                out.attributes[a].corners[i] = turned(mesh.attributes[a].corners[order[i]]);
            }
        }
    }
    return out;
}

/// Joins two meshes with the same attributes; where they touch, edges have four triangles.
inline mesh::Mesh joined(mesh::Mesh a, const mesh::Mesh& b, const Vec3d& offset_mm) {
    const int32_t first = static_cast<int32_t>(a.positions.size());
    for (const Vec3d& p : b.positions)
        a.positions.push_back(p + offset_mm);
    for (std::array<int32_t, 3> t : b.triangles) {
        for (int32_t& v : t)
            v += first;
        a.triangles.push_back(t);
    }
    for (mesh::MeshAttribute& to : a.attributes) {
        const mesh::MeshAttribute& from = *b.find(to.name);
        const int32_t values = static_cast<int32_t>(to.values.size()) / to.components;
        to.values.insert(to.values.end(), from.values.begin(), from.values.end());
        for (std::array<int32_t, 3> t : from.corners) {
            for (int32_t& v : t)
                v += values;
            to.corners.push_back(t);
        }
        to.faces.insert(to.faces.end(), from.faces.begin(), from.faces.end());
    }
    return a;
}

/// Inverts a surface: joined to a larger one it makes that hollow.
inline mesh::Mesh inside_out(mesh::Mesh mesh) {
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
        for (mesh::MeshAttribute& a : mesh.attributes) {
            if (!a.is_int) std::swap(a.corners[t][1], a.corners[t][2]);
        }
    }
    return mesh;
}

struct Scenario {
    std::string name;
    mesh::Mesh mesh;
    HandMode mode;
    float amplitude_mm;
    double micro_edge_mm;
    bool computed = false;
    double max_displacement_mm = std::numeric_limits<double>::infinity();
};

inline part::Part make_part(const Scenario& scenario, const Affine3d& transform = {}) {
    PartOptions options;
    options.uniform_values = hand_uniforms(scenario.mode, scenario.amplitude_mm);
    options.max_displacement_mm = scenario.max_displacement_mm;
    options.transform = transform;
    return make_part(hand_fablet(scenario.computed), scenario.mesh, options);
}

inline std::vector<Scenario> scenarios() {
    std::vector<Scenario> all;
    all.push_back({"card back", card(7, 5, 1), HandMode::kBack, 0.6f, 0.13});
    all.push_back({"card back, one tile", card(7, 5, 1), HandMode::kBack, 0.6f, 0.9});
    all.push_back({"card back, coarse", card(7, 5, 1), HandMode::kBack, 0.6f, 20});
    all.push_back(
        {"card back, computed outputs", card(3, 2, 0.5), HandMode::kBack, 0.3f, 0.06, true});
    all.push_back(
        {"sheet with a displaced back", mesh::make_plane(3, 2), HandMode::kBack, 0.5f, 0.2});
    all.push_back({"relief", card(9, 6, 1), HandMode::kRelief, 1.0f, 0.15});
    all.push_back({"cube bumps", cube(2), HandMode::kBumps, 0.3f, 0.15});
    all.push_back({"cube still", cube(2), HandMode::kStill, 0.3f, 0.11});
    all.push_back({"sphere bumps", sphere(2, 12, 7), HandMode::kBumps, 0.3f, 0.21});
    all.push_back({"sphere footprints", sphere(2, 9, 5), HandMode::kFootprint, 0.3f, 0.17, true});
    all.push_back(
        {"sphere footprints, cut", sphere(2, 9, 5), HandMode::kFootprint, 1.0f, 0.17, true, 0.5});
    all.push_back({"cube footprints, cut", cube(2), HandMode::kFootprint, 1.0f, 0.15, false, 0.9});
    // A length beyond floats is cut to 0.
    all.push_back({"cube footprints, cut from beyond", cube(2), HandMode::kFootprint, 2e38f, 0.15,
                   false, 0.9});
    all.push_back({"torus footprints", torus(2, 0.7, 13, 7), HandMode::kFootprint, 0.2f, 0.3});
    all.push_back(
        {"not finite, bounded", sphere(2, 8, 5), HandMode::kBroken, 0.4f, 0.2, true, 0.25});
    all.push_back({"two cubes at an edge", joined(cube(1), cube(1), {1, 1, 0}), HandMode::kBumps,
                   0.2f, 0.17});
    all.push_back({"two cubes at a vertex", joined(cube(1), cube(1), {1, 1, 1}), HandMode::kBack,
                   0.2f, 0.17});
    all.push_back({"two cubes, the same place", joined(cube(1), cube(1), {0, 0, 0}),
                   HandMode::kBack, 0.2f, 0.3});
    // Nested shells, a wall thinner than a voxel, and displacements that turn inside out.
    const mesh::Mesh hollow = joined(sphere(2, 10, 6), inside_out(sphere(1.4, 9, 5)), {});
    all.push_back(
        {"hollow with a core", joined(hollow, sphere(0.8, 8, 5), {}), HandMode::kBumps, 0.2f, 0.2});
    all.push_back({"shell in a shell", joined(sphere(2, 10, 6), sphere(1.2, 8, 5), {}),
                   HandMode::kBumps, 0.2f, 0.2});
    all.push_back({"thin wall", card(7, 5, 0.06), HandMode::kBack, 0.4f, 0.2});
    all.push_back({"back through the front", card(7, 5, 0.4), HandMode::kBack, -1.0f, 0.2});
    all.push_back({"through the middle", sphere(1, 9, 6), HandMode::kBumps, 2.5f, 0.2});
    // Folded strips: at all edges, at some points of an edge, and of more than one patch.
    all.push_back({"cube cut back", cube(2), HandMode::kOffset, -0.3f, 0.15});
    all.push_back({"cube with steps", cube(2), HandMode::kSteps, -0.5f, 0.15, true});
    all.push_back({"cube with dents", cube(4), HandMode::kDents, -0.5f, 0.21, true});
    all.push_back({"hollow box", joined(cube(3), inside_out(cube(2)), {0.5, 0.5, 0.5}),
                   HandMode::kSteps, 0.3f, 0.2});
    for (uint32_t seed = 1; seed <= 6; ++seed) {
        const HandMode modes[] = {HandMode::kBack, HandMode::kBumps, HandMode::kFootprint};
        const std::string tag = " shaken, seed " + std::to_string(seed);
        all.push_back({"sphere" + tag, shaken(sphere(2, 7, 5), seed, 0.4), modes[seed % 3], 0.4f,
                       0.15 + 0.05 * seed, seed % 2 == 0});
        all.push_back({"cube" + tag, shaken(cube(2), 100 + seed, 0.6), modes[seed % 3], 0.4f,
                       0.1 + 0.02 * seed});
        all.push_back({"cube cut back" + tag, shaken(cube(2), 300 + seed, 0.5), HandMode::kSteps,
                       seed % 2 == 0 ? 0.4f : -0.4f, 0.1 + 0.05 * seed});
        all.push_back({"torus" + tag, shaken(torus(2, 0.7, 7, 5), 200 + seed, 0.2),
                       modes[(seed + 1) % 3], 0.3f, 0.4});
    }
    return all;
}

}  // namespace openfab::testing

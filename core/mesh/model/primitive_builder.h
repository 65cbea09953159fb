// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the makers of primitives have in common.

#include <array>
#include <initializer_list>
#include <string>
#include <utility>

#include "mesh/model/mesh.h"

namespace openfab::mesh {

constexpr int32_t kFacetsAround = 128;  ///< of a full turn

/// Builds a mesh corner by corner; attribute values of equal index are shared.
class PrimitiveBuilder {
  public:
    explicit PrimitiveBuilder(std::string name) {
        mesh_.name = std::move(name);
        mesh_.attributes.resize(3);
        mesh_.attributes[0].name = "uv";
        mesh_.attributes[0].components = 2;
        mesh_.attributes[1].name = "n";
        mesh_.attributes[1].components = 3;
        mesh_.attributes[2].name = "face";
        mesh_.attributes[2].is_int = true;
    }
    int32_t position(const Vec3d& p) {
        mesh_.positions.push_back(p);
        return static_cast<int32_t>(mesh_.positions.size()) - 1;
    }
    int32_t uv(double u, double v) { return value(0, {u, v}); }
    int32_t normal(const Vec3d& n) { return value(1, {n.x, n.y, n.z}); }
    void triangle(const std::array<int32_t, 3>& p, const std::array<int32_t, 3>& uv,
                  const std::array<int32_t, 3>& n, int32_t face) {
        mesh_.triangles.push_back(p);
        mesh_.attributes[0].corners.push_back(uv);
        mesh_.attributes[1].corners.push_back(n);
        mesh_.attributes[2].faces.push_back(face);
    }
    /// Corners counter-clockwise from outside; split along the first corner's diagonal.
    void quad(const std::array<int32_t, 4>& p, const std::array<int32_t, 4>& uv,
              const std::array<int32_t, 4>& n, int32_t face) {
        triangle({p[0], p[1], p[2]}, {uv[0], uv[1], uv[2]}, {n[0], n[1], n[2]}, face);
        triangle({p[0], p[2], p[3]}, {uv[0], uv[2], uv[3]}, {n[0], n[2], n[3]}, face);
    }
    Mesh take() { return std::move(mesh_); }

  private:
    int32_t value(size_t attribute, std::initializer_list<double> numbers) {
        MeshAttribute& a = mesh_.attributes[attribute];
        for (double number : numbers)
            a.values.push_back(static_cast<float>(number));
        return static_cast<int32_t>(a.values.size() / static_cast<size_t>(a.components)) - 1;
    }
    Mesh mesh_;
};

}  // namespace openfab::mesh

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/meshes/meshes.h"

#include <cstdio>
#include <cstdlib>

#include "base/rotation.h"
#include "runtime/part/part_mesh.h"
#include "runtime/part/uniforms.h"

namespace openfab::testing {
namespace {

template <typename T>
T need(Result<T> result) {
    if (!result) {
        std::fprintf(stderr, "test part: %s\n", result.error().text().c_str());
        std::abort();
    }
    return std::move(*result);
}

mesh::MeshAttribute attribute(const char* name, int32_t components) {
    mesh::MeshAttribute out;
    out.name = name;
    out.components = components;
    return out;
}

/// A grid of (columns + 1) x (rows + 1) uv values and `columns` x `rows` (closed where periodic)
/// vertices.
struct Grid2 {
    int32_t columns = 0;
    int32_t uv(int32_t row, int32_t column) const { return row * (columns + 1) + column; }
};

void add_uv(mesh::MeshAttribute* uv, int32_t columns, int32_t rows) {
    for (int32_t row = 0; row <= rows; ++row) {
        for (int32_t column = 0; column <= columns; ++column) {
            uv->values.push_back(static_cast<float>(column) / static_cast<float>(columns));
            uv->values.push_back(static_cast<float>(row) / static_cast<float>(rows));
        }
    }
}

void add_normal(mesh::MeshAttribute* n, const Vec3d& v) {
    for (int axis = 0; axis < 3; ++axis)
        n->values.push_back(static_cast<float>(v[axis]));
}

void add_triangle(mesh::Mesh* mesh, const std::array<int32_t, 3>& p,
                  const std::array<int32_t, 3>& uv) {
    mesh->triangles.push_back(p);
    mesh->attributes[0].corners.push_back(uv);
    mesh->attributes[1].corners.push_back(p);  // normals are numbered as positions
    mesh->attributes[2].faces.push_back(0);
}

mesh::Mesh fresh(const char* name) {
    mesh::Mesh mesh;
    mesh.name = name;
    mesh.attributes = {attribute("uv", 2), attribute("n", 3), attribute("face", 1)};
    mesh.attributes[2].is_int = true;
    return mesh;
}

}  // namespace

mesh::Mesh cube(double side_mm) {
    mesh::Mesh mesh = mesh::make_box({side_mm, side_mm, side_mm});
    mesh.name = "cube";
    for (Vec3d& p : mesh.positions)
        p = p + Vec3d{side_mm / 2, side_mm / 2, 0};
    return mesh;
}

mesh::Mesh card(double width_mm, double height_mm, double thickness_mm) {
    mesh::Mesh mesh = mesh::make_box({width_mm, height_mm, thickness_mm});
    mesh.name = "card";
    return mesh;
}

mesh::Mesh sphere(double radius_mm, int32_t around, int32_t stacks) {
    mesh::Mesh mesh = fresh("sphere");
    add_uv(&mesh.attributes[0], around, stacks);
    const auto add = [&](const Vec3d& n) {
        mesh.positions.push_back(n * radius_mm);
        add_normal(&mesh.attributes[1], n);
    };
    add({0, 0, -1});
    for (int32_t stack = 1; stack < stacks; ++stack) {
        const SinCos lat = sin_cos_degrees(-90.0 + 180.0 * stack / stacks);
        for (int32_t i = 0; i < around; ++i) {
            const SinCos lon = sin_cos_degrees(360.0 * i / around);
            add({lat.cos * lon.cos, lat.cos * lon.sin, lat.sin});
        }
    }
    add({0, 0, 1});
    const int32_t north = static_cast<int32_t>(mesh.positions.size()) - 1;
    const Grid2 grid{around};
    const auto at = [&](int32_t stack, int32_t i) { return 1 + (stack - 1) * around + i % around; };
    for (int32_t i = 0; i < around; ++i) {
        add_triangle(&mesh, {0, at(1, i + 1), at(1, i)},
                     {grid.uv(0, i), grid.uv(1, i + 1), grid.uv(1, i)});
        for (int32_t s = 1; s + 1 < stacks; ++s) {
            add_triangle(&mesh, {at(s, i), at(s, i + 1), at(s + 1, i + 1)},
                         {grid.uv(s, i), grid.uv(s, i + 1), grid.uv(s + 1, i + 1)});
            add_triangle(&mesh, {at(s, i), at(s + 1, i + 1), at(s + 1, i)},
                         {grid.uv(s, i), grid.uv(s + 1, i + 1), grid.uv(s + 1, i)});
        }
        add_triangle(&mesh, {at(stacks - 1, i), at(stacks - 1, i + 1), north},
                     {grid.uv(stacks - 1, i), grid.uv(stacks - 1, i + 1), grid.uv(stacks, i)});
    }
    return mesh;
}

mesh::Mesh torus(double major_radius_mm, double minor_radius_mm, int32_t around, int32_t across) {
    mesh::Mesh mesh = fresh("torus");
    add_uv(&mesh.attributes[0], across, around);
    for (int32_t i = 0; i < around; ++i) {
        const SinCos a = sin_cos_degrees(360.0 * i / around);
        for (int32_t j = 0; j < across; ++j) {
            const SinCos b = sin_cos_degrees(360.0 * j / across);
            const Vec3d n{a.cos * b.cos, a.sin * b.cos, b.sin};
            mesh.positions.push_back(Vec3d{a.cos, a.sin, 0} * major_radius_mm +
                                     n * minor_radius_mm);
            add_normal(&mesh.attributes[1], n);
        }
    }
    const Grid2 grid{across};
    const auto at = [&](int32_t i, int32_t j) { return (i % around) * across + j % across; };
    for (int32_t i = 0; i < around; ++i) {
        for (int32_t j = 0; j < across; ++j) {
            add_triangle(&mesh, {at(i, j), at(i + 1, j), at(i + 1, j + 1)},
                         {grid.uv(i, j), grid.uv(i + 1, j), grid.uv(i + 1, j + 1)});
            add_triangle(&mesh, {at(i, j), at(i + 1, j + 1), at(i, j + 1)},
                         {grid.uv(i, j), grid.uv(i + 1, j + 1), grid.uv(i, j + 1)});
        }
    }
    return mesh;
}

mesh::Mesh without(mesh::Mesh mesh, const std::string& attribute) {
    std::erase_if(mesh.attributes,
                  [&](const mesh::MeshAttribute& a) { return a.name == attribute; });
    return mesh;
}

double signed_volume(const mesh::Mesh& mesh) {
    double sum = 0;
    for (const std::array<int32_t, 3>& t : mesh.triangles) {
        const auto& p = mesh.positions;
        sum += dot(p[t[0]], cross(p[t[1]], p[t[2]]));
    }
    return sum / 6;
}

part::Part make_part(const openfab_fablet& fablet, const mesh::Mesh& mesh,
                     const PartOptions& options) {
    const PolarFactors polar = need(polar_factors(options.transform.m));
    part::Part part;
    part.name = mesh.name;
    part.fablet = &fablet;
    part.mesh = need(part::make_part_mesh(mesh, fablet, polar.s));
    part.local_to_build =
        part::part_local_to_build(polar, options.transform.t, part.mesh->center_part_mm);
    part.uniform_values = options.uniform_values;
    if (part.uniform_values.empty()) {
        part.uniform_values.assign(static_cast<size_t>(fablet.uniform_value_count), 0);
        for (int32_t i = 0; i < fablet.uniform_count; ++i) {
            const openfab_uniform& u = fablet.uniforms[i];
            if (u.kind != OPENFAB_UNIFORM_VALUE || u.default_bits == nullptr) continue;
            for (int32_t c = 0; c < u.components * u.array_length; ++c) {
                part.uniform_values[static_cast<size_t>(u.first_index + c)] = u.default_bits[c];
            }
        }
    }
    part::derive_uniforms(fablet, &part.uniform_values);
    part.textures = options.textures;
    part.slot_material = options.slot_material;
    if (part.slot_material.empty()) {
        uint8_t code = 0;
        for (int32_t slot = 0; slot < fablet.slot_count; ++slot) {
            part.slot_material.push_back(slot == fablet.void_slot ? uint8_t{0} : ++code);
        }
    }
    part.max_displacement_mm = static_cast<float>(options.max_displacement_mm);
    part.priority = options.priority;
    part.instance = options.instance;
    part.objects = options.objects;
    return part;
}

const openfab_fablet& empty_fablet() {
    static const openfab_fablet fablet = [] {
        openfab_fablet f{};
        f.name = "Empty";
        f.source_name = "empty.fl";
        f.void_slot = -1;
        return f;
    }();
    return fablet;
}

part::Grid grid_around(const part::Part& part, const Vec3d& pitch_mm, double margin_mm) {
    Box3d box;
    for (const Vec3d& p : part.mesh->positions)
        box.add(part.local_to_build.apply(p));
    part::Grid grid;
    grid.pitch_mm = pitch_mm;
    for (int axis = 0; axis < 3; ++axis) {
        const double lo = std::floor((box.lo[axis] - margin_mm) / pitch_mm[axis]);
        const double hi = std::ceil((box.hi[axis] + margin_mm) / pitch_mm[axis]);
        grid.origin_mm[axis] = lo * pitch_mm[axis];
        grid.size[axis] = static_cast<int32_t>(hi - lo);
    }
    return grid;
}

}  // namespace openfab::testing

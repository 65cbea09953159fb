// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/part/part_mesh.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "runtime/part/messages.h"

namespace openfab::part {
namespace {

using Matrix = std::array<double, 9>;

Vec3d apply(const Matrix& m, const Vec3d& p) {
    return Affine3d{m, {}}.apply_vector(p);
}

Vec3d geometric_normal(const PartMesh& part, const std::array<int32_t, 3>& triangle) {
    const Vec3d& a = part.positions[triangle[0]];
    const Vec3d& b = part.positions[triangle[1]];
    const Vec3d& c = part.positions[triangle[2]];
    const Vec3d n = cross(b - a, c - a);
    const double len = length(n);
    // A triangle without area has no normal; any unit vector serves, as it has no micropolygons of
    // its own.
    return len > 0 && std::isfinite(len) ? n * (1 / len) : Vec3d{0, 0, 1};
}

void fill_normals(const mesh::Mesh& mesh, const Matrix& s, PartMesh* part) {
    const Matrix normal_matrix = inverse_transposed(s);
    const mesh::MeshAttribute* attribute = mesh.find("n");
    if (attribute != nullptr && (attribute->is_int || attribute->components != 3))
        attribute = nullptr;
    part->corner_normals.resize(mesh.triangles.size() * 3);
    const auto fill = [&](size_t t) {
        const Vec3d flat = geometric_normal(*part, mesh.triangles[t]);
        for (size_t corner = 0; corner < 3; ++corner) {
            Vec3d normal = flat;
            if (attribute != nullptr) {
                const float* v =
                    &attribute->values[static_cast<size_t>(attribute->corners[t][corner]) * 3];
                const Vec3d n = apply(normal_matrix, {v[0], v[1], v[2]});
                const double len = length(n);
                if (len > 0 && std::isfinite(len)) normal = n * (1 / len);
            }
            part->corner_normals[t * 3 + corner] = vec_cast<float>(normal);
        }
    };
    tbb::parallel_for(tbb::blocked_range<size_t>(0, mesh.triangles.size(), 16384),
                      [&](const auto& range) {
                          for (size_t t = range.begin(); t < range.end(); ++t)
                              fill(t);
                      });
}

std::string type_of(const mesh::MeshAttribute& attribute) {
    const char* scalar = attribute.is_int ? "int" : "float";
    return attribute.components == 1 ? scalar : fmt::format("{}{}", scalar, attribute.components);
}

std::string list_of_attributes(const mesh::Mesh& mesh) {
    if (mesh.attributes.empty()) return messages::kNoAttributes;
    std::string text = messages::kAttributes;
    for (size_t i = 0; i < mesh.attributes.size(); ++i) {
        text += fmt::format("{}`{}` ({})", i == 0 ? "" : ", ", mesh.attributes[i].name,
                            type_of(mesh.attributes[i]));
    }
    return text;
}

void fill_default(const openfab_varying& varying, size_t triangles, PartAttribute* out) {
    const auto n = static_cast<size_t>(varying.components);
    const bool is_float = varying.scalar == OPENFAB_FLOAT;
    const size_t copies = is_float ? triangles * 3 : triangles;
    for (size_t i = 0; i < copies; ++i) {
        for (size_t c = 0; c < n; ++c) {
            if (is_float) {
                out->corner_values.push_back(std::bit_cast<float>(varying.default_bits[c]));
            } else {
                out->face_values.push_back(varying.default_bits[c]);
            }
        }
    }
}

void copy_attribute(const mesh::MeshAttribute& attribute, PartAttribute* out) {
    const auto n = static_cast<size_t>(attribute.components);
    if (attribute.is_int) {
        for (int32_t value : attribute.faces) {
            out->face_values.push_back(out->scalar == OPENFAB_BOOL ? (value != 0 ? 1u : 0u)
                                                                   : static_cast<uint32_t>(value));
        }
        return;
    }
    out->corner_values.reserve(attribute.corners.size() * 3 * n);
    for (const std::array<int32_t, 3>& corners : attribute.corners) {
        for (int32_t corner : corners) {
            const float* value = &attribute.values[static_cast<size_t>(corner) * n];
            out->corner_values.insert(out->corner_values.end(), value, value + n);
        }
    }
}

Result<PartAttribute> resolve(const mesh::Mesh& mesh, const openfab_fablet& fablet,
                              const openfab_varying& varying) {
    PartAttribute out;
    out.scalar = varying.scalar;
    out.components = varying.components;
    const mesh::MeshAttribute* attribute = mesh.find(varying.name);
    if (attribute == nullptr) {
        if (varying.default_bits != nullptr) {
            fill_default(varying, mesh.triangles.size(), &out);
            return out;
        }
        return user_error(fmt::format(messages::kNoSuchAttribute, mesh.name, varying.name,
                                      fablet.name, varying.type_name, varying.name),
                          list_of_attributes(mesh));
    }
    if (attribute->is_int != (varying.scalar != OPENFAB_FLOAT) ||
        attribute->components != varying.components) {
        return user_error(
            fmt::format(messages::kAttributeType, varying.name, mesh.name, type_of(*attribute),
                        fablet.name, varying.type_name, varying.name),
            messages::kAttributeTypeHelp);
    }
    copy_attribute(*attribute, &out);
    return out;
}

}  // namespace

Result<std::shared_ptr<const PartMesh>> make_part_mesh(const mesh::Mesh& mesh,
                                                       const openfab_fablet& fablet,
                                                       const Matrix& s) {
    auto part = std::make_shared<PartMesh>();
    Box3d box;
    part->positions.reserve(mesh.positions.size());
    for (const Vec3d& p : mesh.positions) {
        part->positions.push_back(apply(s, p));
        box.add(part->positions.back());
    }
    part->center_part_mm = box.center();
    for (Vec3d& p : part->positions)
        p = p - part->center_part_mm;
    part->triangles = mesh.triangles;
    for (int32_t i = 0; i < fablet.surface_input_count; ++i) {
        Result<PartAttribute> input = resolve(mesh, fablet, fablet.surface_inputs[i]);
        if (!input) return input.error();
        part->inputs.push_back(std::move(*input));
    }
    for (int32_t i = 0; i < fablet.nearest_count; ++i) {
        const openfab_varying& varying = fablet.nearest[i];
        if (varying.source >= 0) {
            part->nearest_attributes.push_back({varying.scalar, varying.components, {}, {}});
            continue;
        }
        Result<PartAttribute> input = resolve(mesh, fablet, varying);
        if (!input) return input.error();
        part->nearest_attributes.push_back(std::move(*input));
    }
    fill_normals(mesh, s, part.get());
    const mesh::MeshAttribute* uv = mesh.find("uv");
    if (uv != nullptr && !uv->is_int && uv->components == 2) {
        PartAttribute values;
        copy_attribute(*uv, &values);
        part->corner_uv = std::move(values.corner_values);
    }
    return std::shared_ptr<const PartMesh>(std::move(part));
}

bool is_plain(const openfab_fablet& fablet) {
    return fablet.has_surface == 0 && fablet.surface_input_count == 0 && fablet.nearest_count == 0;
}

int64_t part_mesh_bytes(const mesh::Mesh& mesh, const openfab_fablet& fablet) {
    int64_t corner_values = 3 + 2;  // normals and uv
    const auto add = [&](const openfab_varying& varying) {
        // While a default is filled in, its growing list is copied.
        corner_values += 3 * varying.components;
    };
    std::for_each(fablet.surface_inputs, fablet.surface_inputs + fablet.surface_input_count, add);
    std::for_each(fablet.nearest, fablet.nearest + fablet.nearest_count, add);
    const auto triangles = static_cast<int64_t>(mesh.triangles.size());
    return static_cast<int64_t>(mesh.positions.size() * sizeof(Vec3d)) +
           triangles * static_cast<int64_t>(sizeof mesh.triangles[0]) +
           triangles * corner_values * 3 * static_cast<int64_t>(sizeof(float));
}

Affine3d part_local_to_build(const PolarFactors& polar, const Vec3d& translation_mm,
                             const Vec3d& center_part_mm) {
    return {polar.r, apply(polar.r, center_part_mm) + translation_mm};
}

}  // namespace openfab::part

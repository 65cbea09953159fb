// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/shape/shape_mesh.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <unordered_map>
#include <vector>

#include "base/keyed_hash.h"
#include "runtime/solid/shape/shape_field.h"

namespace openfab::solid {

namespace {

// Cells along the longest side of the box, where the pitch allows it.
constexpr double kCells = 200;
// Micro-edges along a cell.
constexpr double kMostEdges = 8;
// Of a cell, for the differences that normals are made of.
constexpr float kStep = 0.125f;

double cell_of(const part::PartMesh& box, double micro_edge_mm) {
    Box3d size;
    for (const Vec3d& p : box.positions)
        size.add(p);
    return std::max(micro_edge_mm,
                    std::min(kMostEdges * micro_edge_mm, size.longest_side() / kCells));
}

struct Bits {
    size_t operator()(const Vec3f& p) const {
        uint64_t hash = keyed.start();
        for (int a = 0; a < 3; ++a)
            hash = keyed.mix(hash, std::bit_cast<uint32_t>(p[a]));
        return static_cast<size_t>(hash);
    }
    KeyedHash keyed;
};

/// The micropolygons of all blocks, with vertices that are shared.
struct Welded {
    ShapePoints points;
    std::vector<std::array<int32_t, 3>> triangles;
};

Welded weld(const ShapeField& field, const std::atomic<bool>* stop) {
    const std::vector<Vec3i> blocks = field.find_blocks(stop);
    std::vector<surface::MicroMesh> meshes(blocks.size());
    tbb::parallel_for(size_t{0}, blocks.size(), [&](size_t i) {
        if (stop == nullptr || !stop->load(std::memory_order_relaxed))
            field.dice(blocks[i], &meshes[i]);
    });
    Welded out;
    std::unordered_map<Vec3f, int32_t, Bits> known;
    for (const surface::MicroMesh& mesh : meshes) {
        const auto number = [&](int32_t v) {
            const Vec3f& p = mesh.positions[static_cast<size_t>(v)];
            const auto [at, added] = known.try_emplace(p, static_cast<int32_t>(known.size()));
            if (added) out.points.push_back(p);
            return at->second;
        };
        for (const auto& t : mesh.triangles)
            out.triangles.push_back({number(t[0]), number(t[1]), number(t[2])});
    }
    return out;
}

/// Central differences; 0 where the value has no slope.
std::vector<Vec3f> normals(const ShapePoints& points, float step, const Box3f& box,
                           ShapeCalls* calls, abi::KernelStatus* status) {
    std::vector<Vec3f> out(points.size());
    std::vector<float> low, high;
    ShapePoints moved = points;
    for (size_t a = 0; a < 3; ++a) {
        const auto move = [&](float by, std::vector<float>* values) {
            for (size_t i = 0; i < points.size(); ++i)
                moved.at[a][i] = std::clamp(points.at[a][i] + by, box.lo[static_cast<int>(a)],
                                            box.hi[static_cast<int>(a)]);
            if (status->ok()) *status = calls->values(moved, values);
        };
        move(-step, &low);
        move(step, &high);
        moved.at[a] = points.at[a];
        if (!status->ok()) return out;
        const float least = box.lo[static_cast<int>(a)], most = box.hi[static_cast<int>(a)];
        for (size_t i = 0; i < points.size(); ++i) {
            const float at = points.at[a][i];
            float slope = high[i] - low[i];
            // Nothing is evaluated outside of the box.
            if (at - step < least || at + step > most)
                slope *= 2 * step / (std::min(at + step, most) - std::max(at - step, least));
            out[i][static_cast<int>(a)] = slope;
        }
    }
    for (Vec3f& n : out) {
        const float size = length(n);
        n = std::isfinite(size) && size > 0 ? n * (1 / size) : Vec3f{0, 0, 0};
    }
    return out;
}

/// The outputs of a stage at the vertices.
class Outputs {
  public:
    Outputs(const openfab_shape& shape, ShapeCalls* calls, const Welded& welded)
        : shape_(shape), calls_(calls), welded_(welded) {}

    abi::KernelStatus evaluate() {
        return shape_.output_count == 0 ? abi::KernelStatus{}
                                        : calls_->attributes(welded_.points, &values_);
    }
    /// Sets the attribute of a name, if the stage has it; else spreads its default, which the box has.
    void fill(const char* name, const part::PartAttribute& of_box, part::PartAttribute* out) const {
        out->scalar = of_box.scalar;
        out->components = of_box.components;
        const auto components = static_cast<size_t>(of_box.components);
        const int32_t output = find(name);
        for (const auto& triangle : welded_.triangles) {
            const bool floats = of_box.scalar == OPENFAB_FLOAT;
            for (size_t k = 0; k < (floats ? 3u : 1u); ++k) {
                for (size_t c = 0; c < components; ++c) {
                    uint32_t bits = 0;
                    if (output >= 0) {
                        bits = values_[calls_->first_component(output) + c]
                                      [static_cast<size_t>(triangle[k])];
                    } else {
                        bits = floats ? std::bit_cast<uint32_t>(of_box.corner_values[c])
                                      : of_box.face_values[c];
                    }
                    if (floats) {
                        out->corner_values.push_back(std::bit_cast<float>(bits));
                    } else {
                        out->face_values.push_back(bits);
                    }
                }
            }
        }
    }
    int32_t find(const char* name) const {
        for (int32_t i = 0; i < shape_.output_count; ++i) {
            if (std::strcmp(shape_.outputs[i].name, name) == 0) return i;
        }
        return -1;
    }

  private:
    const openfab_shape& shape_;
    ShapeCalls* calls_;
    const Welded& welded_;
    std::vector<std::vector<uint32_t>> values_;
};

Vec3f face_normal(const std::array<Vec3f, 3>& corners) {
    const Vec3f n = cross(corners[1] - corners[0], corners[2] - corners[0]);
    const float size = length(n);
    return size > 0 ? n * (1 / size) : Vec3f{0, 0, 1};
}

}  // namespace

Result<std::shared_ptr<const part::PartMesh>> mesh_of_shape(const part::Part& part,
                                                            const surface::SurfaceOptions& options,
                                                            const Bodies& bodies) {
    const openfab_fablet& fablet = *part.fablet;
    const part::PartMesh& box = *part.mesh;
    const double cell = cell_of(box, options.micro_edge_mm);
    const part::ShapeStage& stage = *std::get<part::ShapeGeometry>(part.geometry).stage;
    const ShapeField field(stage, bodies, fablet, cell, options.isa);
    if (Result<void> fine = field.check(); !fine) return fine.error();
    const Welded welded = weld(field, options.stop);
    ShapeCalls* calls = field.take();
    abi::KernelStatus status;
    const std::vector<Vec3f> slopes =
        normals(welded.points, kStep * static_cast<float>(cell), field.bounds(), calls, &status);
    Outputs outputs(*stage.fablet->shape, calls, welded);
    if (status.ok()) status = outputs.evaluate();
    auto out = std::make_shared<part::PartMesh>();
    if (status.ok()) {
        out->center_part_mm = box.center_part_mm;
        for (size_t i = 0; i < welded.points.size(); ++i)
            out->positions.push_back(vec_cast<double>(welded.points.point(i)));
        out->triangles = welded.triangles;
        for (const auto& t : welded.triangles) {
            std::array<Vec3f, 3> corners;
            for (size_t k = 0; k < 3; ++k)
                corners[k] = welded.points.point(static_cast<size_t>(t[k]));
            for (const int32_t v : t) {
                const Vec3f& n = slopes[static_cast<size_t>(v)];
                out->corner_normals.push_back(n == Vec3f{0, 0, 0} ? face_normal(corners) : n);
            }
        }
        out->inputs.resize(box.inputs.size());
        for (size_t i = 0; i < box.inputs.size(); ++i)
            outputs.fill(fablet.surface_inputs[i].name, box.inputs[i], &out->inputs[i]);
        out->nearest_attributes.resize(box.nearest_attributes.size());
        for (size_t i = 0; i < box.nearest_attributes.size(); ++i) {
            if (fablet.nearest[i].source >= 0) {
                out->nearest_attributes[i] = box.nearest_attributes[i];
            } else {
                outputs.fill(fablet.nearest[i].name, box.nearest_attributes[i],
                             &out->nearest_attributes[i]);
            }
        }
        if (!box.corner_uv.empty()) {
            part::PartAttribute uv;
            outputs.fill("uv", {OPENFAB_FLOAT, 2, {0, 0}, {}}, &uv);
            out->corner_uv = std::move(uv.corner_values);
        }
    } else {
        field.note(status);
    }
    field.give(calls);
    if (Result<void> fine = field.status(); !fine) return fine.error();
    return std::shared_ptr<const part::PartMesh>(std::move(out));
}

}  // namespace openfab::solid

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Shapes by hand-written kernels.

#include <HalideRuntime.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "mesh/model/primitives.h"
#include "runtime/part/part_mesh.h"
#include "runtime/part/shape_stage.h"
#include "runtime/solid/kinds/kinds.h"
#include "runtime/solid/shape/shape_solid.h"

namespace openfab::solid {

using Function = float (*)(const Vec3f&);

inline float ball(const Vec3f& p) {
    return length(p) - 4;
}
inline float ring(const Vec3f& p) {
    const float d = std::sqrt(p.x * p.x + p.y * p.y) - 4;
    return std::sqrt(d * d + p.z * p.z) - 1.5f;
}
inline float brick(const Vec3f& p) {
    const Vec3f q{std::fabs(p.x) - 3, std::fabs(p.y) - 4, std::fabs(p.z) - 2};
    const Vec3f out{std::max(q.x, 0.0f), std::max(q.y, 0.0f), std::max(q.z, 0.0f)};
    return length(out) + std::min(std::max({q.x, q.y, q.z}), 0.0f);
}
inline float pill(const Vec3f& p) {
    const float z = p.z - std::clamp(p.z, -2.0f, 2.0f);
    return length(Vec3f{p.x, p.y, z}) - 2;
}
/// A cone of radius 3 at z = -2 and height 4: exact in and out.
inline float cone(const Vec3f& p) {
    const float q = std::sqrt(p.x * p.x + p.y * p.y), z = p.z + 2;
    const float slant = (4 * q + 3 * z - 12) / 5;
    const float t = std::clamp((3 * (3 - q) + 4 * z) / 25, 0.0f, 1.0f);
    const float to_side = std::hypot(q - 3 * (1 - t), z - 4 * t);
    const float to_base = q <= 3 ? std::fabs(z) : std::hypot(q - 3, z);
    const bool inside = slant < 0 && z > 0;
    return inside ? -std::min(to_side, to_base) : std::min(to_side, to_base);
}
inline float nothing(const Vec3f& /*p*/) {
    return 1;
}
inline float wrong(const Vec3f& p) {
    return std::sqrt(p.x + 1) + length(p) - 4;
}

inline const float* in(void* buffer) {
    return reinterpret_cast<const float*>(static_cast<halide_buffer_t*>(buffer)->host);
}
inline float* out(void* buffer) {
    return reinterpret_cast<float*>(static_cast<halide_buffer_t*>(buffer)->host);
}
inline int32_t count(void* buffer) {
    return static_cast<halide_buffer_t*>(buffer)->dim[0].extent;
}

template <Function kF>
int values(void** args) {
    for (int32_t i = 0; i < count(args[3]); ++i)
        out(args[3])[i] = kF({in(args[0])[i], in(args[1])[i], in(args[2])[i]});
    return 0;
}
/// The functions change by no more than their arguments do.
template <Function kF>
int bounds(void** args) {
    for (int32_t i = 0; i < count(args[6]); ++i) {
        Vec3f lo, hi;
        for (int a = 0; a < 3; ++a)
            lo[a] = in(args[a])[i], hi[a] = in(args[3 + a])[i];
        const float middle = kF((lo + hi) * 0.5f), reach = length(hi - lo) * 0.5001f + 1e-4f;
        out(args[6])[i] = middle - reach;
        out(args[7])[i] = middle + reach;
    }
    return 0;
}
/// The output `height`: z.
inline int heights(void** args) {
    for (int32_t i = 0; i < count(args[1]); ++i)
        out(args[1])[i] = in(args[0])[i];
    return 0;
}

inline const openfab_arg kValueArgs[] = {{OPENFAB_ARG_SHAPE_POINT, OPENFAB_FLOAT, 0, 0},
                                         {OPENFAB_ARG_SHAPE_POINT, OPENFAB_FLOAT, 1, 0},
                                         {OPENFAB_ARG_SHAPE_POINT, OPENFAB_FLOAT, 2, 0},
                                         {OPENFAB_ARG_SHAPE_VALUE, OPENFAB_FLOAT, 0, 0}};
inline const openfab_arg kBoundArgs[] = {{OPENFAB_ARG_SHAPE_POINT_LO, OPENFAB_FLOAT, 0, 0},
                                         {OPENFAB_ARG_SHAPE_POINT_LO, OPENFAB_FLOAT, 1, 0},
                                         {OPENFAB_ARG_SHAPE_POINT_LO, OPENFAB_FLOAT, 2, 0},
                                         {OPENFAB_ARG_SHAPE_POINT_HI, OPENFAB_FLOAT, 0, 0},
                                         {OPENFAB_ARG_SHAPE_POINT_HI, OPENFAB_FLOAT, 1, 0},
                                         {OPENFAB_ARG_SHAPE_POINT_HI, OPENFAB_FLOAT, 2, 0},
                                         {OPENFAB_ARG_SHAPE_VALUE_LO, OPENFAB_FLOAT, 0, 0},
                                         {OPENFAB_ARG_SHAPE_VALUE_HI, OPENFAB_FLOAT, 0, 0}};
inline const openfab_arg kOutputArgs[] = {{OPENFAB_ARG_SHAPE_POINT, OPENFAB_FLOAT, 2, 0},
                                          {OPENFAB_ARG_SHAPE_OUT, OPENFAB_FLOAT, 0, 0}};
inline const openfab_varying kOutputs[] = {{"height", "float", OPENFAB_FLOAT, 1, -1, nullptr}};

/// A part whose geometry is a function, in a box of `size`.
struct Made {
    openfab_shape shape{};
    openfab_fablet fablet{};
    part::Part part;
    Function function;

    Made(Function f, openfab_kernel_fn value, openfab_kernel_fn bound, const Vec3d& size,
         bool is_distance)
        : function(f) {
        shape.is_distance = is_distance ? 1 : 0;
        shape.output_count = 1;
        shape.outputs = kOutputs;
        shape.values = {{value, value, value}, 4, kValueArgs, 0};
        shape.bounds = {{bound, bound, bound}, 8, kBoundArgs, 0};
        shape.attributes = {{heights, heights, heights}, 2, kOutputArgs, 0};
        fablet.abi_version = OPENFAB_ABI_VERSION;
        fablet.name = "Made";
        fablet.nearest_count = 1;
        fablet.nearest = kOutputs;
        fablet.shape = &shape;
        mesh::Mesh box = mesh::make_box(size);
        for (Vec3d& p : box.positions)
            p.z -= size.z / 2;
        auto stage = std::make_shared<part::ShapeStage>();
        openfab_fablet plain{};
        plain.name = "plain";
        stage->name = "thing";
        stage->fablet = &fablet;
        stage->mesh = *part::make_part_mesh(box, plain, {1, 0, 0, 0, 1, 0, 0, 0, 1});
        part = *stage;
        part.geometry = part::ShapeGeometry{std::move(stage)};
        part.local_to_build.m = {0.40923325984932796, -0.9119847905251406, 0.02849352354321616,
                                 0.708653140405184,   0.2980114870440326,  -0.6395309845376336,
                                 0.5747511336456527,  0.28190937451709513, 0.76823709812298};
        // No face lies along voxels, so that counting them measures the volume.
    }
    Made(const Made&) = delete;
    Made& operator=(const Made&) = delete;
};

template <Function kF>
std::unique_ptr<Made> make(const Vec3d& size, bool is_distance = false) {
    return std::make_unique<Made>(kF, values<kF>, bounds<kF>, size, is_distance);
}

inline surface::SurfaceOptions options_of(double pitch) {
    surface::SurfaceOptions options;
    options.micro_edge_mm = pitch;
    return options;
}

inline std::shared_ptr<Solid> solid_of(const Made& made, double pitch) {
    EXPECT_EQ(&kind_of(made.part), &kShapeKind);
    Result<std::shared_ptr<Solid>> solid = make_solid(made.part, options_of(pitch));
    EXPECT_TRUE(solid) << solid.error().text();
    return solid ? *solid : nullptr;
}

/// The grid that a print has of it.
inline part::Grid grid_of(const Solid& solid, const Made& made, double pitch) {
    const Box3d box = solid.exact_box(made.part.local_to_build);
    part::Grid grid;
    grid.pitch_mm = {pitch, pitch, pitch};
    for (int a = 0; a < 3; ++a) {
        const double lo = std::floor(box.lo[a] / pitch), hi = std::ceil(box.hi[a] / pitch);
        grid.origin_mm[a] = lo * pitch;
        grid.size[a] = static_cast<int32_t>(hi - lo);
    }
    return grid;
}

}  // namespace openfab::solid

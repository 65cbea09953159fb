// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/part/part.h"

#include <limits>
#include <variant>

#include "runtime/part/shape_stage.h"

namespace openfab::part {

namespace {

bool is_own_shape(const Part& part) {
    const auto* shape = std::get_if<ShapeGeometry>(&part.geometry);
    return shape != nullptr && shape->stage->has_values_of_part;
}

}  // namespace

const void* shared_geometry(const Part& part) {
    if (part.stretched != nullptr) return part.stretched.get();
    return std::visit(
        [&](const auto& of) -> const void* {
            if constexpr (requires { of.shared(); }) return of.shared();
            return part.mesh.get();
        },
        part.geometry);
}

Affine3d local_to_voxel(const Part& part, const Grid& grid) {
    const Affine3d& build = part.local_to_build;
    Affine3d out;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) {
            out.m[static_cast<size_t>(row * 3 + column)] =
                build.m[static_cast<size_t>(row * 3 + column)] / grid.pitch_mm[row];
        }
        out.t[row] = (build.t[row] - grid.origin_mm[row]) / grid.pitch_mm[row];
    }
    return out;
}

Affine3d local_to_local(const Part& from, const Part& to) {
    const Affine3d &a = from.local_to_build, &b = to.local_to_build;
    // The inverse of an orthogonal matrix is its transpose.
    Affine3d back;
    for (size_t row = 0; row < 3; ++row) {
        for (size_t column = 0; column < 3; ++column)
            back.m[row * 3 + column] = b.m[column * 3 + row];
    }
    Affine3d out;
    for (int column = 0; column < 3; ++column) {
        const auto c = static_cast<size_t>(column);
        const Vec3d image = back.apply_vector({a.m[c], a.m[3 + c], a.m[6 + c]});
        for (int row = 0; row < 3; ++row)
            out.m[static_cast<size_t>(row * 3 + column)] = image[row];
    }
    out.t = back.apply_vector(a.t - b.t);
    return out;
}

Vec3i part_base_voxel(const Part& part, const Grid& grid) {
    Vec3i base;
    for (int axis = 0; axis < 3; ++axis) {
        base[axis] = static_cast<int32_t>(
            std::floor((part.local_to_build.t[axis] - grid.origin_mm[axis]) / grid.pitch_mm[axis]));
    }
    return base;
}

std::array<float, OPENFAB_FRAME_COUNT> make_frame(const Part& part, const Grid& grid) {
    const std::array<double, 9>& r = part.local_to_build.m;
    const Vec3i base = part_base_voxel(part, grid);
    // Build position of the lowest corner of the base voxel, and the same seen from the part's
    // centre.
    Vec3d corner;
    Vec3d from_center;
    for (int axis = 0; axis < 3; ++axis) {
        corner[axis] = grid.origin_mm[axis] + static_cast<double>(base[axis]) * grid.pitch_mm[axis];
        from_center[axis] = corner[axis] - part.local_to_build.t[axis];
    }
    std::array<float, OPENFAB_FRAME_COUNT> frame{};
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<size_t>(axis);
        // The inverse of an orthogonal R is its transpose: build axis i seen from the part is row i
        // of R.
        frame[OPENFAB_FRAME_STEP_I + a] = static_cast<float>(r[0 + a] * grid.pitch_mm.x);
        frame[OPENFAB_FRAME_STEP_J + a] = static_cast<float>(r[3 + a] * grid.pitch_mm.y);
        frame[OPENFAB_FRAME_STEP_K + a] = static_cast<float>(r[6 + a] * grid.pitch_mm.z);
        frame[OPENFAB_FRAME_ORIGIN + a] = static_cast<float>(
            r[0 + a] * from_center.x + r[3 + a] * from_center.y + r[6 + a] * from_center.z);
        frame[OPENFAB_FRAME_CENTER + a] = static_cast<float>(part.mesh->center_part_mm[axis]);
        frame[OPENFAB_FRAME_VOXEL_SIZE + a] = static_cast<float>(grid.pitch_mm[axis]);
        frame[OPENFAB_FRAME_BUILD_ORIGIN + a] = static_cast<float>(corner[axis]);
    }
    frame[OPENFAB_FRAME_MAX_DISPLACEMENT] = part.max_displacement_mm;
    if (!is_own_shape(part)) return frame;
    const ShapeStage& stage = *std::get<ShapeGeometry>(part.geometry).stage;
    const bool along_axes = part.stretched == nullptr;
    constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
    for (size_t a = 0; a < 3; ++a) {
        frame[OPENFAB_FRAME_SHAPE_SHRINK + a] =
            along_axes ? static_cast<float>(1 / stage.stretch[a]) : kUnknown;
    }
    frame[OPENFAB_FRAME_SHAPE_DISTANCE] = along_axes ? declared_scale(stage) : kUnknown;
    return frame;
}

}  // namespace openfab::part

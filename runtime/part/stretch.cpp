// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/part/stretch.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/overloaded.h"
#include "base/polar.h"
#include "base/principal_axes.h"
#include "runtime/part/bind_beams.h"
#include "runtime/part/messages.h"
#include "runtime/part/shape_stage.h"

namespace openfab::part {

namespace {

constexpr double kMostUneven = 1.1;
constexpr std::array<double, 9> kUnmoved{1, 0, 0, 0, 1, 0, 0, 0, 1};

}  // namespace

Vec2<double> stretch_range(const std::array<double, 9>& stretch) {
    double a[3][3], axes[3][3];
    for (size_t i = 0; i < 9; ++i)
        a[i / 3][i % 3] = stretch[i];
    constexpr double kRest = 1e-15;
    constexpr int kSweeps = 30;
    principal_axes(a, axes, kRest, kSweeps);
    return {std::min({a[0][0], a[1][1], a[2][2]}), std::max({a[0][0], a[1][1], a[2][2]})};
}

std::array<double, 9> inverse_stretch(const std::array<double, 9>& stretch) {
    // It is symmetric, as its inverse is.
    return inverse_transposed(stretch);
}

Result<void> check_uneven_stretch(const std::array<double, 9>& stretch, const char* help) {
    const Vec2<double> range = stretch_range(stretch);
    if (range.y <= range.x * kMostUneven) return Ok{};
    return user_error(fmt::format(messages::kUnevenStretch, range.x, range.y), help);
}

Stretched make_stretched(const Part& of, const std::array<double, 9>& by,
                         const openfab_fablet& fablet) {
    Stretched out{of, by};
    Part& source = out.source;
    source.piece = nullptr;
    auto mesh = std::make_shared<PartMesh>();
    mesh->center_part_mm = Affine3d{inverse_stretch(by), {}}.apply_vector(of.mesh->center_part_mm);
    source.mesh = mesh;
    std::visit(Overloaded{
                   [](const MeshGeometry&) {},
                   [&](BeamGeometry& beams) {
                       beams.beams = make_part_beams(beams.beams->beams, fablet, kUnmoved, *mesh);
                   },
                   // The centre of its box is where that of the stretched box comes from.
                   [&](const ShapeGeometry& shape) { source.mesh = shape.stage->mesh; },
                   [](const GrownGeometry&) {},
               },
               source.geometry);
    return out;
}

}  // namespace openfab::part

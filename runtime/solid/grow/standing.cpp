// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/grow/standing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/infinity.h"
#include "runtime/solid/messages.h"

namespace openfab::solid {

namespace {

/// Of a grid that nothing is printed on.
constexpr double kCellMm = 0.1;

/// Returns the points of a mesh that reach farthest along 26 directions; few points are all.
std::vector<Vec3f> farthest(const part::PartMesh& mesh) {
    constexpr size_t kFew = 64;
    std::vector<Vec3f> out;
    const auto add = [&](const Vec3d& p) {
        out.push_back(vec_cast<float>(p + mesh.center_part_mm));
    };
    if (mesh.positions.size() <= kFew) {
        std::ranges::for_each(mesh.positions, add);
        return out;
    }
    for (int32_t k = 0; k < 27; ++k) {
        const Vec3d along{static_cast<double>(k % 3 - 1), static_cast<double>(k / 3 % 3 - 1),
                          static_cast<double>(k / 9 - 1)};
        if (k != 13)
            add(*std::ranges::max_element(mesh.positions, {},
                                          [&](const Vec3d& p) { return dot(p, along); }));
    }
    return out;
}

}  // namespace

Standing::Standing(std::shared_ptr<const part::Part> part, std::shared_ptr<Solid> solid,
                   const QuerySetUp& queries)
    : part_(std::move(part)),
      solid_(std::move(solid)),
      grid_{{0, 0, 0}, {kCellMm, kCellMm, kCellMm}, {8, 8, 8}},
      frame_(part::make_frame(*part_, grid_)) {
    solid_->prepare({.nearest = true, .attributes = true, .geometry = true, .sign = true}, queries);
    placed_ = solid_->place({*part_, grid_, frame_});
    placed_->begin_queries();
    const Box3f local = solid_->bounds();
    for (int a = 0; a < 3; ++a) {
        const double center = part_->mesh->center_part_mm[a];
        bounds_.lo[a] = std::nextafter(
            static_cast<float>(static_cast<double>(local.lo[a]) + center), -kInfinity);
        bounds_.hi[a] = std::nextafter(
            static_cast<float>(static_cast<double>(local.hi[a]) + center), kInfinity);
    }
    extremes_ = farthest(*part_->mesh);
}

void Standing::ask(std::span<const Vec3d> points, bool surface, Found* out) const {
    Tools* tools = tools_.take([&] {
        auto made = std::make_unique<Tools>();
        made->scratch = placed_->make_scratch();
        return made;
    });
    const Vec3d& center = part_->mesh->center_part_mm;
    tools->points.assign((points.size() + 7) / 8, {});
    tools->answers.resize(tools->points.size());
    for (size_t i = 0; i < points.size(); ++i) {
        for (int a = 0; a < 3; ++a)
            tools->points[i / 8].p[a][i % 8] = static_cast<float>(points[i][a] - center[a]);
    }
    if (points.size() % 8 != 0) tools->points.back().mask = (1u << points.size() % 8) - 1;
    placed_->engine()->query_points(tools->points, kInfinity, tools->scratch->engine.get(),
                                    tools->answers.data());
    float found[6][8];
    nearest::PointTargets targets;
    for (size_t a = 0; a < 3; ++a) {
        targets.position[a] = found[a];
        targets.normal[a] = found[3 + a];
    }
    for (size_t g = 0; g < tools->points.size(); ++g) {
        const nearest::PointAnswer& answer = tools->answers[g];
        const uint32_t inside = placed_->inside(tools->points[g], answer, {}, tools->scratch.get());
        if (surface) placed_->read_points(answer, targets, tools->scratch.get());
        for (size_t l = 0; l < std::min<size_t>(8, points.size() - 8 * g); ++l) {
            Found& to = out[8 * g + l];
            const float d = std::sqrt(answer.distance2[l]);
            to.distance = (inside >> l & 1u) != 0 ? 0.0f - d : d;
            if (!surface || answer.item[l] < 0) continue;
            for (size_t a = 0; a < 3; ++a) {
                const int axis = static_cast<int>(a);
                to.position[axis] =
                    static_cast<float>(static_cast<double>(found[a][l]) + center[axis]);
                to.normal[axis] = found[3 + a][l];
            }
        }
    }
    tools_.give(tools);
}

size_t Standing::bytes() const {
    // Boxes and trees over a mesh, and its records.
    constexpr size_t kTriangle = 500, kSelf = 4000;
    return kSelf + kTriangle * part_->mesh->triangles.size();
}

Complaint GrownBody::set_axes(const std::array<Vec3f, 3>& from) {
    constexpr double kSlack = 1e-3;
    std::array<double, 3> lengths{};
    for (size_t a = 0; a < 3; ++a) {
        axes[a] = vec_cast<double>(from[a]);
        lengths[a] = length(axes[a]);
        if (!(lengths[a] > 0) || !std::isfinite(lengths[a]))
            return {fmt::format(messages::kAxisLength, lengths[a]), messages::kAxisLengthHelp};
        axes[a] = axes[a] * (1 / lengths[a]);
    }
    scale = (lengths[0] + lengths[1] + lengths[2]) / 3;
    for (size_t a = 0; a < 3; ++a) {
        const double cosine = dot(axes[a], axes[(a + 1) % 3]);
        if (std::fabs(cosine) > kSlack || std::fabs(lengths[a] - scale) > kSlack * scale)
            return {fmt::format(messages::kAxesNotAlike, lengths[0], lengths[1], lengths[2],
                                std::acos(std::clamp(cosine, -1.0, 1.0)) * 57.29577951308232),
                    messages::kAxesNotAlikeHelp};
    }
    // Gram and Schmidt: what is left of rounding would change distances.
    axes[1] = axes[1] - axes[0] * dot(axes[0], axes[1]);
    axes[1] = axes[1] * (1 / length(axes[1]));
    const double hand = dot(cross(axes[0], axes[1]), axes[2]);
    axes[2] = cross(axes[0], axes[1]) * (hand < 0 ? -1.0 : 1.0);
    return {};
}

Box3f GrownBody::box() const {
    const Box3f& of = solid->bounds();
    const Vec3d middle = from_solid(vec_cast<double>(of.center()));
    const Vec3d half = vec_cast<double>(of.size()) * (0.5 * scale);
    Box3f out;
    for (int a = 0; a < 3; ++a) {
        const double reach = std::fabs(axes[0][a]) * half.x + std::fabs(axes[1][a]) * half.y +
                             std::fabs(axes[2][a]) * half.z;
        const double slack = 0x1p-20 * (std::fabs(middle[a]) + reach);
        out.lo[a] = static_cast<float>(middle[a] - reach - slack);
        out.hi[a] = static_cast<float>(middle[a] + reach + slack);
    }
    return out;
}

Box3f GrownBody::reached() const {
    Box3f out;
    for (const Vec3f& p : solid->extremes())
        out.add(vec_cast<float>(from_solid(vec_cast<double>(p))));
    return out;
}

void GrownBody::ask(std::span<const Vec3d> points, bool surface,
                    std::vector<Standing::Found>* out) const {
    std::vector<Vec3d> own(points.size());
    std::ranges::transform(points, own.begin(), [&](const Vec3d& p) { return to_solid(p); });
    out->assign(points.size(), {});
    solid->ask(own, surface, out->data());
    for (Standing::Found& found : *out) {
        found.distance = static_cast<float>(static_cast<double>(found.distance) * scale);
        if (!surface) continue;
        found.position = vec_cast<float>(from_solid(vec_cast<double>(found.position)));
        found.normal = vec_cast<float>(turned(vec_cast<double>(found.normal)));
    }
}

float GrownBody::distance(const Vec3d& p) const {
    const Vec3d own = to_solid(p);
    Standing::Found found;
    solid->ask({&own, 1}, false, &found);
    return static_cast<float>(static_cast<double>(found.distance) * scale);
}

}  // namespace openfab::solid

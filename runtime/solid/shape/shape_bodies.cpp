// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/shape/shape_bodies.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/infinity.h"

namespace openfab::solid {

namespace {

// Of diced bodies: a shape's mostly.
constexpr size_t kTreeBytes = 64u << 20;
// What distances and differences of coordinates may be off by (rule 16), with room to spare.
constexpr float kRelative = 0x1p-14f, kOfCoordinates = 0x1p-18f;

}  // namespace

ShapeBodies::ShapeBodies(const part::ShapeStage& stage, const Bodies& solids, double cell_mm,
                         openfab_isa isa)
    : grid_{{0, 0, 0}, {cell_mm, cell_mm, cell_mm}, {8, 8, 8}}, bodies_(solids.size()) {
    const auto trees = nearest::make_patch_cache(kTreeBytes);
    for (size_t i = 0; i < solids.size(); ++i) {
        if (solids[i] == nullptr) continue;
        const part::Part& part = *stage.bodies[i];
        Body& body = bodies_[i];
        body.solid = solids[i];
        body.move = stage.mesh->center_part_mm - part.mesh->center_part_mm;
        body.solid->prepare({.nearest = true, .sign = true}, {isa, trees});
        body.frame = part::make_frame(part, grid_);
        body.placed = body.solid->place({part, grid_, body.frame});
        body.placed->begin_queries();
    }
}

/// Answers the points of `tools`, of which there are n.
void ShapeBodies::ask(size_t body, size_t n, Tools* tools) const {
    const Body& of = bodies_[body];
    tools->scratch_.resize(bodies_.size());
    std::unique_ptr<Scratch>& scratch = tools->scratch_[body];
    if (scratch == nullptr) scratch = of.placed->make_scratch();
    if (n % 8 != 0) tools->points_.back().mask = (1u << n % 8) - 1;
    tools->answers_.resize(tools->points_.size());
    of.placed->engine()->query_points(tools->points_, kInfinity, scratch->engine.get(),
                                      tools->answers_.data());
}

void ShapeBodies::distances(size_t body, const std::array<const float*, 3>& points, size_t n,
                            Tools* tools, float* out) const {
    const Body& of = bodies_[body];
    tools->points_.assign((n + 7) / 8, {});
    for (size_t i = 0; i < n; ++i) {
        for (size_t a = 0; a < 3; ++a) {
            tools->points_[i / 8].p[a][i % 8] = static_cast<float>(
                static_cast<double>(points[a][i]) + of.move[static_cast<int>(a)]);
        }
    }
    ask(body, n, tools);
    for (size_t g = 0; g < tools->points_.size(); ++g) {
        const nearest::PointAnswer& answer = tools->answers_[g];
        const uint32_t inside =
            of.placed->inside(tools->points_[g], answer, {}, tools->scratch_[body].get());
        for (size_t l = 0; l < std::min<size_t>(8, n - 8 * g); ++l) {
            const float d = std::sqrt(answer.distance2[l]);
            out[8 * g + l] = (inside >> l & 1u) != 0 ? 0.0f - d : d;
        }
    }
}

/// A distance changes no faster than its point moves.
void ShapeBodies::bounds(size_t body, const std::array<const float*, 3>& lo,
                         const std::array<const float*, 3>& hi, size_t n, Tools* tools,
                         float* out_lo, float* out_hi) const {
    std::array<std::vector<float>, 3> middle;
    for (size_t a = 0; a < 3; ++a) {
        middle[a].resize(n);
        for (size_t i = 0; i < n; ++i)
            middle[a][i] = 0.5f * (lo[a][i] + hi[a][i]);
    }
    distances(body, {middle[0].data(), middle[1].data(), middle[2].data()}, n, tools, out_lo);
    for (size_t i = 0; i < n; ++i) {
        float square = 0, largest = 0;
        for (size_t a = 0; a < 3; ++a) {
            const float half = std::max(hi[a][i] - middle[a][i], middle[a][i] - lo[a][i]);
            square += half * half;
            largest =
                std::max({largest, std::fabs(lo[a][i]), std::fabs(hi[a][i]),
                          static_cast<float>(std::fabs(bodies_[body].move[static_cast<int>(a)]))});
        }
        const float d = out_lo[i], reach = std::sqrt(square);
        if (!std::isfinite(d)) {
            out_lo[i] = out_hi[i] = std::numeric_limits<float>::quiet_NaN();
            continue;
        }
        const float slack = kRelative * (std::fabs(d) + reach) + kOfCoordinates * largest;
        out_lo[i] = d - reach - slack;
        out_hi[i] = d + reach + slack;
    }
}

int64_t ShapeBodies::query_bytes() const {
    int64_t bytes = 0;
    bool any_diced = false;
    for (const Body& body : bodies_) {
        if (body.solid == nullptr) continue;
        bytes += body.solid->query_bytes();
        any_diced |= body.solid->dicing() != nullptr;
    }
    return bytes + (any_diced ? static_cast<int64_t>(kTreeBytes) : 0);
}

Result<void> ShapeBodies::status() const {
    for (const Body& body : bodies_) {
        if (body.solid == nullptr) continue;
        if (Result<void> fine = body.solid->status(); !fine) return fine;
    }
    return {};
}

}  // namespace openfab::solid

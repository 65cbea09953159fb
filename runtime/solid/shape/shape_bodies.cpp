// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/shape/shape_bodies.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "base/infinity.h"

namespace openfab::solid {

namespace {

// Of diced bodies: a shape's mostly.
constexpr size_t kTreeBytes = 64u << 20;
// What distances and differences of coordinates may be off by (rule 16), with room to spare.
constexpr float kRelative = 0x1p-14f, kOfCoordinates = 0x1p-18f;
// Coordinates whose distances are numbers, with room to spare.
constexpr float kMostKnown = nearest::kMaxCoordinate / 2;
// Cells from one point of the grid to the next, and points that a thread keeps.
constexpr double kGridCells = 4;
constexpr size_t kMostOfGrid = 1u << 16;

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
        body.quick = body.solid->dicing() != nullptr && !body.solid->bounds_dice();
        body.empty = body.quick && body.solid->dicing()->patches() == 0;
    }
}

/// Puts points of the stage into `tools` as those of a body, and makes its scratch. Lanes beyond the last are inactive.
void ShapeBodies::load(size_t body, const std::array<const float*, 3>& points, size_t n,
                       Tools* tools) const {
    const Body& of = bodies_[body];
    tools->scratch_.resize(bodies_.size());
    if (tools->scratch_[body] == nullptr) tools->scratch_[body] = of.placed->make_scratch();
    tools->points_.assign((n + 7) / 8, {});
    for (size_t i = 0; i < n; ++i) {
        for (size_t a = 0; a < 3; ++a) {
            tools->points_[i / 8].p[a][i % 8] = static_cast<float>(
                static_cast<double>(points[a][i]) + of.move[static_cast<int>(a)]);
        }
    }
    if (n % 8 != 0) tools->points_.back().mask = (1u << n % 8) - 1;
    tools->answers_.resize(tools->points_.size());
}

void ShapeBodies::distances(size_t body, const std::array<const float*, 3>& points, size_t n,
                            Tools* tools, float* out) const {
    const Body& of = bodies_[body];
    load(body, points, n, tools);
    Scratch* const scratch = tools->scratch_[body].get();
    of.placed->engine()->query_points(tools->points_, kInfinity, scratch->engine.get(),
                                      tools->answers_.data());
    const bool by_value = find_sides(body, points, points, n, tools);
    for (size_t g = 0; g < tools->points_.size(); ++g) {
        const nearest::PointAnswer& answer = tools->answers_[g];
        uint32_t inside = by_value ? 0 : of.placed->inside(tools->points_[g], answer, {}, scratch);
        for (size_t l = 0; l < std::min<size_t>(8, n - 8 * g); ++l) {
            const float d = std::sqrt(answer.distance2[l]);
            if (by_value && d < kInfinity && tools->sides_[8 * g + l] < 0) inside |= 1u << l;
            out[8 * g + l] = (inside >> l & 1u) != 0 ? 0.0f - d : d;
        }
    }
}

void ShapeBodies::near_distances(size_t body, const std::array<const float*, 3>& points, size_t n,
                                 Tools* tools, float* out_lo, float* out_hi) const {
    load(body, points, n, tools);
    tools->ranges_.resize(tools->points_.size());
    bodies_[body].placed->engine()->bound_points(
        tools->points_, {}, 0, tools->scratch_[body]->engine.get(), tools->ranges_.data());
    for (size_t i = 0; i < n; ++i) {
        const nearest::PointBounds& range = tools->ranges_[i / 8];
        out_lo[i] = range.low[i % 8];
        out_hi[i] = range.high[i % 8];
    }
}

/// Sets the sides of boxes if signs are those of values.
bool ShapeBodies::find_sides(size_t body, const std::array<const float*, 3>& lo,
                             const std::array<const float*, 3>& hi, size_t n, Tools* tools) const {
    const Body& of = bodies_[body];
    if (!of.quick) return false;
    std::array<const float*, 3> from{}, to{};
    for (size_t a = 0; a < 3; ++a) {
        const auto move = [&](const float* points, std::vector<float>* moved) {
            moved->resize(n);
            for (size_t i = 0; i < n; ++i) {
                (*moved)[i] = static_cast<float>(static_cast<double>(points[i]) +
                                                 of.move[static_cast<int>(a)]);
            }
            return moved->data();
        };
        from[a] = move(lo[a], &tools->moved_lo_[a]);
        to[a] = lo[a] == hi[a] ? from[a] : move(hi[a], &tools->moved_hi_[a]);
    }
    tools->sides_.resize(n);
    return of.solid->sides(from, to, n, tools->sides_.data());
}

/// Gives bounds of how far micropolygons are the signs of distances. A value changes its sign beside coarse micropolygons, not on
/// them, and where it is thin without any.
void ShapeBodies::give_signs(size_t body, const std::array<const float*, 3>& lo,
                             const std::array<const float*, 3>& hi, size_t n, Tools* tools,
                             float* out_lo, float* out_hi) const {
    const bool known = find_sides(body, lo, hi, n, tools);
    for (size_t i = 0; i < n; ++i) {
        const int8_t side = known ? tools->sides_[i] : int8_t{0};
        if (side == 0) out_lo[i] = 0.0f - out_hi[i];
        if (side < 0) out_lo[i] = 0.0f - std::exchange(out_hi[i], 0.0f - out_lo[i]);
    }
}

/// The surface is in the body's box, and a distance changes no faster than its point moves.
void ShapeBodies::box_bounds(size_t body, const std::array<const float*, 3>& lo,
                             const std::array<const float*, 3>& hi, size_t n, float* out_lo,
                             float* out_hi) const {
    const Body& of = bodies_[body];
    const Box3f box = of.solid->bounds();
    for (size_t i = 0; i < n; ++i) {
        float square = 0, largest = 0;
        bool known = !of.empty;
        for (size_t a = 0; a < 3; ++a) {
            const int axis = static_cast<int>(a);
            const auto move = static_cast<float>(of.move[axis]);
            const float from = lo[a][i] + move, to = hi[a][i] + move;
            const float far = std::max(to - box.lo[axis], box.hi[axis] - from);
            square += far * far;
            largest = std::max({largest, std::fabs(lo[a][i]), std::fabs(hi[a][i]), std::fabs(move),
                                std::fabs(from), std::fabs(to)});
            known = known && from >= -kMostKnown && to <= kMostKnown;
        }
        const float most = std::sqrt(square) * (1 + kRelative) + kOfCoordinates * largest;
        out_hi[i] = known ? most : std::numeric_limits<float>::quiet_NaN();
        out_lo[i] = 0.0f - out_hi[i];
    }
}

/// One at a point of the grid bounds those of all boxes around it.
void ShapeBodies::grid_bounds(size_t body, const std::array<const float*, 3>& lo,
                              const std::array<const float*, 3>& hi, size_t n, Tools* tools,
                              float* out_lo, float* out_hi) const {
    tools->grid_.resize(bodies_.size());
    auto& known = tools->grid_[body];
    if (known.size() > kMostOfGrid) known.clear();
    const bool quick = bodies_[body].quick;
    const double side = kGridCells * grid_.pitch_mm.x;
    constexpr int64_t kPlaces = int64_t{1} << 21, kHalf = kPlaces / 2;
    std::vector<uint64_t> places(n);
    std::vector<float*> at(n);
    std::array<std::vector<float>, 3> asked;
    std::vector<float*> answers;
    for (size_t i = 0; i < n; ++i) {
        uint64_t place = 0;
        std::array<float, 3> point{};
        bool inside = true;
        for (size_t a = 0; a < 3; ++a) {
            const double middle =
                (static_cast<double>(lo[a][i]) + static_cast<double>(hi[a][i])) / 2;
            const double step = std::floor(middle / side + 0.5);
            inside = inside && std::fabs(step) < static_cast<double>(kHalf);
            if (!inside) break;
            place = place << 21 | static_cast<uint64_t>(static_cast<int64_t>(step) + kHalf);
            point[a] = static_cast<float>(step * side);
        }
        if (!inside) continue;
        if (i > 0 && at[i - 1] != nullptr && places[i - 1] == place) {
            at[i] = at[i - 1];
        } else {
            const auto [found, is_new] = known.try_emplace(place, 0.0f);
            at[i] = &found->second;  // maps of this kind do not move what they hold
            if (is_new) {
                for (size_t a = 0; a < 3; ++a)
                    asked[a].push_back(point[a]);
                answers.push_back(at[i]);
            }
        }
        places[i] = place;
    }
    std::vector<float> found(answers.size());
    if (!answers.empty()) {
        distances(body, {asked[0].data(), asked[1].data(), asked[2].data()}, answers.size(), tools,
                  found.data());
    }
    for (size_t k = 0; k < answers.size(); ++k)
        *answers[k] = found[k];
    for (size_t i = 0; i < n; ++i) {
        out_lo[i] = out_hi[i] = std::numeric_limits<float>::quiet_NaN();
        if (at[i] == nullptr || !std::isfinite(*at[i])) continue;
        float square = 0, largest = 0;
        for (size_t a = 0; a < 3; ++a) {
            const auto step = static_cast<int64_t>(places[i] >> (21 * (2 - a)) & (kPlaces - 1));
            const auto point = static_cast<float>(static_cast<double>(step - kHalf) * side);
            const float off = std::max(hi[a][i] - point, point - lo[a][i]);
            square += off * off;
            largest =
                std::max({largest, std::fabs(lo[a][i]), std::fabs(hi[a][i]), std::fabs(point),
                          static_cast<float>(std::fabs(bodies_[body].move[static_cast<int>(a)]))});
        }
        const float reach = std::sqrt(square);
        const float more =
            reach + kRelative * (reach + std::fabs(*at[i])) + kOfCoordinates * largest;
        const float d = quick ? std::fabs(*at[i]) : *at[i];
        out_lo[i] = quick ? std::max(d - more, 0.0f) : d - more;
        out_hi[i] = d + more;
    }
    if (quick) give_signs(body, lo, hi, n, tools, out_lo, out_hi);
}

/// A distance changes no faster than its point moves, but for its sign where that is a value's. Where micropolygons would have to
/// be made first, most boxes are bounded without: those that are as wide as what is then left open.
void ShapeBodies::bounds(size_t body, const std::array<const float*, 3>& lo,
                         const std::array<const float*, 3>& hi, size_t n, Effort effort,
                         Tools* tools, float* out_lo, float* out_hi) const {
    if (effort == Effort::kBox) return box_bounds(body, lo, hi, n, out_lo, out_hi);
    if (effort == Effort::kGrid) return grid_bounds(body, lo, hi, n, tools, out_lo, out_hi);
    std::array<std::vector<float>, 3> middle;
    std::vector<float> reach(n), slack(n);
    for (size_t a = 0; a < 3; ++a)
        middle[a].resize(n);
    for (size_t i = 0; i < n; ++i) {
        float square = 0, largest = 0;
        for (size_t a = 0; a < 3; ++a) {
            middle[a][i] = 0.5f * (lo[a][i] + hi[a][i]);
            const float half = std::max(hi[a][i] - middle[a][i], middle[a][i] - lo[a][i]);
            square += half * half;
            largest =
                std::max({largest, std::fabs(lo[a][i]), std::fabs(hi[a][i]),
                          static_cast<float>(std::fabs(bodies_[body].move[static_cast<int>(a)]))});
        }
        reach[i] = std::sqrt(square);
        slack[i] = kRelative * reach[i] + kOfCoordinates * largest;
    }
    const auto pointers = [](const std::array<std::vector<float>, 3>& of) {
        return std::array<const float*, 3>{of[0].data(), of[1].data(), of[2].data()};
    };
    const bool quick = bodies_[body].quick;
    std::vector<size_t> left;
    if (quick) {
        near_distances(body, pointers(middle), n, tools, out_lo, out_hi);
        for (size_t i = 0; i < n; ++i) {
            const float width = out_lo[i] > 0 ? out_hi[i] - out_lo[i] : 2 * out_hi[i];
            if (effort == Effort::kExact && !(width <= reach[i])) left.push_back(i);
        }
    } else {
        left.resize(n);
        std::iota(left.begin(), left.end(), size_t{0});
    }
    std::array<std::vector<float>, 3> asked;
    for (size_t a = 0; a < 3; ++a) {
        for (const size_t i : left)
            asked[a].push_back(middle[a][i]);
    }
    std::vector<float> exact(left.size());
    if (!left.empty()) distances(body, pointers(asked), left.size(), tools, exact.data());
    for (size_t k = 0; k < left.size(); ++k)
        out_lo[left[k]] = out_hi[left[k]] = quick ? std::fabs(exact[k]) : exact[k];
    for (size_t i = 0; i < n; ++i) {
        if (!std::isfinite(out_lo[i]) || !std::isfinite(out_hi[i])) {
            out_lo[i] = out_hi[i] = std::numeric_limits<float>::quiet_NaN();
            continue;
        }
        const float magnitude = std::max(std::fabs(out_lo[i]), std::fabs(out_hi[i]));
        const float more = reach[i] + slack[i] + kRelative * magnitude;
        out_lo[i] -= more;
        out_hi[i] += more;
        if (quick) out_lo[i] = std::max(out_lo[i], 0.0f);
    }
    if (quick) give_signs(body, lo, hi, n, tools, out_lo, out_hi);
}

bool ShapeBodies::any_quick() const {
    return std::any_of(bodies_.begin(), bodies_.end(), [](const Body& one) { return one.quick; });
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

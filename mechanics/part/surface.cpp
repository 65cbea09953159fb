// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/part/surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/at.h"
#include "mechanics/messages.h"

namespace openfab::mechanics {

namespace {

constexpr float kHalf = 0.5F;

/// Calls f(index) for the six elements around one.
template <typename F>
void around(const Grid& g, const std::array<int32_t, 3>& p, const F& f) {
    for (size_t a = 0; a < 3; ++a)
        for (const int32_t step : {-1, 1}) {
            std::array<int32_t, 3> q = p;
            q[a] += step;
            if (q[a] >= 0 && q[a] < g.elements[a]) f(g.element(q[0], q[1], q[2]));
        }
}

}  // namespace

std::array<int32_t, 3> place_of(const Grid& g, int64_t element) {
    return {static_cast<int32_t>(element % g.elements[0]),
            static_cast<int32_t>(element / g.elements[0] % g.elements[1]),
            static_cast<int32_t>(element / g.elements[0] / g.elements[1])};
}

PartElements classify(const Grid& g, Voxels* v) {
    PartElements out;
    const auto n = static_cast<size_t>(g.element_count());
    out.kind.resize(n);
    for (size_t e = 0; e < n; ++e)
        out.kind[e] = v->solid[e] >= kHalf && v->mu[e] > 0 ? kSolid : kNothing;
    for (size_t e = 0; e < n; ++e) {
        if (!(v->solid[e] > 0)) continue;
        out.volume += static_cast<double>(v->solid[e]);
        if (out.kind[e] == kSolid) {
            ++out.solid;
            continue;
        }
        const std::array<int32_t, 3> p = place_of(g, static_cast<int64_t>(e));
        bool touches_solid = false;
        around(g, p,
               [&](size_t other) { touches_solid = touches_solid || out.kind[other] == kSolid; });
        if (touches_solid && v->mu[e] > 0)
            out.kind[e] = kRim;
        else
            v->lambda[e] = v->mu[e] = 0;
    }
    return out;
}

std::vector<Face> surface_of(const Grid& g, std::span<const uint8_t> kind) {
    std::vector<Face> out;
    for (int64_t e = 0; e < g.element_count(); ++e) {
        if (kind[static_cast<size_t>(e)] != kSolid) continue;
        const std::array<int32_t, 3> p = place_of(g, e);
        for (uint8_t d = 0; d < 6; ++d) {
            std::array<int32_t, 3> q = p;
            const size_t axis = d / 2;
            q[axis] += d % 2 == 1 ? 1 : -1;
            const bool outside = q[axis] < 0 || q[axis] >= g.elements[axis];
            if (outside || kind[g.element(q[0], q[1], q[2])] != kSolid) out.push_back({e, d});
        }
    }
    return out;
}

bool is_tip(const Grid& g, std::span<const Face> surface, std::span<const Face> chosen) {
    if (chosen.empty()) return false;
    const uint8_t direction = chosen[0].direction;
    if (std::ranges::any_of(chosen, [&](const Face& f) { return f.direction != direction; }))
        return false;
    const size_t axis = direction / 2;
    std::vector<uint8_t> open(static_cast<size_t>(g.element_count()));
    for (const Face& f : surface)
        if (f.direction == direction) at(open, f.element) = 1;
    std::vector<int64_t> step;
    for (const Face& f : chosen) {
        at(open, f.element) = 0;
        step.push_back(f.element);
    }
    // Adds the open faces beside one, so much deeper.
    const auto add_beside = [&](int64_t element, int32_t deeper, std::vector<int64_t>* to) {
        std::array<int32_t, 3> p = place_of(g, element);
        p[axis] += direction % 2 == 1 ? -deeper : deeper;
        if (p[axis] < 0 || p[axis] >= g.elements[axis]) return;
        for (const size_t aside : {(axis + 1) % 3, (axis + 2) % 3})
            for (const int32_t by : {-1, 1}) {
                std::array<int32_t, 3> q = p;
                q[aside] += by;
                if (q[aside] < 0 || q[aside] >= g.elements[aside]) continue;
                const size_t e = g.element(q[0], q[1], q[2]);
                if (std::exchange(open[e], uint8_t{0})) to->push_back(static_cast<int64_t>(e));
            }
    };
    for (int k = 0; k < 2; ++k) {
        std::vector<int64_t> next;
        for (const int64_t e : step)
            add_beside(e, 1, &next);
        for (size_t i = 0; i < next.size(); ++i)
            add_beside(next[i], 0, &next);
        constexpr double kMuch = 0.4;
        if (static_cast<double>(next.size()) < kMuch * static_cast<double>(chosen.size()))
            return false;
        step = std::move(next);
    }
    return true;
}

std::array<int64_t, 4> nodes_of(const Grid& g, const Face& face) {
    const std::array<int32_t, 3> p = place_of(g, face.element);
    const size_t axis = face.direction / 2, a = (axis + 1) % 3, b = (axis + 2) % 3;
    std::array<int64_t, 4> out{};
    for (size_t k = 0; k < 4; ++k) {
        std::array<int32_t, 3> q = p;
        q[axis] += face.direction % 2;
        q[a] += static_cast<int32_t>(k & 1);
        q[b] += static_cast<int32_t>(k >> 1);
        out[k] = (int64_t{q[2]} * g.nodes[1] + q[1]) * g.nodes[0] + q[0];
    }
    return out;
}

std::vector<LoadedFace> loaded_faces(const Grid& g, const Voxels& v, std::span<const uint8_t> kind,
                                     std::span<const Face> chosen) {
    std::vector<LoadedFace> out;
    std::vector<Face> rims, sorted(chosen.begin(), chosen.end());
    std::ranges::sort(sorted);
    const auto at = [&](std::array<int32_t, 3> p, size_t axis, int32_t by) {
        p[axis] += by;
        return p[axis] >= 0 && p[axis] < g.elements[axis]
                   ? static_cast<int64_t>(g.element(p[0], p[1], p[2]))
                   : int64_t{-1};
    };
    const auto kind_of = [&](int64_t e) {
        return e < 0 ? uint8_t{kNothing} : kind[static_cast<size_t>(e)];
    };
    const auto add = [&](const Face& f) {
        const size_t axis = f.direction / 2;
        const int32_t inwards = f.direction % 2 == 1 ? -1 : 1;
        const int64_t behind = at(place_of(g, f.element), axis, inwards);
        const double share =
            kind_of(behind) == kNothing ? 1.0 : static_cast<double>(v.solid[behind]);
        const double whole = g.pitch_mm[(axis + 1) % 3] * g.pitch_mm[(axis + 2) % 3];
        out.push_back({f, whole * std::min(1.0, share)});
    };
    for (const Face& f : chosen) {
        add(f);
        const size_t axis = f.direction / 2;
        const int32_t outwards = f.direction % 2 == 1 ? 1 : -1;
        const std::array<int32_t, 3> p = place_of(g, f.element);
        for (const size_t side : {(axis + 1) % 3, (axis + 2) % 3})
            for (const int32_t step : {-1, 1}) {
                const int64_t rim = at(p, side, step);
                if (kind_of(rim) != kRim) continue;
                const std::array<int32_t, 3> q = place_of(g, rim);
                int32_t deep = 1;
                while (kind_of(at(q, axis, -outwards * deep)) == kRim)
                    ++deep;
                const int64_t end = at(q, axis, -outwards * deep);
                // What is solid further in may be chosen itself, with the whole area.
                const bool counted = std::ranges::binary_search(sorted, Face{end, f.direction});
                if (kind_of(at(q, axis, outwards)) != kSolid && !counted &&
                    (deep > 1 || kind_of(end) == kSolid))
                    rims.push_back({rim, f.direction});
            }
    }
    std::ranges::sort(rims);
    rims.erase(std::ranges::unique(rims).begin(), rims.end());
    for (const Face& f : rims)
        add(f);
    return out;
}

bool ObjectVoxels::has(const Vec3& p, const Vec3& pitch_mm) const {
    size_t at[3];
    for (size_t a = 0; a < 3; ++a) {
        const double i = std::floor((p[a] - origin_mm[a]) / pitch_mm[a]);
        if (i < 0 || i >= size[a]) return false;
        at[a] = static_cast<size_t>(i);
    }
    return inside[(at[2] * static_cast<size_t>(size[1]) + at[1]) * static_cast<size_t>(size[0]) +
                  at[0]] != 0;
}

FaceChooser::FaceChooser(const Grid& grid, const Vec3& origin_mm, std::span<const Face> surface,
                         std::span<const ObjectVoxels> objects)
    : grid_(grid), origin_(origin_mm), surface_(surface), objects_(objects) {
    for (auto& r : range_)
        r = {INT32_MAX, INT32_MIN};
    for (const Face& f : surface) {
        const std::array<int32_t, 3> p = place_of(grid, f.element);
        for (size_t a = 0; a < 3; ++a) {
            range_[a][0] = std::min(range_[a][0], p[a]);
            range_[a][1] = std::max(range_[a][1], p[a]);
        }
    }
}

Vec3 FaceChooser::centre_mm(const Face& face) const {
    const std::array<int32_t, 3> p = place_of(grid_, face.element);
    Vec3 out;
    for (size_t a = 0; a < 3; ++a)
        out[a] = origin_[a] + (p[a] + 0.5) * grid_.pitch_mm[a];
    const size_t axis = face.direction / 2;
    out[axis] += (face.direction % 2 == 1 ? 0.5 : -0.5) * grid_.pitch_mm[axis];
    return out;
}

bool FaceChooser::is_chosen(const FaceChoice& choice, const ObjectVoxels* object,
                            const Face& face) const {
    const size_t axis = face.direction / 2;
    if (choice.facing && *choice.facing != face.direction) return false;
    if (choice.side) {
        if (*choice.side != face.direction) return false;
        const int32_t at = place_of(grid_, face.element)[axis];
        if (at != range_[axis][face.direction % 2]) return false;
    }
    const Vec3 centre = centre_mm(face);
    if (choice.box_mm) {
        constexpr double kSlack = 0.01;
        for (size_t a = 0; a < 3; ++a)
            if (centre[a] < (*choice.box_mm)[0][a] - kSlack * grid_.pitch_mm[a] ||
                centre[a] > (*choice.box_mm)[1][a] + kSlack * grid_.pitch_mm[a])
                return false;
    }
    const double sign = face.direction % 2 == 1 ? 1 : -1;
    if (choice.normal) {
        double away = 0, reach = 0;
        for (size_t a = 0; a < 3; ++a) {
            const double n = (*choice.normal)[a];
            away += n * (centre[a] - (*choice.point_mm)[a]);
            reach += std::abs(n) * grid_.pitch_mm[a];
        }
        // A staircase along an oblique plane has faces on either side of it.
        constexpr double kAlong = 0.3, kReach = 0.55;
        if (std::abs(away) > kReach * reach || sign * (*choice.normal)[axis] < kAlong) return false;
    }
    if (!object) return true;
    // In the object, or within a voxel of it.
    for (const double step : {-0.75, 0.0, 0.75}) {
        Vec3 p = centre;
        p[axis] += step * grid_.pitch_mm[axis];
        if (object->has(p, grid_.pitch_mm)) return true;
    }
    return false;
}

Result<std::vector<Face>> FaceChooser::choose(const FaceChoice& choice) const {
    const ObjectVoxels* object = nullptr;
    if (!choice.object.empty())
        object = &*std::ranges::find(objects_, choice.object, &ObjectVoxels::name);
    std::vector<Face> out;
    for (const Face& f : surface_)
        if (is_chosen(choice, object, f)) out.push_back(f);
    if (!out.empty()) return out;
    const auto end = [&](size_t a, size_t which) {
        return origin_[a] + grid_.pitch_mm[a] * (range_[a][which] + static_cast<int32_t>(which));
    };
    Error error = user_error(fmt::format(messages::kNoFaceOf, choice.text),
                             fmt::format(messages::kNoFaceOfHelp, end(0, 0), end(1, 0), end(2, 0),
                                         end(0, 1), end(1, 1), end(2, 1)));
    error.location = choice.location;
    return error;
}

}  // namespace openfab::mechanics

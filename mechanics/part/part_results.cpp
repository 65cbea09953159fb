// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/part/part_results.h"

#include <algorithm>
#include <cmath>

#include "mechanics/part/across.h"

namespace openfab::mechanics {

Vec3 moved_at(const Field<double, kElastic>& moved, int64_t node) {
    const int64_t nx = moved.nodes(0), row = node / nx;
    Vec3 out;
    for (int c = 0; c < 3; ++c)
        out[static_cast<size_t>(c)] =
            moved.row(c, static_cast<int32_t>(row % moved.nodes(1)),
                      static_cast<int32_t>(row / moved.nodes(1)))[node % nx];
    return out;
}

namespace {

/// Whether an element is within two of a marked node.
std::vector<uint8_t> near_nodes(const Grid& g, const std::vector<int64_t>& nodes) {
    std::vector<uint8_t> out(static_cast<size_t>(g.element_count()));
    for (const int64_t node : nodes) {
        const auto x = static_cast<int32_t>(node % g.nodes[0]);
        const auto y = static_cast<int32_t>(node / g.nodes[0] % g.nodes[1]);
        const auto z = static_cast<int32_t>(node / g.nodes[0] / g.nodes[1]);
        for (int32_t k = std::max(0, z - 2); k < std::min(g.elements[2], z + 2); ++k)
            for (int32_t j = std::max(0, y - 2); j < std::min(g.elements[1], y + 2); ++j)
                for (int32_t i = std::max(0, x - 2); i < std::min(g.elements[0], x + 2); ++i)
                    out[g.element(i, j, k)] = 1;
    }
    return out;
}

/// Steps across an element, or across what begins within two of it along an axis, if that is as soft or as stiff: where a
/// thin wall ends on something thick, it breaks in what is thick already.
uint8_t across_about(const PartProblem& p, size_t e) {
    constexpr int32_t kNear = 2;
    constexpr float kAlike = 10;
    const Grid& g = p.grid;
    const auto stiffness = [&](size_t i) {
        return p.voxels.solid[i] > 0 ? p.voxels.mu[i] / p.voxels.solid[i] : 0;
    };
    const std::array<int32_t, 3> at = place_of(g, static_cast<int64_t>(e));
    const float own = stiffness(e);
    uint8_t least = p.across[e];
    for (size_t axis = 0; axis < 3; ++axis)
        for (const int32_t sign : {1, -1})
            for (int32_t k = 1; k <= kNear; ++k) {
                std::array<int32_t, 3> q = at;
                q[axis] += sign * k;
                if (q[axis] < 0 || q[axis] >= g.elements[axis]) break;
                const size_t other = g.element(q[0], q[1], q[2]);
                if (p.elements.kind[other] != kSolid) break;
                if (p.across[other] >= least) continue;
                const float there = stiffness(other);
                if (there * kAlike > own && there < kAlike * own) least = p.across[other];
            }
    return least;
}

}  // namespace

std::vector<uint8_t> near_holds_and_loads(const PartProblem& problem) {
    std::vector<int64_t> nodes = problem.load_nodes;
    for (const Held& h : problem.held)
        nodes.push_back(h.dof / 3);
    return near_nodes(problem.grid, nodes);
}

double coarse_excess(uint8_t across) {
    // Twisted shafts of 2.5 elements have 0.63 of their stress (docs/mechanics.md); strips of two whose faces end within
    // elements, in a wall that does, 0.51 of it.
    constexpr int kTwoAndAHalf = 5 * kAcrossStep / 2;
    return across < kTwoAndAHalf ? 2 : 1.6;
}

PartSummary summary_of(const PartProblem& problem, const PartFields& fields,
                       const Field<double, kElastic>& moved, size_t most_places) {
    const Grid& g = problem.grid;
    const Vec3& origin = problem.voxels.origin_mm;
    PartSummary out;
    std::vector<int64_t> held;
    for (const Held& h : problem.held)
        held.push_back(h.dof / 3);
    held.erase(std::ranges::unique(held).begin(), held.end());
    const std::vector<uint8_t> at_hold = near_nodes(g, held),
                               at_load = near_nodes(g, problem.load_nodes);
    bool known = false;
    std::vector<int64_t> solid;
    for (int64_t e = 0; e < g.element_count(); ++e) {
        const auto at = static_cast<size_t>(e);
        if (problem.elements.kind[at] != kSolid) continue;
        solid.push_back(e);
        known = known || fields.safety[at] > 0;
        const std::array<int32_t, 3> p = place_of(g, e);
        for (const uint8_t d : {uint8_t{4}, uint8_t{5}})
            for (const int64_t node : nodes_of(g, {e, d})) {
                const Vec3 u = moved_at(moved, node);
                const double length = std::hypot(u[0], u[1], u[2]);
                if (length <= out.most_moved_mm) continue;
                out.most_moved_mm = length;
                out.moved_there_mm = u;
                for (size_t a = 0; a < 3; ++a)
                    out.moved_at_mm[a] = origin[a] + (p[a] + 0.5) * g.pitch_mm[a];
            }
    }
    // The weakest first: by safety, or by stress where no strength is known.
    const auto weaker = [&](int64_t a, int64_t b) {
        const auto i = static_cast<size_t>(a), j = static_cast<size_t>(b);
        if (known) {
            const float x = fields.safety[i] > 0 ? fields.safety[i] : 1e9F,
                        y = fields.safety[j] > 0 ? fields.safety[j] : 1e9F;
            if (x != y) return x < y;
        }
        if (fields.von_mises_MPa[i] != fields.von_mises_MPa[j])
            return fields.von_mises_MPa[i] > fields.von_mises_MPa[j];
        return a < b;
    };
    std::ranges::sort(solid, weaker);
    double longest = 0;
    for (size_t a = 0; a < 3; ++a)
        longest = std::max(longest, g.elements[a] * g.pitch_mm[a]);
    const double apart = std::max(4 * *std::ranges::max_element(g.pitch_mm), 0.06 * longest);
    std::vector<float> stresses;
    for (const int64_t e : solid) {
        const auto at = static_cast<size_t>(e);
        stresses.push_back(fields.von_mises_MPa[at]);
        if (known && fields.safety[at] > 0) {
            const double s = static_cast<double>(fields.safety[at]);
            if (out.least_safety == 0) out.least_safety = s;
            if (out.least_safety_away == 0 && !at_hold[at] && !at_load[at])
                out.least_safety_away = s;
            // Where it is far from the weakest, what is about it is, too.
            constexpr double kFar = 4;
            const uint8_t across =
                s < kFar * out.least_safety ? across_about(problem, at) : problem.across[at];
            // A wall that is thicker, or flat, is off by less.
            constexpr double kMostCut = 1.2;
            if (across >= kCoarse && s < kMostCut * out.least_safety) {
                const double low = s / cut_excess(g, problem.voxels, problem.elements.kind, at);
                if (out.least_safety_cut == 0 || low < out.least_safety_cut)
                    out.least_safety_cut = low;
            }
            // Elements are sorted by safety, but not by how far that may be off.
            if (across >= kUnresolved) {
                if (out.least_safety_resolved == 0) out.least_safety_resolved = s;
                const double low = s / coarse_excess(across);
                if (across < kCoarse &&
                    (out.least_safety_coarse == 0 || low < out.least_safety_coarse))
                    out.least_safety_coarse = low;
            } else {
                constexpr int kRough = 3 * kAcrossStep / 2;
                const double low = s / (across >= kRough ? 2.5 : 4);
                if (out.least_safety_unresolved == 0 || low < out.least_safety_unresolved)
                    out.least_safety_unresolved = low;
            }
        }
    }
    if (!stresses.empty()) {
        out.most_von_mises_MPa = static_cast<double>(*std::ranges::max_element(stresses));
        const size_t rank = stresses.size() - 1 - stresses.size() / 100;
        std::nth_element(stresses.begin(), stresses.begin() + static_cast<ptrdiff_t>(rank),
                         stresses.end());
        out.typical_MPa = static_cast<double>(stresses[rank]);
    }
    for (const int64_t e : solid) {
        if (out.weakest.size() == most_places) break;
        const auto at = static_cast<size_t>(e);
        const std::array<int32_t, 3> p = place_of(g, e);
        WeakPlace w;
        bool far = true;
        for (size_t a = 0; a < 3; ++a)
            w.at_mm[a] = origin[a] + (p[a] + 0.5) * g.pitch_mm[a];
        for (const WeakPlace& other : out.weakest)
            far = far && std::hypot(w.at_mm[0] - other.at_mm[0], w.at_mm[1] - other.at_mm[1],
                                    w.at_mm[2] - other.at_mm[2]) >= apart;
        if (!far) continue;
        w.safety = static_cast<double>(fields.safety[at]);
        w.von_mises_MPa = static_cast<double>(fields.von_mises_MPa[at]);
        w.tension_MPa = static_cast<double>(fields.tension_MPa[at]);
        w.compression_MPa = static_cast<double>(fields.compression_MPa[at]);
        w.material = problem.voxels.code[at];
        w.across = static_cast<double>(across_about(problem, at)) / kAcrossStep;
        w.at_hold = at_hold[at];
        w.at_load = at_load[at];
        out.weakest.push_back(w);
    }
    return out;
}

Verdict verdict_of(const PartSummary& s) {
    if (!(s.most_von_mises_MPa > 0)) return Verdict::kNotStrained;
    if (!(s.least_safety > 0)) return Verdict::kUnknown;
    if (s.buckling && s.buckling->factor > 0 && s.buckling->factor < 1) return Verdict::kBuckles;
    if (s.least_safety_resolved > 0 && s.least_safety_resolved < 1) return Verdict::kBreaks;
    const bool weakest = s.least_safety_resolved == 0 || s.least_safety < s.least_safety_resolved;
    if (s.least_safety_unresolved > 0 && (weakest || s.least_safety_unresolved < 1))
        return Verdict::kUnresolved;
    if (s.least_safety_coarse > 0 && s.least_safety_coarse < 1) return Verdict::kCoarse;
    if ((s.least_safety_cut > 0 && s.least_safety_cut < 1) ||
        (s.buckling && s.buckling->factor > 0 && s.buckling->factor < s.buckling->excess))
        return Verdict::kCut;
    return Verdict::kHolds;
}

}  // namespace openfab::mechanics

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/stand/push.h"

#include <algorithm>
#include <cmath>

#include "mechanics/part/part_results.h"

namespace openfab::mechanics {

namespace {

/// Forces whose work on a displacement is the linear part of the von Mises stress around the mode's, in the
/// middle of the element that the mode strains most.
Field<double, kElastic> adjoint_load(const PartProblem& p, const Mode& mode) {
    const Grid& g = p.grid;
    Field<double, kElastic> out(g);
    const std::array<double, 6>& s = mode.stress_MPa;
    const double mean = (s[0] + s[1] + s[2]) / 3;
    const double d[3][3] = {
        {s[0] - mean, s[5], s[4]}, {s[5], s[1] - mean, s[3]}, {s[4], s[3], s[2] - mean}};
    double square = 0;
    for (const auto& row : d)
        for (const double v : row)
            square += v * v;
    const double mises = std::sqrt(1.5 * square);
    if (!(mises > 0)) return out;
    const auto e = static_cast<size_t>(mode.strained);
    // Of the solid in the element, as stresses are read; what is deviatoric does no work on what is not.
    const double mu = static_cast<double>(p.voxels.mu[e]) / static_cast<double>(p.voxels.solid[e]);
    const std::array<int32_t, 3> at = place_of(g, mode.strained);
    for (int corner = 0; corner < 8; ++corner) {
        const int32_t step[3] = {corner & 1, corner >> 1 & 1, corner >> 2 & 1};
        for (size_t c = 0; c < 3; ++c) {
            double force = 0;
            for (size_t a = 0; a < 3; ++a)
                force +=
                    2 * mu * (1.5 / mises) * d[c][a] * (step[a] ? 1 : -1) / (4 * g.pitch_mm[a]);
            out.row(static_cast<int>(c), at[1] + step[1], at[2] + step[2])[at[0] + step[0]] = force;
        }
    }
    return out;
}

}  // namespace

Push worst_push(PartProblem* problem, const Mode& mode, const SolveOptions& options) {
    PartProblem& p = *problem;
    const Grid& g = p.grid;
    Push out;
    Field<double, kElastic> forces = std::move(p.forces_N);
    p.forces_N = adjoint_load(p, mode);
    size_t holds = 0;
    for (const int32_t h : p.hold)
        holds = std::max(holds, static_cast<size_t>(h) + 1);
    const PartSolution adjoint = solve_part(&p, holds, options);
    p.forces_N = std::move(forces);
    out.stopped = adjoint.report.stopped;
    out.converged = adjoint.report.converged;
    if (out.stopped || !out.converged) return out;
    double longest = 0;
    for (size_t a = 0; a < 3; ++a)
        longest = std::max(longest, g.elements[a] * g.pitch_mm[a]);
    const double away = std::max(4 * *std::ranges::max_element(g.pitch_mm), 0.1 * longest);
    for (const Face& f : surface_of(g, p.elements.kind)) {
        const std::array<int32_t, 3> at = place_of(g, f.element);
        const size_t axis = f.direction / 2;
        const double inwards = f.direction % 2 == 1 ? -1 : 1;
        Vec3 middle;
        for (size_t a = 0; a < 3; ++a)
            middle[a] = p.voxels.origin_mm[a] + (at[a] + 0.5) * g.pitch_mm[a];
        if (std::hypot(middle[0] - mode.strained_at_mm[0], middle[1] - mode.strained_at_mm[1],
                       middle[2] - mode.strained_at_mm[2]) < away)
            continue;
        double work = 0;
        for (const int64_t node : nodes_of(g, f))
            work += inwards * moved_at(adjoint.moved_mm, node)[axis] / 4;
        // Pushed or pulled by the stress of the mode: both break it.
        if (std::abs(work) <= out.MPa_of_N) continue;
        out.MPa_of_N = std::abs(work);
        middle[axis] -= inwards * 0.5 * g.pitch_mm[axis];
        out.at_mm = middle;
        out.along = {};
        out.along[axis] = inwards;
    }
    // The surface is strained more than the middle, as much more as by the mode.
    if (const double middle = von_mises_of(mode.stress_MPa); middle > 0)
        out.MPa_of_N *= mode.von_mises_MPa / middle;
    const double strength =
        static_cast<double>(p.voxels.strength[static_cast<size_t>(mode.strained)]);
    if (strength > 0 && out.MPa_of_N > 0) out.breaks_at_N = strength / out.MPa_of_N;
    return out;
}

}  // namespace openfab::mechanics

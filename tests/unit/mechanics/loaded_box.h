// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Boxes of elements under a case of loads.

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <utility>

#include "mechanics/part/part_results.h"

namespace openfab::mechanics {

/// Elements of a box, each of the share and Young's modulus that a function of its middle gives.
inline Voxels box_of(std::array<int32_t, 3> size, double pitch, double poisson,
                     const std::function<std::pair<double, double>(const Vec3&)>& of) {
    Voxels v;
    v.size = size;
    v.pitch_mm = {pitch, pitch, pitch};
    v.materials = {"stuff"};
    for (int32_t z = 0; z < size[2]; ++z)
        for (int32_t y = 0; y < size[1]; ++y)
            for (int32_t x = 0; x < size[0]; ++x) {
                const auto [share, young] =
                    of({(x + 0.5) * pitch, (y + 0.5) * pitch, (z + 0.5) * pitch});
                Material m;
                m.young_MPa = young;
                m.poisson = poisson;
                v.solid.push_back(static_cast<float>(share));
                v.lambda.push_back(static_cast<float>(share * m.lambda()));
                v.mu.push_back(static_cast<float>(share * m.mu()));
                v.density.push_back(static_cast<float>(share));
                v.strength.push_back(100);
                v.code.push_back(share > 0 ? 1 : 0);
            }
    return v;
}

inline LoadCase parsed(const std::string& text) {
    const Result<LoadCase> c = parse_load_case("{\"cases\": {\"one\": " + text + "}}", "test", "");
    EXPECT_TRUE(c) << c.error().text();
    return c ? *c : LoadCase();
}

struct Solved {
    PartProblem problem;
    PartSolution solution;
};

inline Solved solved(Voxels voxels, const LoadCase& c, double tolerance = 1e-9,
                     const PartOptions& options_of_part = {}) {
    Solved out;
    Result<PartProblem> p = set_up_part(std::move(voxels), c, {}, options_of_part);
    EXPECT_TRUE(p) << p.error().text();
    if (!p) return out;
    out.problem = std::move(*p);
    SolveOptions options;
    options.tolerance = tolerance;
    out.solution = solve_part(&out.problem, c.held.size(), options);
    EXPECT_TRUE(out.solution.report.converged) << out.solution.report.residual;
    return out;
}

inline double moved(const Solved& s, int32_t x, int32_t y, int32_t z, size_t c) {
    const Grid& g = s.problem.grid;
    return moved_at(s.solution.moved_mm, (int64_t{z} * g.nodes[1] + y) * g.nodes[0] + x)[c];
}

}  // namespace openfab::mechanics

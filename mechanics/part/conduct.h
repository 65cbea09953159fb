// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Current or heat through a part: a voltage, or a temperature, at each node.

#include <string>
#include <vector>

#include "mechanics/part/pieces.h"
#include "mechanics/solver/conjugate_gradients.h"

namespace openfab::mechanics {

struct ConductProblem {
    Grid grid;
    Voxels voxels;  ///< with what is conducted as `conductivity`, S/m or W/(m K)
    PartElements elements;
    struct Kept {
        int64_t node;
        double level;
        int32_t hold;  ///< its place in the case's list
    };
    std::vector<Kept> kept;  ///< by node
    Field<double, kScalar> inflow;
    std::vector<std::string> notes;
};

/// `conductivity` of the voxels is what is conducted. Fails where nothing is kept at a level, or a flow
/// enters what is joined to none.
Result<ConductProblem> set_up_conduct(Voxels voxels, const LoadCase& load_case,
                                      std::span<const ObjectVoxels> objects);

/// Memory of all of it while it is solved.
int64_t conduct_bytes(const Grid& grid);

struct ConductSolution {
    Field<double, kScalar> level;  ///< V, or degrees
    SolveReport report;
    std::vector<double> flow_in;  ///< by each hold of the case, A or W
    double power_W = 0;           ///< of a current: what becomes heat
    std::vector<float> density;   ///< of elements, through the solid in them: A or W a mm2
};
ConductSolution solve_conduct(ConductProblem* problem, size_t holds, const SolveOptions& options);

}  // namespace openfab::mechanics

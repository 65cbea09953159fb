// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A part and a case of loads as what the solver takes.

#include <string>
#include <vector>

#include "mechanics/part/pieces.h"
#include "mechanics/solver/conjugate_gradients.h"

namespace openfab::mechanics {

struct PartOptions {
    bool loose = false;     ///< pieces that nothing holds are left out, however large they are
    bool thin = false;      ///< walls that the pitch does not resolve are taken as they come
    bool dithered = false;  ///< each element is a voxel of one material, among others
};

struct PartProblem {
    Grid grid;
    Voxels voxels;
    PartElements elements;
    std::vector<uint8_t> across;  ///< elements_across (across.h)
    double thin_share = 0;        ///< of the material, where less than two lie across
    std::vector<Held> held;       ///< by number of the degree of freedom
    std::vector<int32_t> hold;    ///< of each, its place in the case's list
    Field<double, kElastic> forces_N;
    Vec3 total_force_N{};
    std::vector<int64_t> load_nodes;  ///< sorted
    std::vector<std::string> notes;   ///< what a person should know
};

/// Fails where nothing is held, a load meets no face, a piece hangs free, or walls are lost.
Result<PartProblem> set_up_part(Voxels voxels, const LoadCase& load_case,
                                std::span<const ObjectVoxels> objects, const PartOptions& options);

/// Memory of all of it while it is solved.
int64_t part_bytes(const Grid& grid);

struct PartSolution {
    Field<double, kElastic> moved_mm;
    SolveReport report;
    double work_Nmm = 0;            ///< what is stored in the part
    std::vector<Vec3> reactions_N;  ///< of each hold of the case: what it does to the part
};
/// `full`: hexahedra that are integrated in full, as of other programs (ElementValues). Takes the
/// stiffness out of `problem` for its time and puts it back.
PartSolution solve_part(PartProblem* problem, size_t holds, const SolveOptions& options,
                        bool full = false);

}  // namespace openfab::mechanics

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The fixed-function stages between the fablet's amounts and the printer's slices, as Halide
// algorithms: normalise, dither, pack. Their arguments and buffer shapes are in
// runtime/abi/stage_table.h. What they compute is stated by their twins in tests/support/reference,
// which give the same bits; how they run is in schedules/.

#include <Halide.h>

#include <map>
#include <string>
#include <vector>

namespace openfab::stages {

/// An algorithm with everything that a schedule may name. Halide renames on clashes, so its own
/// names are never used.
struct Stage {
    std::string name;
    Halide::Pipeline pipeline;
    std::vector<Halide::Argument> inputs;
    std::map<std::string, Halide::Func> funcs;
    std::map<std::string, Halide::Var> vars;
    std::map<std::string, Halide::RVar> rvars;
};

/// `materials` is M, without void.
Stage normalise(int materials);
Stage dither(int materials);
/// 4 bits a voxel.
Stage pack();

/// The default schedule of each, the content of schedules/<stage>.sched.
void schedule_normalise(Stage* stage);
void schedule_dither(Stage* stage);
void schedule_pack(Stage* stage);

}  // namespace openfab::stages

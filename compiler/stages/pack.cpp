// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/stages/stages.h"

using namespace Halide;

namespace openfab::stages {

Stage pack() {
    Var z("z"), x("x"), y("y");
    ImageParam codes(UInt(8), 3, "codes");
    Func pairs("pairs"), planes("planes");
    pairs(z, x, y) = codes(z, 2 * x, y) | (codes(z, 2 * x + 1, y) << cast<uint8_t>(4));
    planes(x, y, z) = pairs(z, x, y);

    codes.dim(0).set_bounds(0, 8);
    codes.dim(1).set_min(0).set_stride(8);
    codes.dim(2).set_min(0);
    planes.bound(z, 0, 8);

    Stage stage;
    stage.name = "pack";
    stage.pipeline = Pipeline(planes);
    stage.inputs = {codes};
    stage.funcs = {{"pairs", pairs}, {"planes", planes}};
    stage.vars = {{"z", z}, {"x", x}, {"y", y}};
    return stage;
}

void schedule_pack(Stage* stage) {
    Var z = stage->vars["z"], x = stage->vars["x"], y = stage->vars["y"];
    Func planes = stage->funcs["planes"];
    planes.reorder(z, x, y).unroll(z);
    stage->funcs["pairs"].compute_at(planes, x).vectorize(z);
}

}  // namespace openfab::stages

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/stages/stages.h"

using namespace Halide;

namespace openfab::stages {

Stage pack(int bits) {
    Var z("z"), x("x"), y("y");
    ImageParam codes(UInt(8), 3, "codes");
    Func bytes("bytes"), planes("planes");
    if (bits == 4) {
        bytes(z, x, y) = codes(z, 2 * x, y) | (codes(z, 2 * x + 1, y) << cast<uint8_t>(4));
    } else {
        bytes(z, x, y) = codes(z, x, y);
    }
    planes(x, y, z) = bytes(z, x, y);

    codes.dim(0).set_bounds(0, 8);
    codes.dim(1).set_min(0).set_stride(8);
    codes.dim(2).set_min(0);
    planes.bound(z, 0, 8);

    Stage stage;
    stage.name = "pack";
    stage.pipeline = Pipeline(planes);
    stage.kernel = {planes,
                    {codes},
                    {{"planes", planes, {{"z", z}, {"x", x}, {"y", y}}},
                     {"bytes", bytes, {{"z", z}, {"x", x}, {"y", y}}}}};
    return stage;
}

}  // namespace openfab::stages

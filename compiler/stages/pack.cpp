// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/stages/stages.h"

using namespace Halide;

namespace openfab::stages {

Stage pack(int bits) {
    Var x("x"), y("y"), z("z");
    ImageParam columns(UInt(64), 2, "columns");
    Func bytes("bytes"), planes("planes");
    // A code has no more bits than are packed, so shifted bits stay in its byte.
    bytes(x, y) = bits == 4 ? columns(2 * x, y) | (columns(2 * x + 1, y) << cast<uint64_t>(4))
                            : columns(x, y);
    planes(x, y, z) = cast<uint8_t>(bytes(x, y) >> cast<uint64_t>(8 * z));

    columns.dim(0).set_min(0);
    columns.dim(1).set_min(0);
    planes.bound(z, 0, 8);

    Stage stage;
    stage.name = "pack";
    stage.pipeline = Pipeline(planes);
    stage.kernel = {planes,
                    {columns},
                    {{"planes", planes, {{"x", x}, {"y", y}, {"z", z}}},
                     {"bytes", bytes, {{"x", x}, {"y", y}}}}};
    return stage;
}

}  // namespace openfab::stages

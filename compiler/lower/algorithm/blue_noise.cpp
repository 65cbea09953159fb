// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/algorithm/blue_noise.h"

#include "abi/blue_noise.h"

namespace openfab::lower {

using Halide::cast;
using Halide::Expr;

void shape_blue_noise(Halide::ImageParam* mask) {
    mask->dim(0).set_bounds(0, 8).set_stride(1);
    mask->dim(1).set_bounds(0, static_cast<int>(abi::kBlueNoisePixels)).set_stride(8);
}

Expr blue_noise_threshold(const Halide::ImageParam& mask, int32_t face, const Expr& seed,
                          const std::array<Expr, 3>& lowest, const Halide::Var& lane) {
    using enum abi::BlueNoiseFace;
    constexpr auto kPixels = static_cast<int>(abi::kBlueNoisePixels);
    const auto side = static_cast<abi::BlueNoiseFace>(face);
    const abi::BlueNoiseShift<Expr> shift(seed, side);
    std::array<Expr, 3> index;
    // Halide's remainder is not negative.
    for (size_t axis = 0; axis < 3; ++axis)
        index.at(axis) = cast<uint32_t>(lowest.at(axis) % kPixels);
    const Expr& along = side == kLowX || side == kHighX ? index[1] : index[0];
    const Expr pixel = side == kInside ? shift.inside(index[0], index[1], index[2])
                                       : shift.upright(along, index[2]);
    const Expr rank =
        mask(lane, Halide::unsafe_promise_clamped(cast<int32_t>(pixel), 0, kPixels - 1));
    const Expr drift = abi::blue_noise_drift<Expr>(
        cast<uint32_t>(lowest[0]), cast<uint32_t>(lowest[1]), cast<uint32_t>(lowest[2]));
    const Expr turned = cast<uint32_t>(rank) + shift.turn + drift + cast<uint32_t>(lane);
    return cast<int32_t>(abi::blue_noise_threshold<Expr>(turned));
}

}  // namespace openfab::lower

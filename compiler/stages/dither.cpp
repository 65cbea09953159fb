// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/stages/stages.h"
#include "runtime/abi/stage_table.h"
#include "runtime/abi/voxel_hash.h"

using namespace Halide;

namespace openfab::stages {

// Floyd-Steinberg error diffusion (Floyd and Steinberg 1976) with the zero rule, in gather form.
// Each mixed voxel leaves what it could not place, divided by the weights of those forward
// neighbours that are mixed; a later voxel takes 7, 3, 5 or 1 parts of that from its own neighbours
// behind it, if they are mixed. The masks alone decide who takes from whom, so what stands in
// `error` at a voxel that is not mixed never matters as long as it is finite.
//
// Fractions and errors are counted in 1/65535. The order of the float operations, which the twin in
// tests/support/reference follows, is
//     v = (((fraction + w_se * e_se) + w_s * e_s) + w_sw * e_sw) + w_e * e_e
//     e = (v - (chosen ? 65535 : 0)) * (1 / max(w_forward, 1))
// with w_e last because only that term waits for the voxel just before in the row.
Stage dither(int materials) {
    Var z("z"), x("x"), p("p");
    ImageParam fractions(UInt(16), 5, "fractions");
    ImageParam tiles(Int(32), 1, "tiles");
    ImageParam above(UInt(8), 1, "above"), here(UInt(8), 1, "here"), below(UInt(8), 1, "below");
    Param<int32_t> first_x("first_x"), row("y_row"), lowest_z("z_lowest"), parity("parity");
    Param<uint32_t> seed("seed");
    const int channels = materials + 1;

    RDom run(0, 8, 0, tiles.dim(0).extent(), "run");
    const Expr vx = first_x + 8 * run.y + run.x;
    const Expr other = 1 - parity;
    // The clamp tells Halide the bounds of what an index from memory reads.
    const Expr tile = clamp(tiles(run.y), 0, fractions.dim(4).extent() - 1);

    const auto is_mixed = [&](const ImageParam& mask, const Expr& at) {
        return (cast<int32_t>(mask(at)) & (1 << z)) != 0;
    };
    // Weights of the neighbours behind, from which this voxel takes, and of those ahead.
    const Expr w_e = select(is_mixed(here, vx - 1), 7.0f, 0.0f);
    const Expr w_se = select(is_mixed(above, vx - 1), 1.0f, 0.0f);
    const Expr w_s = select(is_mixed(above, vx), 5.0f, 0.0f);
    const Expr w_sw = select(is_mixed(above, vx + 1), 3.0f, 0.0f);
    const Expr behind = cast<int32_t>(here(vx - 1) | above(vx - 1) | above(vx) | above(vx + 1));
    const Expr received = (behind & (1 << z)) != 0;
    const Expr ahead = select(is_mixed(here, vx + 1), 7, 0) +
                       select(is_mixed(below, vx - 1), 3, 0) + select(is_mixed(below, vx), 5, 0) +
                       select(is_mixed(below, vx + 1), 1, 0);
    const Expr hand_on = 1.0f / cast<float>(max(ahead, 1));

    Func error("error");
    std::vector<Expr> undefined(static_cast<size_t>(channels), undef<float>());
    undefined.push_back(undef<uint8_t>());
    error(z, x, p) = Tuple(undefined);

    std::vector<Expr> value(static_cast<size_t>(channels));
    std::vector<Expr> fraction(static_cast<size_t>(channels));
    for (int m = 0; m < channels; ++m) {
        const auto k = static_cast<size_t>(m);
        fraction[k] = cast<int32_t>(fractions(z, m, run.x, row & 7, tile));
        value[k] = cast<float>(fraction[k]) + w_se * error(z, vx - 1, other)[m];
        value[k] = value[k] + w_s * error(z, vx, other)[m];
        value[k] = value[k] + w_sw * error(z, vx + 1, other)[m];
        value[k] = value[k] + w_e * error(z, vx - 1, parity)[m];
    }

    // The largest value wins, the first of equals, among materials that are present.
    Expr best = select(fraction[0] > 0, value[0], -std::numeric_limits<float>::infinity());
    Expr choice = 0;
    const Expr hash = abi::voxel_hash<Expr>(cast<uint32_t>(vx), cast<uint32_t>(row),
                                            cast<uint32_t>(lowest_z + z), seed);
    const Expr threshold = cast<int32_t>(abi::fraction_threshold<Expr>(hash));
    Expr sum = fraction[0];
    Expr start = select(sum > threshold, 0, 1);
    for (size_t k = 1; k < value.size(); ++k) {
        const Expr wins = fraction[k] > 0 && value[k] > best;
        choice = select(wins, static_cast<int>(k), choice);
        best = select(wins, value[k], best);
        // The start's choice is the number of materials whose running sum does not exceed the
        // threshold; the last sum is 65535 and always does.
        if (k + 1 < value.size()) {
            sum = sum + fraction[k];
            start = start + select(sum > threshold, 0, 1);
        }
    }
    choice = select(received, choice, start);

    std::vector<Expr> next(static_cast<size_t>(channels));
    for (int m = 0; m < channels; ++m) {
        const auto k = static_cast<size_t>(m);
        next[k] = (value[k] - select(choice == m, 65535.0f, 0.0f)) * hand_on;
    }
    next.push_back(
        select(is_mixed(here, vx), cast<uint8_t>(choice), error(z, vx, parity)[channels]));
    error(z, vx, parity) = Tuple(next);

    fractions.dim(0).set_bounds(0, 8);
    fractions.dim(1).set_bounds(0, channels).set_stride(8);
    fractions.dim(2).set_bounds(0, 8).set_stride(8 * channels);
    fractions.dim(3).set_bounds(0, 8).set_stride(64 * channels);
    fractions.dim(4).set_min(0);
    tiles.dim(0).set_min(0);
    error.bound(z, 0, 8).bound(p, 0, 2);

    Stage stage;
    stage.name = "dither";
    stage.pipeline = Pipeline(error);
    stage.kernel = {error,
                    {fractions, tiles, above, here, below, first_x, row, lowest_z, seed, parity},
                    {{"error", error, {{"z", z}, {"x", x}, {"p", p}}}}};
    return stage;
}

}  // namespace openfab::stages

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/stages/stages.h"
#include "runtime/abi/dither_rules.h"
#include "runtime/abi/stage_table.h"
#include "runtime/abi/voxel_hash.h"

using namespace Halide;

namespace openfab::stages {

// Error diffusion with the zero rule, in gather form. Each mixed voxel leaves what it could not
// place, divided by the weights of those forward neighbours that are mixed; a later voxel takes 7,
// 3, 5 or 1 parts of that from its own neighbours behind it, if they are mixed. The masks alone
// decide who takes from whom, so what stands in `error` at a voxel that is not mixed never matters
// as long as it is finite.
//
// Fractions and errors are counted in 1/65535. The order of the float operations, which the twin in
// tests/support/reference follows, is
//     v = (((fraction + w_se * e_se) + w_s * e_s) + w_sw * e_sw) + w_e * e_e
//     e = ((v - (chosen ? 65535 : 0)) [+ phase]) * (1 / max(w_forward, 1))
// with w_e last because only that term waits for the voxel just before in the row.

namespace {

using Exprs = std::vector<Expr>;

/// What the rules decide from, in one voxel.
struct Voxel {
    Exprs fraction;  ///< int32
    Exprs value;     ///< fractions with the errors received
    Expr received;   ///< a neighbour behind is mixed
    Expr interior;   ///< all four are
    Expr hash;       ///< uint32
};

struct Decision {
    Expr choice;
    Exprs phase;  ///< added to what is handed on; empty: nothing
};

/// Floyd and Steinberg 1976: the largest value wins, the first of equals, among materials that are
/// present; where nothing was received, the hash decides.
Decision floyd_steinberg(const Voxel& voxel) {
    const Exprs& fraction = voxel.fraction;
    const Exprs& value = voxel.value;
    Expr best = select(fraction[0] > 0, value[0], -std::numeric_limits<float>::infinity());
    Expr choice = 0;
    const Expr threshold = cast<int32_t>(abi::fraction_threshold<Expr>(voxel.hash));
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
    return {select(voxel.received, choice, start), {}};
}

/// The first material at which the running sum of what each value has above a floor exceeds a
/// random share of the whole sum. Why the floor is what it is: abi/dither_rules.h.
Decision decorrelated(const Voxel& voxel) {
    const size_t channels = voxel.value.size();
    const Expr floor = select(
        voxel.received,
        select(voxel.interior, abi::kDecorrelatedInteriorFloor, abi::kDecorrelatedBorderFloor),
        0.0f);
    Exprs weight(channels), sum(channels);
    for (size_t k = 0; k < channels; ++k) {
        const Expr above = voxel.value[k] - floor;
        const Expr least = cast<float>(voxel.fraction[k]) * abi::kDecorrelatedLeast;
        weight[k] = select(voxel.fraction[k] > 0, select(above > least, above, least), 0.0f);
        sum[k] = k == 0 ? weight[k] : sum[k - 1] + weight[k];
    }
    const Expr share = cast<float>(cast<int32_t>(voxel.hash >> 16)) * 0x1p-16f;
    const Expr threshold = share * sum.back();
    Expr choice = 0;
    for (size_t k = 0; k + 1 < channels; ++k)
        choice = choice + select(sum[k] > threshold, 0, 1);

    // A start's phase: all present materials but the most frequent get a random one, which that one
    // takes back.
    Expr most = voxel.fraction[0], largest = 0;
    for (size_t k = 1; k < channels; ++k) {
        largest = select(voxel.fraction[k] > most, static_cast<int>(k), largest);
        most = max(most, voxel.fraction[k]);
    }
    Exprs phase(channels);
    Expr all = 0;
    for (size_t k = 0; k < channels; ++k) {
        const Expr random = cast<int32_t>(abi::phase_hash<Expr>(voxel.hash, k) >> 16) - 32768;
        phase[k] = select(voxel.fraction[k] > 0 && largest != static_cast<int>(k), random, 0);
        all = all + phase[k];
    }
    for (size_t k = 0; k < channels; ++k) {
        const Expr own = select(largest == static_cast<int>(k), -all, phase[k]);
        phase[k] = select(voxel.received, 0.0f, cast<float>(own));
    }
    return {choice, phase};
}

}  // namespace

Stage dither(int materials, DitherRule rule) {
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
    const auto bits_behind = [&](const Expr& together) {
        return (cast<int32_t>(together) & (1 << z)) != 0;
    };
    const Expr ahead = select(is_mixed(here, vx + 1), 7, 0) +
                       select(is_mixed(below, vx - 1), 3, 0) + select(is_mixed(below, vx), 5, 0) +
                       select(is_mixed(below, vx + 1), 1, 0);
    const Expr hand_on = 1.0f / cast<float>(max(ahead, 1));

    Func error("error");
    Exprs undefined(static_cast<size_t>(channels), undef<float>());
    undefined.push_back(undef<uint8_t>());
    error(z, x, p) = Tuple(undefined);

    Voxel voxel;
    voxel.received = bits_behind(here(vx - 1) | above(vx - 1) | above(vx) | above(vx + 1));
    voxel.interior = bits_behind(here(vx - 1) & above(vx - 1) & above(vx) & above(vx + 1));
    voxel.hash = abi::voxel_hash<Expr>(cast<uint32_t>(vx), cast<uint32_t>(row),
                                       cast<uint32_t>(lowest_z + z), seed);
    for (int m = 0; m < channels; ++m) {
        voxel.fraction.push_back(cast<int32_t>(fractions(z, m, run.x, row & 7, tile)));
        Expr value = cast<float>(voxel.fraction.back()) + w_se * error(z, vx - 1, other)[m];
        value = value + w_s * error(z, vx, other)[m];
        value = value + w_sw * error(z, vx + 1, other)[m];
        voxel.value.push_back(value + w_e * error(z, vx - 1, parity)[m]);
    }
    const Decision decision =
        rule == DitherRule::kFloydSteinberg ? floyd_steinberg(voxel) : decorrelated(voxel);
    Exprs next;
    for (int m = 0; m < channels; ++m) {
        const auto k = static_cast<size_t>(m);
        Expr left = voxel.value[k] - select(decision.choice == m, 65535.0f, 0.0f);
        if (!decision.phase.empty()) left = left + decision.phase[k];
        next.push_back(left * hand_on);
    }
    next.push_back(
        select(is_mixed(here, vx), cast<uint8_t>(decision.choice), error(z, vx, parity)[channels]));
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

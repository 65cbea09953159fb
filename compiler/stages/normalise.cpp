// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/algorithm/normalise.h"

#include "compiler/stages/stages.h"

using namespace Halide;

namespace openfab::stages {

Stage normalise() {
    Var z("z"), column("column"), slot("slot"), channel("channel");
    ImageParam groups(Int(32), 1, "groups");
    ImageParam channels(Int(32), 2, "channels");
    ImageParam weights(Float(32), 3, "weights");
    const Expr slots = weights.dim(2).extent();

    Func amounts("amounts");
    const Expr from = unsafe_promise_clamped(groups(column), 0, weights.dim(1).extent() - 1);
    amounts(z, slot, column) = weights(z, from, slot);
    const lower::Normalised normalised = lower::normalise(amounts, slots, channels, z, column);

    Func fractions("fractions"), codes("codes"), counts("counts");
    fractions(z, channel, column) = normalised.fraction(channel);
    codes(z, column) = normalised.code;
    counts(z, column) = normalised.unusable;

    groups.dim(0).set_min(0);
    lower::shape_channels(&channels, slots);
    weights.dim(0).set_bounds(0, 8);
    weights.dim(1).set_min(0).set_stride(8);
    weights.dim(2).set_min(0);
    for (Func f : {fractions, codes, counts})
        f.bound(z, 0, 8);
    fractions.bound(channel, 0, slots + 1);
    fractions.output_buffer().dim(1).set_stride(8);
    // One loop over columns makes all that is of a column.
    counts.compute_with(codes, column);
    codes.compute_with(fractions, column);

    Stage stage;
    stage.name = "normalise";
    stage.pipeline = Pipeline({fractions, codes, counts});
    using Vars = std::vector<std::pair<std::string, Var>>;
    const Vars voxel{{"z", z}, {"column", column}};
    stage.kernel = {fractions,
                    {groups, channels, weights},
                    {{"fractions", fractions, {{"z", z}, {"channel", channel}, {"column", column}}},
                     {"codes", codes, voxel},
                     {"counts", counts, voxel}}};
    auto& funcs = stage.kernel.funcs;
    funcs.insert(funcs.end(), normalised.funcs.begin(), normalised.funcs.end());
    funcs.push_back({"amounts", amounts, {{"z", z}, {"slot", slot}, {"column", column}}});
    return stage;
}

}  // namespace openfab::stages

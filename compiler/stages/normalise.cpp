// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include "abi/stage_table.h"
#include "compiler/stages/stages.h"

using namespace Halide;

namespace openfab::stages {

namespace {

// Above this the slots' amounts are scaled down by a power of two before they are summed, so that
// no sum can overflow in any order. An infinite amount is then replaced by one far larger than any
// finite one, and any number of them can be summed.
constexpr float kLargeSum = 0x1p127f;
constexpr float kScaledDown = 0x1p-64f;
constexpr float kInsteadOfInfinity = 0x1p100f;

// Comparisons are written with > and == only: Halide's >= is true on NaN.
Expr usable(const Expr& weight) {
    return weight > 0.0f || weight == 0.0f;
}
Expr amount(const Expr& weight) {
    return select(weight > 0.0f, weight, 0.0f);
}

Expr owned_bit(const ImageParam& owned, const Var& x, const Var& y, const Var& n, const Var& z) {
    return (cast<int32_t>(owned(x, y, n)) & (1 << z)) != 0;
}

}  // namespace

Stage normalise(int materials) {
    Var z("z"), x("x"), y("y"), m("m"), n("n");
    ImageParam weights(Float(32), 5, "weights");
    ImageParam slot_material(Int(32), 1, "slot_material");
    ImageParam owned(UInt(8), 3, "owned");
    const float infinity = std::numeric_limits<float>::infinity();

    RDom slot(weights.dim(3).min(), weights.dim(3).extent(), "slot");
    const Expr clean = amount(weights(z, x, y, slot, n));
    Func total("total"), scale("scale"), sums("sums");
    total(z, x, y, n) = 0.0f;
    total(z, x, y, n) += clean;
    scale(z, x, y, n) = select(total(z, x, y, n) > kLargeSum, kScaledDown, 1.0f);

    // An infinite amount outweighs every finite one; several share evenly.
    const Expr scaled = select(clean == infinity, kInsteadOfInfinity, clean * scale(z, x, y, n));
    sums(z, x, y, m, n) = 0.0f;
    sums(z, x, y, clamp(slot_material(slot), 0, materials), n) += scaled;

    Expr all = sums(z, x, y, 0, n);
    for (int k = 1; k <= materials; ++k)
        all = all + sums(z, x, y, k, n);
    Func whole("whole");
    whole(z, x, y, n) = all;

    Func rounded("rounded");
    const Expr share = 65535.0f * (sums(z, x, y, m, n) / whole(z, x, y, n));
    // No share is negative, so the cast is the floor.
    rounded(z, x, y, m, n) =
        select(whole(z, x, y, n) > 0.0f, cast<int32_t>(share + 0.5f), select(m == 0, 65535, 0));

    // The rounding remainder goes to the largest fraction; ties go to the first.
    Expr rest = 65535 - rounded(z, x, y, 0, n);
    Expr largest = 0;
    Expr most = rounded(z, x, y, 0, n);
    for (int k = 1; k <= materials; ++k) {
        const Expr q = rounded(z, x, y, k, n);
        rest = rest - q;
        largest = select(q > most, k, largest);
        most = select(q > most, q, most);
    }
    Func remainder("remainder");
    remainder(z, x, y, n) = Tuple(most + rest, largest);
    Func fractions("fractions");
    fractions(z, m, x, y, n) = cast<uint16_t>(
        select(m == remainder(z, x, y, n)[1], remainder(z, x, y, n)[0], rounded(z, x, y, m, n)));

    // Fractions sum to 65535: if one is 65535, the others are 0.
    Expr after_pure = 0;
    for (int k = 0; k <= materials; ++k) {
        after_pure =
            after_pure + select(fractions(z, k, x, y, n) == cast<uint16_t>(65535), k + 1, 0);
    }
    Func codes("codes");
    codes(z, x, y, n) =
        cast<uint8_t>(select(!owned_bit(owned, x, y, n, z), 0,
                             select(after_pure == 0, OPENFAB_CODE_MIXED, after_pure - 1)));

    RDom voxel(0, weights.dim(3).extent(), 0, 8, 0, 8, "voxel");
    Func unusable("unusable");
    const Expr bit = (cast<int32_t>(owned(voxel.y, voxel.z, n)) & (1 << z)) != 0;
    unusable(z, n) = 0;
    unusable(z, n) += select(bit && !usable(weights(z, voxel.y, voxel.z, voxel.x, n)), 1, 0);

    for (int d = 0; d < 5; ++d) {
        if (d != 3) weights.dim(d).set_min(0);
    }
    weights.dim(0).set_stride(1);
    weights.dim(1).set_stride(8);
    weights.dim(2).set_stride(64);
    weights.dim(3).set_bounds(0, weights.dim(3).extent());
    fractions.output_buffer().dim(1).set_stride(8);
    fractions.output_buffer().dim(2).set_stride(8 * (materials + 1));
    fractions.output_buffer().dim(3).set_stride(64 * (materials + 1));

    for (Func f : {fractions, codes})
        f.bound(z, 0, 8).bound(x, 0, 8).bound(y, 0, 8);
    fractions.bound(m, 0, materials + 1);
    unusable.bound(z, 0, 8);

    Stage stage;
    stage.name = "normalise";
    stage.pipeline = Pipeline({fractions, codes, unusable});
    using Vars = std::vector<std::pair<std::string, Var>>;
    const Vars voxel_vars{{"z", z}, {"x", x}, {"y", y}, {"n", n}};
    const Vars material_vars{{"z", z}, {"x", x}, {"y", y}, {"m", m}, {"n", n}};
    stage.kernel = {fractions,
                    {weights, slot_material, owned},
                    {{"codes", codes, voxel_vars},
                     {"unusable", unusable, {{"z", z}, {"n", n}}},
                     {"fractions", fractions, material_vars},
                     {"remainder", remainder, voxel_vars},
                     {"rounded", rounded, material_vars},
                     {"whole", whole, voxel_vars},
                     {"sums", sums, material_vars},
                     {"scale", scale, voxel_vars},
                     {"total", total, voxel_vars}}};
    return stage;
}

}  // namespace openfab::stages

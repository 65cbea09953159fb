// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/algorithm/normalise.h"

#include <limits>

#include "abi/stage_table.h"
#include "compiler/lower/algorithm/constant.h"

namespace openfab::lower {

namespace {

using Halide::cast;
using Halide::Expr;
using Halide::Func;
using Halide::RDom;
using Halide::select;
using Halide::Tuple;
using Halide::Var;

// Above this the slots' amounts are scaled down before they are added up, by a power of two, so
// that no later sum can overflow, in whatever order it is taken. An infinite amount is then
// replaced by one far larger than any finite one, and any number of them can be added up.
constexpr float kLargeSum = 0x1p127f;
constexpr float kScaledDown = 0x1p-64f;
constexpr float kInsteadOfInfinity = 0x1p100f;

// Loops over up to so many slots are written out, which keeps sums in registers. Code for more
// would take longer to compile than it could save.
constexpr int64_t kMostUnrolledSlots = 16;

/// A comparison of floats that may be NaN or infinite. The target feature marks float results only:
/// without the wrapper LLVM may assume that there are none, and does where a schedule lets it.
Expr compared(const Expr& comparison) {
    return Halide::strict_float(comparison);
}

/// What counts of a slot's amount: itself, or 0 where it is negative or NaN. (Written with > as
/// Halide's >= is true on NaN.)
Expr amount(const Expr& weight) {
    return select(compared(weight > 0.0f), weight, 0.0f);
}

/// The table of channels.
struct Channels {
    const Halide::ImageParam& table;
    Expr slots;

    Expr slot(const Expr& channel) const {
        return Halide::unsafe_promise_clamped(table(OPENFAB_CHANNEL_SLOT, channel), 0, slots - 1);
    }
    Expr joins(const Expr& channel) const { return table(OPENFAB_CHANNEL_JOINS, channel) != 0; }
    Expr material(const Expr& channel) const { return table(OPENFAB_CHANNEL_MATERIAL, channel); }
};

}  // namespace

Expr Normalised::fraction(const Expr& channel) const {
    const Channels of{channels, {}};
    const Func left = remainder;
    return cast<uint16_t>(select(of.material(channel) == left(lane, column)[2],
                                 left(lane, column)[0] + left(lane, column)[1],
                                 rounded(lane, channel, column)));
}

Expr Normalised::material(const Expr& channel) const {
    return Channels{channels, {}}.material(channel);
}

Expr Normalised::largest() const {
    const Func left = remainder;
    return left(lane, column)[2];
}

void shape_channels(Halide::ImageParam* channels, const Expr& slots) {
    channels->dim(0).set_bounds(0, 3).set_stride(1);
    channels->dim(1).set_bounds(0, slots + 1).set_stride(3);
}

Normalised normalise(const Func& amounts, const Expr& slots, const Halide::ImageParam& channels,
                     const Var& lane, const Var& column) {
    const Var slot_var("slot"), channel_var("channel");
    const Channels of{channels, slots};
    const float infinity = std::numeric_limits<float>::infinity();
    const RDom slot(0, slots, "slot"), channel(0, slots + 1, "channel");

    Func total("total"), scaled("scaled"), sums("sums"), whole("whole"), rounded("rounded"),
        remainder("remainder"), unusable("unusable");
    total(lane, column) = 0.0f;
    total(lane, column) += amount(amounts(lane, slot, column));

    // An infinite amount outweighs every finite one; several share evenly.
    const Expr clean = amount(amounts(lane, slot_var, column));
    scaled(lane, slot_var, column) =
        select(compared(clean == infinity), kInsteadOfInfinity,
               clean * select(compared(total(lane, column) > kLargeSum), kScaledDown, 1.0f));

    sums(lane, channel_var, column) = 0.0f;
    sums(lane, slot + 1, column) = select(of.joins(slot + 1), sums(lane, slot, column), 0.0f) +
                                   scaled(lane, of.slot(slot + 1), column);
    const auto sum = [&](const Expr& c) {
        return select(of.material(c) >= 0, sums(lane, c, column), 0.0f);
    };
    whole(lane, column) = 0.0f;
    whole(lane, column) += sum(channel);

    const Expr share = 65535.0f * (sum(channel_var) / whole(lane, column));
    // No share is negative, so the cast is the floor. Channel 0 has no slot of its own.
    rounded(lane, channel_var, column) =
        select(whole(lane, column) > 0.0f, select(channel_var == 0, 0, cast<int32_t>(share + 0.5f)),
               select(of.material(channel_var) == 0, 65535, 0));

    // The rounding's remainder goes to the largest fraction; ties go to the first.
    remainder(lane, column) = Tuple(65535, -1, 0);
    const Expr rest = remainder(lane, column)[0], most = remainder(lane, column)[1],
               largest = remainder(lane, column)[2], q = rounded(lane, channel, column);
    remainder(lane, column) =
        Tuple(rest - q, select(q > most, q, most), select(q > most, of.material(channel), largest));

    unusable(lane, column) = cast<uint16_t>(0);
    const Expr given = amounts(lane, slot, column);
    unusable(lane, column) += cast<uint16_t>(select(compared(amount(given) == given), 0, 1));

    // What is written out cannot be inlined: unless a schedule places it, it is computed at root.
    // Where its size is known at run time only, Halide takes it from memory that the kernel keeps.
    for (const Func& f : {total, scaled, sums, whole, rounded, remainder, unusable})
        Func(f).compute_root().store_in(Halide::MemoryType::Stack);
    if (const std::optional<int64_t> count = integer_constant(slots);
        count && *count <= kMostUnrolledSlots) {
        for (const Func& f : {total, sums, unusable})
            Func(f).update().unroll(slot);
        for (const Func& f : {whole, remainder})
            Func(f).update().unroll(channel);
        scaled.unroll(slot_var);
        sums.unroll(channel_var);
        rounded.unroll(channel_var);
    }

    Normalised out;
    // Fractions add up to 65535: where one is all of that, it is the largest.
    out.code =
        cast<uint8_t>(select(remainder(lane, column)[0] + remainder(lane, column)[1] == 65535,
                             remainder(lane, column)[2], OPENFAB_CODE_MIXED));
    out.unusable = unusable(lane, column);
    out.rounded = rounded;
    out.remainder = remainder;
    out.channels = channels;
    out.lane = lane;
    out.column = column;
    using Vars = std::vector<std::pair<std::string, Var>>;
    const Vars voxel{{lane.name(), lane}, {column.name(), column}};
    const Vars by_slot{{lane.name(), lane}, {"slot", slot_var}, {column.name(), column}};
    const Vars by_channel{{lane.name(), lane}, {"channel", channel_var}, {column.name(), column}};
    out.funcs = {{"unusable", unusable, voxel},    {"remainder", remainder, voxel},
                 {"rounded", rounded, by_channel}, {"whole", whole, voxel},
                 {"sums", sums, by_channel},       {"scaled", scaled, by_slot},
                 {"total", total, voxel}};
    return out;
}

}  // namespace openfab::lower

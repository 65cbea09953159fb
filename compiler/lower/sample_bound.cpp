// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The interval form of lookups in pictures and volumes: the range of all lookups in a box of
// coordinates and footprints, from the min-max pyramid.

#include "compiler/lower/sample_parts.h"

namespace openfab::lower {

namespace {

using ir::Type;

// Coordinates beyond these get the range of the whole image.
constexpr float kFarthestCoordinate = 1024.0f;
constexpr float kWidestFootprint = 65536.0f;
// Rounding of interpolation, of sums over taps and of the coarser levels themselves, relative to
// the largest magnitude.
constexpr float kRoundingSlack = 1.0f / 262144.0f;

/// Range of texel indices of level 0 along one axis that a lookup may touch.
struct Extent {
    Value lo, hi;  ///< int, inside the level
    Value inside;  ///< nothing outside [0, n) is touched before wrapping
    Value size;    ///< float, in texels
};

/// `reach`: texels of level 0 added at both ends. Under repeat, whole periods are subtracted first.
Extent make_extent(const Texture& texture, const Value& lo, const Value& hi, const Value& n,
                   const Value& reach) {
    const Value size = to_float(n);
    const Value shift = select(texture.wrap_is(kWrapRepeat), floor(lo), constant(0.0f));
    const Value first = (lo - shift) * size - reach;
    const Value end = (hi - shift) * size + reach;
    Extent out;
    out.inside = both(first >= constant(0.0f), end < size);
    const Value last = size - constant(1.0f);
    out.lo = convert(floor(bound(first, 0.0f, last)), Type::kInt);
    out.hi = convert(floor(bound(end, 0.0f, last)), Type::kInt);
    out.size = end - first;
    return out;
}

Value power_of_two(const Value& exponent) {
    const Value shifted = operate(ir::Op::kShl, {exponent + constant(127), constant(23)});
    return bits_float(convert(shifted, Type::kUint));
}

Value at_least_ceil_log2(const Value& x) {
    return whole_to_int(ceil(log2_of(x) + constant(0.001f)));
}

/// A box of coordinates along one axis, in widths of the texture, and how far one step of each of
/// the three axes goes, in texels of level 0.
struct BoxAxis {
    Value lo, hi;
    std::array<Value, 3> steps;
};

/// `args` of SampleBound by axis.
std::vector<BoxAxis> box_axes(const Texture& texture, const std::vector<Value>& args) {
    const auto axes = static_cast<size_t>(texture.axes());
    std::vector<BoxAxis> out;
    for (size_t a = 0; a < axes; ++a) {
        const auto axis = static_cast<int32_t>(a);
        const Value n = to_float(texture.side(constant(0), axis));
        BoxAxis box{args[1 + 2 * a], args[2 + 2 * a], {}};
        for (size_t k = 0; k < 3; ++k)
            box.steps[k] = args[2 + 2 * axes + 3 * a + k] * n;
        if (axes == 3) {
            // Computed as in a lookup; rounding is monotone.
            box.lo = (box.lo - texture.origin(axis)) / texture.extent(axis);
            box.hi = (box.hi - texture.origin(axis)) / texture.extent(axis);
            for (Value& step : box.steps)
                step = step / texture.extent(axis);
        }
        out.push_back(box);
    }
    return out;
}

/// The least texel range that holds every lookup of the box, by level of the min-max pyramid.
struct Region {
    Value level;
    std::vector<std::array<Value, 2>> ends;  ///< by axis
    Value touches_outside;
};

Region make_region(const Texture& texture, const std::vector<Value>& args) {
    const std::vector<BoxAxis> box = box_axes(texture, args);
    Value square = constant(0.0f);
    for (const BoxAxis& axis : box) {
        for (const Value& step : axis.steps)
            square = square + step * step;
    }
    // The major width is at most the root of the trace; a tenth of a percent covers all rounding.
    const Value& width = args[1 + 2 * box.size()];
    Value widest = sqrt(square) * width * constant(1.001f);
    if (texture.axes() == 3)
        widest = select(texture.filter_is(texture::kFilterFinest), constant(0.0f), widest);
    const Value major = bound(widest, 0.0f, kWidestFootprint);
    const Value top = texture.levels() - constant(1);
    const Value coarsest = least(at_least_ceil_log2(most(major, constant(1.0f))), top);
    // Half the taps' length, and of the coarsest level one texel each for interpolation, for levels
    // whose sides are not halves of those below, and for slack.
    const Value reach = major * constant(0.5f) + constant(3.0f) * power_of_two(coarsest);
    std::vector<Extent> extents;
    Value known = widest < constant(kWidestFootprint);
    Value inside = constant_bits(Type::kBool, 1);
    Value longest = constant(1.0f);
    for (size_t a = 0; a < box.size(); ++a) {
        const Value n = texture.side(constant(0), static_cast<int32_t>(a));
        extents.push_back(make_extent(texture, box[a].lo, box[a].hi, n, reach));
        for (const Value& end : {box[a].lo, box[a].hi})
            known = both(known, absolute(end) < constant(kFarthestCoordinate));
        inside = both(inside, extents[a].inside);
        longest = most(longest, extents[a].size);
    }
    const Value clamps = invert(texture.wrap_is(kWrapRepeat) | texture.wrap_is(kWrapMirror));
    known = both(known, clamps | inside);

    Region out;
    out.level = select(known, least(at_least_ceil_log2(longest), top), top);
    const Value shift = least(out.level, constant(31));
    for (const Extent& extent : extents) {
        out.ends.push_back({select(known, operate(ir::Op::kShr, {extent.lo, shift}), constant(0)),
                            select(known, operate(ir::Op::kShr, {extent.hi, shift}), constant(0))});
    }
    out.touches_outside = invert(both(known, inside));
    return out;
}

/// Minimum and maximum of the texels at the corners of the region.
std::array<Value, 2> corner_range(const Texture& texture, const Region& region, int32_t channel) {
    const Value offset = texture.minmax(region.level);
    Value lo;
    Value hi;
    for (uint32_t corner = 0; corner < 1u << region.ends.size(); ++corner) {
        Value texel = constant(0);
        for (size_t a = region.ends.size(); a-- > 0;) {
            const Value side = texture.side(region.level, static_cast<int32_t>(a));
            texel = texel * side + region.ends[a][corner >> a & 1u];
        }
        const Value index =
            offset + (texel * texture.channels() + texture.channel(channel)) * constant(2);
        const Value least_here = texture.at(index);
        const Value most_here = texture.at(index + constant(1));
        lo = corner == 0 ? least_here : least(lo, least_here);
        hi = corner == 0 ? most_here : most(hi, most_here);
    }
    return {lo, hi};
}

}  // namespace

std::array<Value, 2> lower_sample_bound(LoweringContext* context, int32_t texture_index,
                                        int32_t channel, const std::vector<Value>& args) {
    constexpr size_t kVolumeArgs = 17;
    const Texture texture(context, texture_index, OPENFAB_TEXTURE_MINMAX,
                          args.size() == kVolumeArgs ? 3 : 2);
    const Region region = make_region(texture, args);
    auto [lo, hi] = corner_range(texture, region, channel);
    const Value zero = constant(0.0f);
    const Value one = constant(1.0f);
    const Value black = both(texture.wrap_is(kWrapBlack), region.touches_outside);
    lo = select(black, least(lo, zero), lo);
    hi = select(black, most(hi, zero), hi);

    // A constant region gives exactly its value where eight copies of it add up without rounding.
    // Elsewhere results may pass the ends by rounding, but never 0 from above or below, nor 1 from
    // below.
    const Value slack = most(absolute(lo), absolute(hi)) * constant(kRoundingSlack);
    const Value low_bits = float_bits(lo) & constant_bits(Type::kUint, 7);
    const Value flat = both(lo == hi, low_bits == constant_bits(Type::kUint, 0));
    const Value below = lo - slack;
    const Value above = hi + slack;
    const Value lower = select(lo >= zero, most(below, zero), below);
    const Value upper =
        select(hi > zero, select(hi > one, above, least(above, one)), least(above, zero));
    const Value absent = texture.channel_missing(channel);
    const Value constant_channel = constant(channel == 3 ? 1.0f : 0.0f);
    const auto finish = [&](const Value& exact, const Value& widened) {
        const Value present = select(absent, constant_channel, select(flat, exact, widened));
        return select(args[0], present, zero);
    };
    return {finish(lo, lower), finish(hi, upper)};
}

}  // namespace openfab::lower

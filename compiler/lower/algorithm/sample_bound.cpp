// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The interval form of lookups in pictures and volumes: the range of all lookups in a box of
// coordinates and footprints, from the min-max pyramid.

#include "base/infinity.h"
#include "compiler/lower/algorithm/sample_parts.h"
#include "texture/sample.h"

namespace openfab::lower {

namespace {

using ir::Type;

// Coordinates beyond these get the range of the whole image.
static_assert(texture::kOwnColor == ir::kOwnColor);

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
Extent make_extent(const Texture& texture, int32_t axis, const Value& lo, const Value& hi,
                   const Value& reach) {
    const Value size = to_float(texture.side(constant(0), axis));
    const Value shift = select(texture.wrap_is(kWrapRepeat, axis), floor(lo), constant(0.0f));
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
    Value touches_black;                     ///< what is outside, along an axis where that is black
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
    Value black = constant_bits(Type::kBool, 0);
    Value longest = constant(1.0f);
    for (size_t a = 0; a < box.size(); ++a) {
        const auto axis = static_cast<int32_t>(a);
        extents.push_back(make_extent(texture, axis, box[a].lo, box[a].hi, reach));
        const Extent& extent = extents.back();
        for (const Value& end : {box[a].lo, box[a].hi})
            known = both(known, absolute(end) < constant(kFarthestCoordinate));
        const Value moves = texture.wrap_is(kWrapRepeat, axis) | texture.wrap_is(kWrapMirror, axis);
        known = both(known, invert(moves) | extent.inside);
        longest = most(longest, extent.size);
    }
    for (size_t a = 0; a < box.size(); ++a) {
        const Value beyond = invert(both(known, extents[a].inside));
        black = black | both(texture.wrap_is(kWrapBlack, static_cast<int32_t>(a)), beyond);
    }

    Region out;
    out.level = select(known, least(at_least_ceil_log2(longest), top), top);
    const Value shift = least(out.level, constant(31));
    for (const Extent& extent : extents) {
        out.ends.push_back({select(known, operate(ir::Op::kShr, {extent.lo, shift}), constant(0)),
                            select(known, operate(ir::Op::kShr, {extent.hi, shift}), constant(0))});
    }
    out.touches_black = black;
    return out;
}

/// The ends of a range of values.
using Range = std::array<Value, 2>;

Range chosen(const Value& condition, const Range& yes, const Range& no) {
    return {select(condition, yes[0], no[0]), select(condition, yes[1], no[1])};
}

/// Minimum and maximum of the texels at the corners of the region, of a channel of the pyramid.
Range corner_range(const Texture& texture, const Region& region, const Value& channel) {
    const Value offset = texture.minmax(region.level);
    Value lo;
    Value hi;
    for (uint32_t corner = 0; corner < 1u << region.ends.size(); ++corner) {
        Value texel = constant(0);
        for (size_t a = region.ends.size(); a-- > 0;) {
            const Value side = texture.side(region.level, static_cast<int32_t>(a));
            texel = texel * side + region.ends[a][corner >> a & 1u];
        }
        const Value index = offset + (texel * texture.channels() + channel) * constant(2);
        const Value least_here = texture.at(index);
        const Value most_here = texture.at(index + constant(1));
        lo = corner == 0 ? least_here : least(lo, least_here);
        hi = corner == 0 ? most_here : most(hi, most_here);
    }
    return {lo, hi};
}

/// The range of lookups of a channel of the pyramid; `outside` is its value where the picture is not.
Range stored_range(const Texture& texture, const Region& region, const Value& channel,
                   const Value& outside) {
    auto [lo, hi] = corner_range(texture, region, channel);
    lo = select(region.touches_black, least(lo, outside), lo);
    hi = select(region.touches_black, most(hi, outside), hi);

    // A constant region gives exactly its value where eight copies of it add up without rounding.
    // Elsewhere results may pass the ends by rounding, but never 0 from above or below, nor 1 from
    // below.
    const Value zero = constant(0.0f);
    const Value one = constant(1.0f);
    const Value slack = most(absolute(lo), absolute(hi)) * constant(kRoundingSlack);
    const Value low_bits = float_bits(lo) & constant_bits(Type::kUint, 7);
    const Value flat = both(lo == hi, low_bits == constant_bits(Type::kUint, 0));
    const Value below = lo - slack;
    const Value above = hi + slack;
    const Value lower = select(lo >= zero, most(below, zero), below);
    const Value upper =
        select(hi > zero, select(hi > one, above, least(above, one)), least(above, zero));
    return chosen(flat, {lo, hi}, {lower, upper});
}

/// The range of alpha, or of coverage: 1 where a picture has neither.
Range alpha_range(const Texture& texture, const Region& region) {
    const Value zero = constant(0.0f);
    const Value one = constant(1.0f);
    const Value last = minus(texture.channels(), constant(1));
    const Range coverage = {select(region.touches_black, zero, one), one};
    return chosen(texture.has_alpha(), stored_range(texture, region, last, zero), coverage);
}

/// The range of the colour itself: (w - (1 - a)) / a of a picture with alpha, else w / a, and 0 where
/// a is. Each step is monotone, rounding too.
Range own_color_range(const Texture& texture, const Range& w, const Range& alpha) {
    const Value zero = constant(0.0f);
    const Value one = constant(1.0f);
    const Value infinite = constant(kInfinity);
    const Value lo = select(texture.has_alpha(), w[0] - (one - alpha[0]), w[0]);
    const Value hi = select(texture.has_alpha(), w[1] - (one - alpha[1]), w[1]);
    const Value covered = alpha[0] > zero;
    const Value some = alpha[1] > zero;
    const Value smallest = select(lo < zero, select(covered, lo / alpha[0], constant(-kInfinity)),
                                  select(covered, lo / alpha[1], zero));
    const Value greatest = select(hi > zero, select(covered, hi / alpha[0], infinite),
                                  select(covered, hi / alpha[1], zero));
    return {select(some, smallest, zero), select(some, greatest, zero)};
}

}  // namespace

std::array<Value, 2> lower_sample_bound(LoweringContext* context, int32_t texture_index,
                                        int32_t channel, const std::vector<Value>& args) {
    constexpr size_t kVolumeArgs = 17;
    const bool picture = args.size() != kVolumeArgs;
    const Texture texture(context, texture_index, OPENFAB_TEXTURE_MINMAX, picture ? 2 : 3);
    const bool own = channel >= texture::kOwnColor && channel < texture::kOwnColor + 3;
    if (own) channel -= texture::kOwnColor;
    const Region region = make_region(texture, args);
    const Value zero = constant(0.0f);
    Range missing = {constant(channel == 3 ? 1.0f : 0.0f), constant(channel == 3 ? 1.0f : 0.0f)};
    Value outside = zero;
    if (picture && channel < 3) {
        outside = select(texture.has_alpha(), constant(1.0f), zero);
    } else if (picture && channel == 3) {
        missing[0] = select(region.touches_black, zero, missing[0]);
    }
    Range found = stored_range(texture, region, texture.channel(channel), outside);
    if (own) {
        // A picture of four colours has no alpha, of whatever kind.
        const Value plain = both(invert(texture.has_alpha()), texture.colors() > constant(3));
        const Range of_alpha = own_color_range(texture, found, alpha_range(texture, region));
        found = chosen(plain, found, of_alpha);
    }
    const Range present = chosen(texture.channel_missing(channel), missing, found);
    return chosen(args[0], present, {zero, zero});
}

}  // namespace openfab::lower

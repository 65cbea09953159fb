// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Texture look-ups in generated code: the definition of compiler/interp/sample.h, operation for
// operation.

#include <fmt/format.h>

#include <limits>

#include "compiler/interp/sample.h"
#include "compiler/lower/kernel.h"
#include "runtime/texture/pyramid.h"

namespace openfab::lower {

namespace {

using Halide::Expr;
using ir::Type;

constexpr int32_t kLanes = 8;
constexpr int32_t kMaxTaps = 8;
constexpr float kMaxWidth = 1073741824.0f;            // 2^30
constexpr float kMaxSquare = 1152921504606846976.0f;  // 2^60
constexpr int32_t kWrapRepeat = 1;
constexpr int32_t kWrapMirror = 2;
constexpr int32_t kWrapBlack = 3;
constexpr int32_t kFilterTrilinear = 0;
constexpr int32_t kFilterNearest = 2;

Value bound(const Value& x, float lo, const Value& hi) {
    return select(x > constant(lo), select(x < hi, x, hi), constant(lo));
}
Value bound(const Value& x, float lo, float hi) {
    return bound(x, lo, constant(hi));
}
Value to_float(const Value& x) {
    return convert(x, Type::kFloat);
}
/// `x` is known to be a whole number of small magnitude.
Value whole_to_int(const Value& x) {
    return {Type::kInt, Halide::cast(Halide::Int(32), x.expr)};
}
Value invert(const Value& x) {
    return operate(ir::Op::kNot, {x});
}
Value both(const Value& a, const Value& b) {
    return operate(ir::Op::kAnd, {a, b});
}
// Address arithmetic is Halide's own: a texel's place in a pyramid is far from overflow, and the
// Exprs are a third of the size.
Value plus(const Value& a, const Value& b) {
    return {Type::kInt, a.expr + b.expr};
}
Value minus(const Value& a, const Value& b) {
    return {Type::kInt, a.expr - b.expr};
}
Value times(const Value& a, const Value& b) {
    return {Type::kInt, a.expr * b.expr};
}
Value least(const Value& a, const Value& b) {
    return operate(ir::Op::kMin, {a, b});
}
Value most(const Value& a, const Value& b) {
    return operate(ir::Op::kMax, {a, b});
}

/// A texture's scalars and arrays.
class Texture {
  public:
    Texture(Site* site, int32_t index, openfab_texture_buffer data)
        : info_(site->textures.at({index, OPENFAB_TEXTURE_INFO})),
          data_(site->textures.at({index, data})) {}

    Value header(int32_t place) const { return {Type::kInt, info_(place)}; }
    Value channels() const { return header(0); }
    Value levels() const { return header(1); }
    Value wrap_is(int32_t wrap) const { return header(2) == constant(wrap); }
    Value filter_is(int32_t filter) const { return header(3) == constant(filter); }
    /// field 0: texel offset, 1: width, 2: height, 3: min-max offset.
    Value level_info(const Value& level, int32_t field) const {
        const Value place =
            level * constant(texture::kInfoPerLevel) + constant(texture::kInfoHeader + field);
        return {Type::kInt, info_(clamped(place, info_))};
    }
    Value at(const Value& place) const { return {Type::kFloat, data_(clamped(place, data_))}; }

    /// The channel read for `channel`, and whether there is none.
    Value channel(int32_t channel) const {
        return select(constant(channel) < channels(), constant(channel), constant(0));
    }
    Value channel_missing(int32_t channel) const {
        const Value has = constant(channel) < channels();
        if (channel >= 3) return invert(has);
        return both(invert(has), invert(channels() == constant(1)));
    }

  private:
    static Expr clamped(const Value& place, const Halide::ImageParam& buffer) {
        // Halide's bounds inference need not look inside: the clamp says all.
        const Expr opaque =
            Halide::reinterpret(Halide::Int(32), Halide::reinterpret(Halide::UInt(32), place.expr));
        return Halide::clamp(opaque, 0, buffer.dim(0).extent() - 1);
    }
    Halide::ImageParam info_;
    Halide::ImageParam data_;
};

Value log2_of(const Value& x) {
    const Value bits = float_bits(x);
    const Value exponent = operate(ir::Op::kShr, {bits, constant_bits(Type::kUint, 23)});
    const Value e = to_float(convert(exponent, Type::kInt) - constant(127));
    const Value fraction =
        (bits & constant_bits(Type::kUint, 0x7fffffu)) | constant_bits(Type::kUint, 0x3f800000u);
    const Value f = bits_float(fraction) - constant(1.0f);
    const Value q = ((constant(interp::kLog2Q3) * f + constant(interp::kLog2Q2)) * f +
                     constant(interp::kLog2Q1)) *
                        f +
                    constant(interp::kLog2Q0);
    const Value log = e + (f + (f * (constant(1.0f) - f)) * q);
    return select(x >= constant(1.0f), log, constant(0.0f));
}

/// What all taps and channels of a look-up share. `fields` is the order in the Tuple of
/// footprint_k.
struct Footprint {
    Value taps;  ///< 0 where the guard is false
    Value u, v, major, ax, ay, fraction;
    struct Level {
        Value offset, width, height;
    };
    std::array<Level, 2> levels;

    std::vector<Value*> fields() {
        std::vector<Value*> out = {&taps, &u, &v, &major, &ax, &ay, &fraction};
        for (Level& level : levels) {
            out.insert(out.end(), {&level.offset, &level.width, &level.height});
        }
        return out;
    }
};

Footprint make_footprint(const Texture& texture, const std::vector<Value>& args) {
    const Value zero = constant(0.0f);
    const Value half = constant(0.5f);
    const Value w0 = to_float(texture.level_info(constant(0), 1));
    const Value h0 = to_float(texture.level_info(constant(0), 2));
    std::array<Value, 3> sx;
    std::array<Value, 3> sy;
    for (size_t k = 0; k < 3; ++k) {
        sx[k] = args.size() > 4 ? args[4 + k] * w0 : zero;
        sy[k] = args.size() > 4 ? args[7 + k] * h0 : zero;
    }
    const Value width = args[3];
    const Value a = (sx[0] * sx[0] + sx[1] * sx[1]) + sx[2] * sx[2];
    const Value b = (sx[0] * sy[0] + sx[1] * sy[1]) + sx[2] * sy[2];
    const Value c = (sy[0] * sy[0] + sy[1] * sy[1]) + sy[2] * sy[2];
    const Value m = (a + c) * half;
    const Value d = (a - c) * half;
    const Value r = sqrt(d * d + b * b);
    Footprint out;
    out.u = args[1];
    out.v = args[2];
    out.major = bound(sqrt(m + r) * width, 0.0f, kMaxWidth);
    const Value minor = bound(sqrt(bound(m - r, 0.0f, kMaxSquare)) * width, 0.0f, kMaxWidth);
    const Value wide_x = d >= zero;
    const Value ex = select(wide_x, d + r, b);
    const Value ey = select(wide_x, b, r - d);
    const Value e = sqrt(ex * ex + ey * ey);
    const Value usable = both(e > zero, e < constant(kMaxSquare));
    out.ax = select(usable, ex / e, constant(1.0f));
    out.ay = select(usable, ey / e, zero);

    const Value low = out.major * constant(0.125f);
    const Value narrow = select(minor > low, minor, low);
    const Value at_least_one = select(narrow > constant(1.0f), narrow, constant(1.0f));
    const Value many = bound(ceil(out.major / at_least_one), 1.0f, static_cast<float>(kMaxTaps));
    const Value anisotropic =
        invert(texture.filter_is(kFilterTrilinear) | texture.filter_is(kFilterNearest));
    const Value wide = select(anisotropic, narrow, out.major);
    const Value taps = select(anisotropic, whole_to_int(many), constant(1));
    out.taps = select(args[0], taps, constant(0));
    const Value last = minus(texture.levels(), constant(1));
    const Value level = bound(log2_of(wide), 0.0f, to_float(last));
    const Value whole = floor(level);
    out.fraction = level - whole;
    const Value l0 = select(texture.filter_is(kFilterNearest), constant(0), whole_to_int(whole));
    const Value l1 = least(plus(l0, constant(1)), last);
    const std::array<Value, 2> chosen = {l0, l1};
    for (size_t k = 0; k < 2; ++k) {
        out.levels[k] = {texture.level_info(chosen[k], 0), texture.level_info(chosen[k], 1),
                         texture.level_info(chosen[k], 2)};
    }
    return out;
}

Value place(const Texture& texture, const Value& u) {
    const Value repeat = u - floor(u);
    const Value h = u * constant(0.5f);
    const Value mirror = (h - floor(h)) * constant(2.0f);
    const Value p = select(texture.wrap_is(kWrapRepeat), repeat,
                           select(texture.wrap_is(kWrapMirror), mirror, u));
    return bound(p, -2.0f, 3.0f);
}

struct Texel {
    Value index;
    Value outside;
};

Texel wrapped(const Texture& texture, const Value& x, const Value& n) {
    const Value repeat = texture.wrap_is(kWrapRepeat);
    const Value mirror = texture.wrap_is(kWrapMirror);
    const Value zero = constant(0);
    const Value one = constant(1);
    const Value last = minus(n, one);
    const Value below = x < zero;
    const Value above = x >= n;
    const Value from_below =
        select(repeat, plus(x, n), select(mirror, minus(constant(-1), x), zero));
    const Value from_above =
        select(repeat, minus(x, n), select(mirror, minus(plus(n, last), x), last));
    const Value moved = select(below, from_below, select(above, from_above, x));
    return {most(least(moved, last), zero), below | above};
}

/// One axis of a tap in one level: the two texels and the weight of the second.
struct Axis {
    std::array<Texel, 2> texels;
    Value weight;
};

Axis make_axis(const Texture& texture, const Value& placed, const Value& n) {
    const Value scaled = placed * to_float(n);
    const Value x = select(texture.filter_is(kFilterNearest), scaled, scaled - constant(0.5f));
    const Value x0 = whole_to_int(floor(x));
    return {{wrapped(texture, x0, n), wrapped(texture, plus(x0, constant(1)), n)}, x - floor(x)};
}

class Tap {
  public:
    Tap(const Texture& texture, const Footprint& footprint, const Value& place_u,
        const Value& place_v)
        : texture_(texture), footprint_(footprint) {
        for (size_t k = 0; k < 2; ++k) {
            axes_[k] = {make_axis(texture, place_u, footprint.levels[k].width),
                        make_axis(texture, place_v, footprint.levels[k].height)};
        }
    }

    Value value(const Value& channel) const {
        const Value lo = bilinear(0, channel);
        const Value hi = bilinear(1, channel);
        const Value filtered = lo + (hi - lo) * footprint_.fraction;
        return select(texture_.filter_is(kFilterNearest), texel(0, 0, 0, channel), filtered);
    }

  private:
    Value texel(size_t level, size_t i, size_t j, const Value& channel) const {
        const Texel& x = axes_[level][0].texels[i];
        const Texel& y = axes_[level][1].texels[j];
        const Footprint::Level& at = footprint_.levels[level];
        const Value index = plus(
            at.offset,
            plus(times(plus(times(y.index, at.width), x.index), texture_.channels()), channel));
        const Value hidden = both(texture_.wrap_is(kWrapBlack), x.outside | y.outside);
        return select(hidden, constant(0.0f), texture_.at(index));
    }
    Value bilinear(size_t level, const Value& channel) const {
        const Value fx = axes_[level][0].weight;
        const Value fy = axes_[level][1].weight;
        const Value t00 = texel(level, 0, 0, channel);
        const Value t01 = texel(level, 0, 1, channel);
        const Value t0 = t00 + (texel(level, 1, 0, channel) - t00) * fx;
        const Value t1 = t01 + (texel(level, 1, 1, channel) - t01) * fx;
        return t0 + (t1 - t0) * fy;
    }

    const Texture& texture_;
    const Footprint& footprint_;
    std::array<std::array<Axis, 2>, 2> axes_;
};

NamedFunc& new_func(Site* site, const std::string& name, const std::vector<Halide::Var>& vars) {
    NamedFunc named{name, Halide::Func(name), {}};
    for (const Halide::Var& var : vars)
        named.vars.emplace_back(var.name(), var);
    site->funcs->push_back(named);
    return site->funcs->back();
}

/// An element of a Func that has one or several.
Expr element(const Halide::Func& func, const std::vector<Expr>& at, size_t k) {
    if (func.outputs() == 1) return func(at);
    return func(at)[static_cast<int>(k)];
}

std::vector<Expr> exprs(const std::vector<Halide::Var>& vars) {
    return {vars.begin(), vars.end()};
}

/// footprint_k, stored so that its fields are loads.
Halide::Func store_footprint(Site* site, const std::string& number, Footprint* footprint) {
    Halide::Func func = new_func(site, "footprint_" + number, site->vars).func;
    std::vector<Expr> stored;
    for (const Value* field : footprint->fields())
        stored.push_back(field->expr);
    func(site->vars) = Halide::Tuple(stored);
    size_t k = 0;
    for (Value* field : footprint->fields())
        field->expr = func(exprs(site->vars))[static_cast<int>(k++)];
    return func;
}

}  // namespace

std::vector<Value> lower_sample(Site* site, int32_t texture_index,
                                const std::vector<int32_t>& channels,
                                const std::vector<Value>& args) {
    const std::string number = fmt::format("{}", site->lookups++);
    const Texture texture(site, texture_index, OPENFAB_TEXTURE_TEXELS);
    Footprint footprint = make_footprint(texture, args);
    const Halide::Func stored = store_footprint(site, number, &footprint);

    // The most taps among the 8 lanes: the loop over taps is shared by the vector and skipped where
    // no lane asks.
    const std::vector<Halide::Var> group(site->vars.begin() + 1, site->vars.end());
    Halide::Func limit = new_func(site, "taps_" + number, group).func;
    Expr most_taps = 0;
    for (int32_t lane = 0; lane < kLanes; ++lane) {
        std::vector<Expr> at = exprs(site->vars);
        at[0] = lane;
        most_taps = Halide::max(most_taps, element(stored, at, 0));
    }
    limit(group) = most_taps;

    Halide::RDom tap(0, kMaxTaps, "tap");
    tap.where(tap < limit(exprs(group)));
    Halide::Func sum = new_func(site, "texture_" + number, site->vars).func;
    const Value count = to_float(footprint.taps);
    const Value i = to_float({Type::kInt, tap});
    const Value t = ((i + constant(0.5f)) / count - constant(0.5f)) * footprint.major;
    const Value w0 = to_float(texture.level_info(constant(0), 1));
    const Value h0 = to_float(texture.level_info(constant(0), 2));
    const Value u = place(texture, footprint.u + (t * footprint.ax) / w0);
    const Value v = place(texture, footprint.v + (t * footprint.ay) / h0);
    const Tap look(texture, footprint, u, v);
    const Value taken = Value{Type::kInt, tap} < footprint.taps;

    sum(site->vars) = Halide::Tuple(std::vector<Expr>(channels.size(), constant(0.0f).expr));
    std::vector<Expr> updated;
    for (size_t k = 0; k < channels.size(); ++k) {
        const Value before{Type::kFloat, element(sum, exprs(site->vars), k)};
        const Value value = look.value(texture.channel(channels[k]));
        // A point sample keeps the sign of a texel of -0, which adding to 0 would lose.
        const Value after = select(texture.filter_is(kFilterNearest), value, before + value);
        updated.push_back(select(taken, after, before).expr);
    }
    sum(site->vars) = Halide::Tuple(updated);
    sum.update(0).reorder(site->vars[0], tap);

    std::vector<Value> out;
    for (size_t k = 0; k < channels.size(); ++k) {
        const Value total{Type::kFloat, element(sum, exprs(site->vars), k)};
        const Value missing = constant(channels[k] == 3 ? 1.0f : 0.0f);
        const Value present = select(texture.channel_missing(channels[k]), missing, total / count);
        out.push_back(select(args[0], present, constant(0.0f)));
    }
    return out;
}

namespace {

// Places beyond these are answered with the range of the whole image.
constexpr float kFarthestPlace = 1024.0f;
constexpr float kWidestFootprint = 65536.0f;
// Rounding of interpolation, of sums over taps and of the coarser levels themselves, relative to
// the largest magnitude.
constexpr float kRoundingSlack = 1.0f / 262144.0f;

/// Range of texel indices of level 0 along one axis that a look-up may touch.
struct Extent {
    Value lo, hi;  ///< int, inside the level
    Value inside;  ///< nothing outside [0, n) is touched before wrapping
    Value size;    ///< float, in texels
};

Value absolute(const Value& x) {
    return operate(ir::Op::kAbs, {x});
}

/// `reach`: texels of level 0 added at both ends. Under repeat, whole periods are taken away first.
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

/// The least texel range that holds every look-up of the box, by level of the min-max pyramid.
struct Region {
    Value level;
    std::array<Value, 2> x, y;
    Value touches_outside;
};

Region make_region(const Texture& texture, const std::vector<Value>& args) {
    const Value w0 = texture.level_info(constant(0), 1);
    const Value h0 = texture.level_info(constant(0), 2);
    Value square = constant(0.0f);
    for (size_t k = 0; k < 3; ++k) {
        const Value sx = args[6 + k] * to_float(w0);
        const Value sy = args[9 + k] * to_float(h0);
        square = square + sx * sx + sy * sy;
    }
    // The major width is at most the root of the trace; a tenth of a percent covers all rounding.
    const Value widest = sqrt(square) * args[5] * constant(1.001f);
    const Value major = bound(widest, 0.0f, kWidestFootprint);
    const Value top = texture.levels() - constant(1);
    const Value coarsest = least(at_least_ceil_log2(most(major, constant(1.0f))), top);
    // Half the taps' length, and of the coarsest level one texel each for interpolation, for levels
    // whose sides are not halves of those below, and for slack.
    const Value reach = major * constant(0.5f) + constant(3.0f) * power_of_two(coarsest);
    const Extent x = make_extent(texture, args[1], args[2], w0, reach);
    const Extent y = make_extent(texture, args[3], args[4], h0, reach);

    Value known = widest < constant(kWidestFootprint);
    for (size_t k = 1; k <= 4; ++k) {
        known = both(known, absolute(args[k]) < constant(kFarthestPlace));
    }
    const Value clamps = invert(texture.wrap_is(kWrapRepeat) | texture.wrap_is(kWrapMirror));
    known = both(known, clamps | both(x.inside, y.inside));

    Region out;
    const Value fine = at_least_ceil_log2(most(most(x.size, y.size), constant(1.0f)));
    out.level = select(known, least(fine, top), top);
    const Value shift = least(out.level, constant(31));
    const auto ends = [&](const Extent& extent) {
        return std::array<Value, 2>{
            select(known, operate(ir::Op::kShr, {extent.lo, shift}), constant(0)),
            select(known, operate(ir::Op::kShr, {extent.hi, shift}), constant(0))};
    };
    out.x = ends(x);
    out.y = ends(y);
    out.touches_outside = invert(both(known, both(x.inside, y.inside)));
    return out;
}

}  // namespace

std::array<Value, 2> lower_sample_bound(Site* site, int32_t texture_index, int32_t channel,
                                        const std::vector<Value>& args) {
    const Texture texture(site, texture_index, OPENFAB_TEXTURE_MINMAX);
    const Region region = make_region(texture, args);
    const Value width = texture.level_info(region.level, 1);
    const Value offset = texture.level_info(region.level, 3);
    Value lo;
    Value hi;
    for (const Value& y : region.y) {
        for (const Value& x : region.x) {
            const Value texel = (y * width + x) * texture.channels() + texture.channel(channel);
            const Value place = offset + texel * constant(2);
            const Value least_here = texture.at(place);
            const Value most_here = texture.at(place + constant(1));
            const bool first = !lo.expr.defined();
            lo = first ? least_here : least(lo, least_here);
            hi = first ? most_here : most(hi, most_here);
        }
    }
    const Value zero = constant(0.0f);
    const Value one = constant(1.0f);
    const Value black = both(texture.wrap_is(kWrapBlack), region.touches_outside);
    lo = select(black, least(lo, zero), lo);
    hi = select(black, most(hi, zero), hi);

    // A flat region gives its very value where eight copies of it add up without rounding.
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

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Texture look-ups in generated code: the definition of compiler/interp/sample.h, operation for
// operation. Two loops over taps, of which a vector runs one: where no tap of any lane comes near
// the picture's border, texels need no wrap, which is most of a tap's work; the results are the
// same.

#include <fmt/format.h>

#include "compiler/lower/sample_parts.h"

namespace openfab::lower {

namespace {

using Halide::Expr;
using ir::Type;

constexpr int32_t kMaxTaps = 8;

/// What all taps and channels of a look-up share. `fields` is the order in the Tuple of
/// footprint_k.
struct Footprint {
    Value taps;    ///< 0 where the guard is false
    Value inside;  ///< 1 where no tap reaches a texel that has to be wrapped, or none is taken
    Value u, v, major, ax, ay, fraction;
    struct Level {
        Value offset, width, height;
    };
    std::array<Level, 2> levels;

    std::vector<Value*> fields() {
        std::vector<Value*> out = {&taps, &inside, &u, &v, &major, &ax, &ay, &fraction};
        for (Level& level : levels) {
            out.insert(out.end(), {&level.offset, &level.width, &level.height});
        }
        return out;
    }
};

/// u, or v, where it is between 0 and 1, moved there by `repeat`: as `place` for what is inside.
Value place_inside(const Texture& texture, const Value& u) {
    return select(texture.wrap_is(kWrapRepeat), u - floor(u), u);
}

/// All taps along one axis read texels `x0` and `x0 + 1` of both levels with 0 <= x0 and x0 + 1 <
/// w: a texel and a quarter of the coarser level is kept from the border, the quarter for rounding.
Value stays_inside(const Texture& texture, const Value& u, const Value& along, const Value& n0,
                   const Value& coarse) {
    const Value middle = place_inside(texture, u);
    const Value reach = absolute(along) / n0 + constant(1.25f) / to_float(coarse);
    const Value small = absolute(u) < constant(32.0f);
    return both(small, both(middle > reach, middle + reach < constant(1.0f)));
}

/// texture.side(level, axis), computed: a level has half as many texels as the one below, rounded
/// up, and so n of level 0 are ceil(n / 2^level).
Value side_of(const Texture& texture, const Value& level, int32_t axis) {
    const Expr finest = texture.side(constant(0), axis).expr;
    const Expr l = level.expr;
    return {Type::kInt, (finest + ((Expr(1) << l) - 1)) >> l};
}

Footprint make_footprint(const Texture& texture, const std::vector<Value>& args) {
    const Value zero = constant(0.0f);
    const Value half = constant(0.5f);
    const Value w0 = to_float(texture.side(constant(0), 0));
    const Value h0 = to_float(texture.side(constant(0), 1));
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
        out.levels[k] = {texture.offset(chosen[k]), side_of(texture, chosen[k], 0),
                         side_of(texture, chosen[k], 1)};
    }
    const Value half_major = out.major * half;
    const Value inside =
        both(stays_inside(texture, out.u, half_major * out.ax, w0, out.levels[1].width),
             stays_inside(texture, out.v, half_major * out.ay, h0, out.levels[1].height));
    const Value plain = both(inside, invert(texture.filter_is(kFilterNearest)));
    out.inside = select(invert(args[0]) | plain, constant(1), constant(0));
    return out;
}

/// An axis of a tap that stays inside.
Axis make_inner_axis(const Value& placed, const Value& n) {
    const Value never = constant_bits(Type::kBool, 0);
    const Value x = placed * to_float(n) - constant(0.5f);
    const Value whole = floor(x);
    const Value x0 = whole_to_int(whole);
    return {{Texel{x0, never}, Texel{plus(x0, constant(1)), never}}, x - whole};
}

class Tap {
  public:
    /// `inside`: Footprint::inside is 1 in every lane.
    Tap(const Texture& texture, const Footprint& footprint, const Value& u, const Value& v,
        bool inside)
        : texture_(texture), footprint_(footprint), inside_(inside) {
        for (size_t k = 0; k < 2; ++k) {
            const Footprint::Level& level = footprint.levels[k];
            if (inside) {
                axes_[k] = {make_inner_axis(place_inside(texture, u), level.width),
                            make_inner_axis(place_inside(texture, v), level.height)};
            } else {
                axes_[k] = {make_axis(texture, place(texture, u), level.width),
                            make_axis(texture, place(texture, v), level.height)};
            }
        }
    }

    Value value(const Value& channel) const {
        const Value lo = bilinear(0, channel);
        const Value hi = bilinear(1, channel);
        const Value filtered = lo + (hi - lo) * footprint_.fraction;
        if (inside_) return filtered;
        return select(texture_.filter_is(kFilterNearest), texel(0, 0, 0, channel), filtered);
    }

  private:
    Value texel(size_t level, size_t i, size_t j, const Value& channel) const {
        const Footprint::Level& at = footprint_.levels[level];
        const auto index_of = [&](const Value& x, const Value& y) {
            return plus(at.offset,
                        plus(times(plus(times(y, at.width), x), texture_.channels()), channel));
        };
        if (inside_) {
            // The others from the first one, by a texel and by a row.
            Value index =
                index_of(axes_[level][0].texels[0].index, axes_[level][1].texels[0].index);
            if (i != 0) index = plus(index, texture_.channels());
            if (j != 0) index = plus(index, times(at.width, texture_.channels()));
            return texture_.at(index);
        }
        const Texel& x = axes_[level][0].texels[i];
        const Texel& y = axes_[level][1].texels[j];
        const Value index = index_of(x.index, y.index);
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
    bool inside_;
    std::array<std::array<Axis, 2>, 2> axes_;
};

/// How often the loops over taps run for the lanes of a vector; one of them does not run at all.
struct Trips {
    Expr inside, anywhere;
};

Trips count_trips(Site* site, const std::string& name, const Halide::Func& stored) {
    const std::vector<Halide::Var> group(site->vars.begin() + 1, site->vars.end());
    Halide::Func limit = new_func(site, name, group).func;
    Expr most = 0, inside = 1;
    for (int32_t lane = 0; lane < kLanes; ++lane) {
        std::vector<Expr> at = exprs(site->vars);
        at[0] = lane;
        most = Halide::max(most, element(stored, at, 0));
        inside = Halide::min(inside, element(stored, at, 1));
    }
    limit(group) = Halide::Tuple(most * inside, most * (1 - inside));
    return {limit(exprs(group))[0], limit(exprs(group))[1]};
}

/// The sum over taps, of every channel. The loop is shared by the lanes of a vector; `trips` is the
/// most that one of them asks.
Halide::Func sum_taps(Site* site, const std::string& name, const Texture& texture,
                      const Footprint& footprint, const std::vector<int32_t>& channels,
                      const Expr& trips, bool inside) {
    Halide::RDom tap(0, kMaxTaps, "tap");
    tap.where(tap < trips);
    Halide::Func sum = new_func(site, name, site->vars).func;
    const Value taken = Value{Type::kInt, tap} < footprint.taps;
    const Value count = to_float(footprint.taps);
    const Value i = to_float({Type::kInt, tap});
    const Value t = ((i + constant(0.5f)) / count - constant(0.5f)) * footprint.major;
    const Value w0 = to_float(texture.side(constant(0), 0));
    const Value h0 = to_float(texture.side(constant(0), 1));
    Value u = footprint.u + (t * footprint.ax) / w0;
    Value v = footprint.v + (t * footprint.ay) / h0;
    if (inside) {
        // A lane that takes no tap may be anywhere.
        u = select(taken, u, constant(0.5f));
        v = select(taken, v, constant(0.5f));
    }
    const Tap look(texture, footprint, u, v, inside);

    sum(site->vars) = Halide::Tuple(std::vector<Expr>(channels.size(), constant(0.0f).expr));
    std::vector<Expr> updated;
    for (size_t k = 0; k < channels.size(); ++k) {
        const Value before{Type::kFloat, element(sum, exprs(site->vars), k)};
        const Value value = look.value(texture.channel(channels[k]));
        // A point sample keeps the sign of a texel of -0, which adding to 0 would lose.
        const Value after = inside
                                ? before + value
                                : select(texture.filter_is(kFilterNearest), value, before + value);
        updated.push_back(select(taken, after, before).expr);
    }
    sum(site->vars) = Halide::Tuple(updated);
    sum.update(0).reorder(site->vars[0], tap);
    return sum;
}

}  // namespace

std::vector<Value> lower_sample(Site* site, int32_t texture_index,
                                const std::vector<int32_t>& channels,
                                const std::vector<Value>& args) {
    if (is_volume_sample(args.size()))
        return lower_volume_sample(site, texture_index, channels, args);
    const std::string number = fmt::format("{}", site->lookups++);
    const Texture texture(site, texture_index, OPENFAB_TEXTURE_TEXELS, 2);
    Footprint footprint = make_footprint(texture, args);
    const Halide::Func stored = store_values(site, "footprint_" + number, footprint.fields());

    const Trips trips = count_trips(site, "taps_" + number, stored);
    const Halide::Func inner =
        sum_taps(site, "texture_inner_" + number, texture, footprint, channels, trips.inside, true);
    const Halide::Func edge =
        sum_taps(site, "texture_" + number, texture, footprint, channels, trips.anywhere, false);
    // The sum of a loop that does not run is 0; only one may go on, for the sake of -0.
    const Value is_inner{Type::kBool, trips.inside > 0};

    std::vector<Value> out;
    for (size_t k = 0; k < channels.size(); ++k) {
        const Value total =
            select(is_inner, Value{Type::kFloat, element(inner, exprs(site->vars), k)},
                   Value{Type::kFloat, element(edge, exprs(site->vars), k)});
        const Value missing = constant(channels[k] == 3 ? 1.0f : 0.0f);
        const Value present =
            select(texture.channel_missing(channels[k]), missing, total / to_float(footprint.taps));
        out.push_back(select(args[0], present, constant(0.0f)));
    }
    return out;
}

}  // namespace openfab::lower

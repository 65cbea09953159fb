// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Texture look-ups in generated code: the definition of compiler/interp/sample.h, operation for
// operation.

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
        out.levels[k] = {texture.offset(chosen[k]), texture.side(chosen[k], 0),
                         texture.side(chosen[k], 1)};
    }
    return out;
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

    // The loop over taps is shared by the vector and skipped where no lane asks.
    Halide::RDom tap(0, kMaxTaps, "tap");
    tap.where(tap < most_taps(site, "taps_" + number, stored));
    Halide::Func sum = new_func(site, "texture_" + number, site->vars).func;
    const Value count = to_float(footprint.taps);
    const Value i = to_float({Type::kInt, tap});
    const Value t = ((i + constant(0.5f)) / count - constant(0.5f)) * footprint.major;
    const Value w0 = to_float(texture.side(constant(0), 0));
    const Value h0 = to_float(texture.side(constant(0), 1));
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

}  // namespace openfab::lower

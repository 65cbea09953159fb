// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Lookups in volumes in generated code: the definition of compiler/interp/sample_volume.h,
// operation for operation.

#include <fmt/format.h>

#include "compiler/lower/algorithm/sample_parts.h"

namespace openfab::lower {

namespace {

using Halide::Expr;
using ir::Type;

constexpr size_t kSampleArgs = 5;
constexpr size_t kSampleArgsWithFootprint = 14;

/// The values that all channels of a lookup share.
struct VolumeSample {
    Value levels_asked;  ///< 2 where the guard holds, else 0
    std::array<Value, 3> at;
    Value fraction;
    struct Level {
        Value offset;
        std::array<Value, 3> sides;
    };
    std::array<Level, 2> levels;

    std::vector<Value*> fields() {
        std::vector<Value*> out = {&levels_asked, &at[0], &at[1], &at[2], &fraction};
        for (Level& level : levels) {
            out.insert(out.end(),
                       {&level.offset, &level.sides[0], &level.sides[1], &level.sides[2]});
        }
        return out;
    }
};

Value width_of(const Texture& texture, const std::vector<Value>& args) {
    Value widest = constant(0.0f);
    if (args.size() == kSampleArgsWithFootprint) {
        for (size_t j = 0; j < 3; ++j) {
            std::array<Value, 3> t;
            for (int32_t k = 0; k < 3; ++k) {
                const auto axis = static_cast<size_t>(k);
                t[axis] = (args[5 + 3 * axis + j] / texture.extent(k)) *
                          to_float(texture.side(constant(0), k));
            }
            const Value q = (t[0] * t[0] + t[1] * t[1]) + t[2] * t[2];
            widest = j == 0 ? q : select(widest > q, widest, q);
        }
    }
    return bound(sqrt(widest) * args[4], 0.0f, kMaxWidth);
}

VolumeSample make_volume_sample(const Texture& texture, const std::vector<Value>& args) {
    VolumeSample out;
    out.levels_asked = select(args[0], constant(2), constant(0));
    for (int32_t k = 0; k < 3; ++k) {
        const auto axis = static_cast<size_t>(k);
        out.at[axis] =
            wrap_coordinate(texture, (args[1 + axis] - texture.origin(k)) / texture.extent(k));
    }
    const Value nearest = texture.filter_is(kFilterNearest);
    const Value finest = texture.filter_is(texture::kFilterFinest);
    const Value last = minus(texture.levels(), constant(1));
    const Value top = select(finest, constant(0.0f), to_float(last));
    const Value level = bound(log2_of(width_of(texture, args)), 0.0f, top);
    const Value whole = floor(level);
    out.fraction = level - whole;
    const Value l0 = select(nearest, constant(0), whole_to_int(whole));
    const std::array<Value, 2> chosen = {l0, least(plus(l0, constant(1)), last)};
    for (size_t k = 0; k < 2; ++k) {
        out.levels[k].offset = texture.offset(chosen[k]);
        for (int32_t a = 0; a < 3; ++a)
            out.levels[k].sides[a] = texture.side(chosen[k], a);
    }
    return out;
}

/// The 8 texels of one level around the coordinates, and their weights.
class Cell {
  public:
    Cell(const Texture& texture, const VolumeSample& sample, const VolumeSample::Level& level)
        : texture_(texture), level_(level) {
        for (size_t a = 0; a < 3; ++a)
            axes_[a] = make_axis(texture, sample.at[a], level_.sides[a]);
    }

    Value texel(const Value& channel, size_t i, size_t j, size_t k) const {
        const std::array<size_t, 3> at = {i, j, k};
        Value index = constant(0);
        Value outside = constant_bits(Type::kBool, 0);
        for (size_t a = 3; a-- > 0;) {
            const Texel& along = axes_[a].texels[at[a]];
            index = a == 2 ? along.index : plus(times(index, level_.sides[a]), along.index);
            outside = outside | along.outside;
        }
        index = plus(level_.offset, plus(times(index, texture_.channels()), channel));
        const Value hidden = both(texture_.wrap_is(kWrapBlack), outside);
        return select(hidden, constant(0.0f), texture_.at(index));
    }

    Value linear(const Value& channel) const {
        std::array<Value, 2> b;
        for (size_t z = 0; z < 2; ++z) {
            std::array<Value, 2> a;
            for (size_t y = 0; y < 2; ++y) {
                const Value t0 = texel(channel, 0, y, z);
                a[y] = t0 + (texel(channel, 1, y, z) - t0) * axes_[0].weight;
            }
            b[z] = a[0] + (a[1] - a[0]) * axes_[1].weight;
        }
        return b[0] + (b[1] - b[0]) * axes_[2].weight;
    }

  private:
    const Texture& texture_;
    const VolumeSample::Level& level_;
    std::array<Axis, 3> axes_;
};

}  // namespace

bool is_volume_sample(size_t args) {
    return args == kSampleArgs || args == kSampleArgsWithFootprint;
}

std::vector<Value> lower_volume_sample(LoweringContext* context, int32_t texture_index,
                                       const std::vector<int32_t>& channels,
                                       const std::vector<Value>& args) {
    const int32_t number = context->sample_count++;
    const Texture texture(context, texture_index, OPENFAB_TEXTURE_TEXELS, 3);
    VolumeSample sample = make_volume_sample(texture, args);
    const Halide::Func stored =
        store_values(context, func_name(*context, "footprint", number), sample.fields());

    // One iteration for each of the two levels, which halves the code; none where no lane of the
    // vector is active.
    Halide::RDom level(0, 2, "level");
    level.where(level < most_taps(context, func_name(*context, "taps", number), stored));
    const Value trip{Type::kInt, level};
    const Value first = trip == constant(0);
    const auto chosen = [&](const Value& a, const Value& b) { return select(first, a, b); };
    const auto& [fine, coarse] = sample.levels;
    VolumeSample::Level here{chosen(fine.offset, coarse.offset), {}};
    for (size_t a = 0; a < 3; ++a)
        here.sides[a] = chosen(fine.sides[a], coarse.sides[a]);
    const Cell cell(texture, sample, here);
    Halide::Func sum =
        new_func(context, func_name(*context, "texture", number), context->vars).func;
    sum(context->vars) = Halide::Tuple(std::vector<Expr>(channels.size(), constant(0.0f).expr));
    std::vector<Expr> updated;
    const Value nearest = texture.filter_is(kFilterNearest);
    for (size_t k = 0; k < channels.size(); ++k) {
        const Value before{Type::kFloat, element(sum, exprs(context->vars), k)};
        const Value c = texture.channel(channels[k]);
        const Value value = select(nearest, cell.texel(c, 0, 0, 0), cell.linear(c));
        const Value blended = select(nearest, before, before + (value - before) * sample.fraction);
        const Value after = select(first, value, blended);
        updated.push_back(select(trip < sample.levels_asked, after, before).expr);
    }
    sum(context->vars) = Halide::Tuple(updated);
    sum.update(0).reorder(context->vars[0], level);

    std::vector<Value> out;
    for (size_t k = 0; k < channels.size(); ++k) {
        const Value total{Type::kFloat, element(sum, exprs(context->vars), k)};
        const Value missing = constant(channels[k] == 3 ? 1.0f : 0.0f);
        const Value present = select(texture.channel_missing(channels[k]), missing, total);
        out.push_back(select(args[0], present, constant(0.0f)));
    }
    return out;
}

}  // namespace openfab::lower

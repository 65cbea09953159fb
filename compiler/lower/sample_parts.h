// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What look-ups in pictures and volumes, and their interval forms, are made of. Private to
// compiler/lower; includes Halide.h.

#include <array>
#include <string>
#include <vector>

#include "compiler/lower/kernel.h"
#include "texture/pyramid.h"

namespace openfab::lower {

constexpr int32_t kLanes = 8;
constexpr float kMaxWidth = 1073741824.0f;  // 2^30
using texture::kFilterNearest;
using texture::kWrapBlack;
using texture::kWrapMirror;
using texture::kWrapRepeat;

Value bound(const Value& x, float lo, const Value& hi);
Value bound(const Value& x, float lo, float hi);
Value to_float(const Value& x);
/// `x` is known to be a whole number of small magnitude.
Value whole_to_int(const Value& x);
Value invert(const Value& x);
Value both(const Value& a, const Value& b);
// Address arithmetic is Halide's own: a texel's place in a pyramid is far from overflow, and the
// Exprs are a third of the size.
Value plus(const Value& a, const Value& b);
Value minus(const Value& a, const Value& b);
Value times(const Value& a, const Value& b);
Value least(const Value& a, const Value& b);
Value most(const Value& a, const Value& b);
Value absolute(const Value& x);
/// interp::log2_of.
Value log2_of(const Value& x);

/// A texture's scalars and arrays; a picture has 2 axes, a volume 3.
class Texture {
  public:
    Texture(Site* site, int32_t index, openfab_texture_buffer data, int32_t axes)
        : info_(site->textures.at({index, OPENFAB_TEXTURE_INFO})),
          data_(site->textures.at({index, data})),
          axes_(axes) {}

    int32_t axes() const { return axes_; }
    Value header(int32_t place) const { return {ir::Type::kInt, info_(place)}; }
    Value channels() const { return header(0); }
    Value levels() const { return header(1); }
    Value wrap_is(int32_t wrap) const { return header(2) == constant(wrap); }
    Value filter_is(int32_t filter) const { return header(3) == constant(filter); }
    /// Of a volume: its lowest corner and its size in mm.
    Value origin(int32_t axis) const { return header_float(texture::kInfoHeader + axis); }
    Value extent(int32_t axis) const { return header_float(texture::kInfoHeader + 3 + axis); }
    Value offset(const Value& level) const { return level_info(level, 0); }
    Value side(const Value& level, int32_t axis) const { return level_info(level, 1 + axis); }
    Value minmax(const Value& level) const { return level_info(level, 1 + axes_); }
    Value at(const Value& place) const { return {ir::Type::kFloat, data_(clamped(place, data_))}; }

    /// The channel read for `channel`, and whether there is none.
    Value channel(int32_t channel) const;
    Value channel_missing(int32_t channel) const;

  private:
    Value header_float(int32_t place) const;
    Value level_info(const Value& level, int32_t field) const;
    static Halide::Expr clamped(const Value& place, const Halide::ImageParam& buffer);

    Halide::ImageParam info_;
    Halide::ImageParam data_;
    int32_t axes_;
};

/// A coordinate, 0 to 1 across the texture, moved into the range that its wrap reads.
Value place(const Texture& texture, const Value& u);

/// A texel's place along one axis, and whether it was outside before the wrap.
struct Texel {
    Value index;
    Value outside;
};
Texel wrapped(const Texture& texture, const Value& x, const Value& n);

/// One axis of a tap in one level: the two texels and the weight of the second.
struct Axis {
    std::array<Texel, 2> texels;
    Value weight;
};
Axis make_axis(const Texture& texture, const Value& placed, const Value& n);

/// The name of a Func, as compiler/lower/kernel.h has it.
std::string func_name(const Site& site, const char* kind, int32_t number);
NamedFunc& new_func(Site* site, const std::string& name, const std::vector<Halide::Var>& vars);
/// An element of a Func that has one or several.
Halide::Expr element(const Halide::Func& func, const std::vector<Halide::Expr>& at, size_t k);
std::vector<Halide::Expr> exprs(const std::vector<Halide::Var>& vars);
/// Stores values in a Func of its own, so that they become loads.
Halide::Func store_values(Site* site, const std::string& name, const std::vector<Value*>& fields);
/// How often the loop over taps runs for the lanes of a vector: the most that one of them asks,
/// which is field 0 of `stored`.
Halide::Expr most_taps(Site* site, const std::string& name, const Halide::Func& stored);

/// sample.cpp hands these over to sample_volume.cpp, by the number of arguments.
bool is_volume_sample(size_t args);
std::vector<Value> lower_volume_sample(Site* site, int32_t texture_index,
                                       const std::vector<int32_t>& channels,
                                       const std::vector<Value>& args);

}  // namespace openfab::lower

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The parts of lookups in pictures and volumes, and of their interval forms. Private to
// compiler/lower; includes Halide.h.

#include <array>
#include <string>
#include <vector>

#include "compiler/lower/algorithm/kernel.h"
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
/// Converts a float that is known to be a small integer.
Value whole_to_int(const Value& x);
Value invert(const Value& x);
Value both(const Value& a, const Value& b);
// Address arithmetic is Halide's own: a texel's index in a pyramid is far from overflow, and
// the Exprs are a third of the size.
Value plus(const Value& a, const Value& b);
Value minus(const Value& a, const Value& b);
Value times(const Value& a, const Value& b);
Value least(const Value& a, const Value& b);
Value most(const Value& a, const Value& b);
Value absolute(const Value& x);
/// Computes interp::log2_of.
Value log2_of(const Value& x);

/// A texture's scalars and arrays; a picture has 2 axes, a volume 3.
class Texture {
  public:
    Texture(LoweringContext* context, int32_t index, openfab_texture_buffer data, int32_t axes)
        : info_(context->textures.at({index, OPENFAB_TEXTURE_INFO})),
          data_(context->textures.at({index, data})),
          axes_(axes) {}

    int32_t axes() const { return axes_; }
    Value header(int32_t index) const { return {ir::Type::kInt, info_(index)}; }
    Value channels() const { return header(0); }
    Value levels() const { return header(1); }
    /// Of an axis of a picture; of a volume all axes have the mode of the first.
    Value wrap_is(int32_t wrap, int32_t axis = 0) const {
        const bool along_v = axes_ == 2 && axis == 1;
        return header(along_v ? texture::kInfoWrapV : 2) == constant(wrap);
    }
    Value filter_is(int32_t filter) const { return header(3) == constant(filter); }
    /// The lowest corner and the size of a volume in mm.
    Value origin(int32_t axis) const { return header_float(texture::kInfoHeader + axis); }
    Value extent(int32_t axis) const { return header_float(texture::kInfoHeader + 3 + axis); }
    Value offset(const Value& level) const { return level_info(level, 0); }
    Value side(const Value& level, int32_t axis) const { return level_info(level, 1 + axis); }
    Value minmax(const Value& level) const { return level_info(level, 1 + axes_); }
    Value at(const Value& index) const { return {ir::Type::kFloat, data_(clamped(index, data_))}; }

    /// Whether the last channel of a picture is alpha.
    Value has_alpha() const;
    /// The number of channels but for alpha.
    Value colors() const;
    /// The channel that is read for `channel`, and whether it is missing.
    Value channel(int32_t channel) const;
    Value channel_missing(int32_t channel) const;

  private:
    Value header_float(int32_t index) const;
    Value level_info(const Value& level, int32_t field) const;
    static Halide::Expr clamped(const Value& index, const Halide::ImageParam& buffer);

    Halide::ImageParam info_;
    Halide::ImageParam data_;
    int32_t axes_;
};

/// Wraps a coordinate, 0 to 1 across the texture, into the range that its wrap mode reads.
Value wrap_coordinate(const Texture& texture, const Value& u);

/// A texel's index along one axis, and whether it was outside before wrapping.
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
Axis make_axis(const Texture& texture, const Value& wrapped_u, const Value& n);

/// Returns the name of a Func, see compiler/lower/algorithm/kernel.h.
std::string func_name(const LoweringContext& context, const char* kind, int32_t number);
NamedFunc& new_func(LoweringContext* context, const std::string& name,
                    const std::vector<Halide::Var>& vars);
/// Returns element `k` of a Func's value.
Halide::Expr element(const Halide::Func& func, const std::vector<Halide::Expr>& at, size_t k);
std::vector<Halide::Expr> exprs(const std::vector<Halide::Var>& vars);
/// Stores values in a Func of its own, so that they become loads.
Halide::Func store_values(LoweringContext* context, const std::string& name,
                          const std::vector<Value*>& fields);
/// Returns the trips of the loop over taps for the lanes of a vector: the most that any lane needs,
/// which is field 0 of `stored`.
Halide::Expr most_taps(LoweringContext* context, const std::string& name,
                       const Halide::Func& stored);

/// True for a lookup in a volume, told by the number of arguments.
bool is_volume_sample(size_t args);
/// Lowers a lookup in a volume; see lower_sample.
std::vector<Value> lower_volume_sample(LoweringContext* context, int32_t texture_index,
                                       const std::vector<int32_t>& channels,
                                       const std::vector<Value>& args);

}  // namespace openfab::lower

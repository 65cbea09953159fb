// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/algorithm/sample_parts.h"

#include <fmt/format.h>

#include "compiler/interp/sample.h"

namespace openfab::lower {

using Halide::Expr;
using ir::Type;

Value bound(const Value& x, float lo, const Value& hi) {
    return select(x > constant(lo), select(x < hi, x, hi), constant(lo));
}
Value bound(const Value& x, float lo, float hi) {
    return bound(x, lo, constant(hi));
}
Value to_float(const Value& x) {
    return convert(x, Type::kFloat);
}
Value whole_to_int(const Value& x) {
    return {Type::kInt, Halide::cast(Halide::Int(32), x.expr)};
}
Value invert(const Value& x) {
    return operate(ir::Op::kNot, {x});
}
Value both(const Value& a, const Value& b) {
    return operate(ir::Op::kAnd, {a, b});
}
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
Value absolute(const Value& x) {
    return operate(ir::Op::kAbs, {x});
}

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

Value Texture::has_alpha() const {
    return header(texture::kInfoAlpha) == constant(1);
}

Value Texture::colors() const {
    if (axes_ == 3) return channels();
    return minus(channels(), header(texture::kInfoAlpha));
}

Value Texture::channel(int32_t channel) const {
    const bool maybe_alpha = axes_ == 2 && channel == 3;
    const Value otherwise = maybe_alpha ? select(has_alpha(), colors(), constant(0)) : constant(0);
    return select(constant(channel) < colors(), constant(channel), otherwise);
}

Value Texture::channel_missing(int32_t channel) const {
    const Value has = constant(channel) < colors();
    if (axes_ == 2 && channel == 3) return invert(has | has_alpha());
    if (channel >= 3) return invert(has);
    return both(invert(has), invert(colors() == constant(1)));
}

Value Texture::header_float(int32_t index) const {
    return bits_float(convert(header(index), Type::kUint));
}

Value Texture::level_info(const Value& level, int32_t field) const {
    const bool volume = axes_ == 3;
    const int32_t first = volume ? texture::kVolumeInfoHeader : texture::kInfoHeader;
    const int32_t each = volume ? texture::kVolumeInfoPerLevel : texture::kInfoPerLevel;
    const Value index = level * constant(each) + constant(first + field);
    return {Type::kInt, info_(clamped(index, info_))};
}

Expr Texture::clamped(const Value& index, const Halide::ImageParam& buffer) {
    // Hides the expression from Halide's bounds inference: the clamp already bounds it.
    const Expr opaque =
        Halide::reinterpret(Halide::Int(32), Halide::reinterpret(Halide::UInt(32), index.expr));
    return Halide::clamp(opaque, 0, buffer.dim(0).extent() - 1);
}

Value wrap_coordinate(const Texture& texture, const Value& u) {
    const Value repeat = u - floor(u);
    const Value h = u * constant(0.5f);
    const Value mirror = (h - floor(h)) * constant(2.0f);
    const Value p = select(texture.wrap_is(kWrapRepeat), repeat,
                           select(texture.wrap_is(kWrapMirror), mirror, u));
    return bound(p, -2.0f, 3.0f);
}

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

Axis make_axis(const Texture& texture, const Value& wrapped_u, const Value& n) {
    const Value scaled = wrapped_u * to_float(n);
    const Value x = select(texture.filter_is(kFilterNearest), scaled, scaled - constant(0.5f));
    const Value x0 = whole_to_int(floor(x));
    return {{wrapped(texture, x0, n), wrapped(texture, plus(x0, constant(1)), n)}, x - floor(x)};
}

std::string func_name(const LoweringContext& context, const char* kind, int32_t number) {
    return fmt::format("{}_{}{}", kind, context.feeds_sample ? "early_" : "", number);
}

NamedFunc& new_func(LoweringContext* context, const std::string& name,
                    const std::vector<Halide::Var>& vars) {
    NamedFunc named{name, Halide::Func(name), {}};
    for (const Halide::Var& var : vars)
        named.vars.emplace_back(var.name(), var);
    // If its size is known only at run time, Halide allocates it on the heap.
    named.func.store_in(Halide::MemoryType::Stack);
    context->funcs->push_back(named);
    return context->funcs->back();
}

Expr element(const Halide::Func& func, const std::vector<Expr>& at, size_t k) {
    if (func.outputs() == 1) return func(at);
    return func(at)[static_cast<int>(k)];
}

std::vector<Expr> exprs(const std::vector<Halide::Var>& vars) {
    return {vars.begin(), vars.end()};
}

Halide::Func store_values(LoweringContext* context, const std::string& name,
                          const std::vector<Value*>& fields) {
    Halide::Func func = new_func(context, name, context->vars).func;
    std::vector<Expr> stored;
    for (const Value* field : fields)
        stored.push_back(field->expr);
    func(context->vars) = Halide::Tuple(stored);
    int k = 0;
    for (Value* field : fields)
        field->expr = func(exprs(context->vars))[k++];
    return func;
}

Expr most_taps(LoweringContext* context, const std::string& name, const Halide::Func& stored) {
    const std::vector<Halide::Var> group(context->vars.begin() + 1, context->vars.end());
    Halide::Func limit = new_func(context, name, group).func;
    Expr most = 0;
    for (int32_t lane = 0; lane < kLanes; ++lane) {
        std::vector<Expr> at = exprs(context->vars);
        at[0] = lane;
        most = Halide::max(most, element(stored, at, 0));
    }
    limit(group) = most;
    return limit(exprs(group));
}

}  // namespace openfab::lower

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Lookups in pictures: generated code computes the coordinates, an extern stage (texture/sample.h)
// samples all coordinates of a batch, whose size the schedule sets. compiler/interp/sample.h
// defines both.

#include <fmt/format.h>

#include <algorithm>

#include "abi/kernel_call.h"
#include "compiler/lower/algorithm/sample_parts.h"
#include "texture/sample.h"

namespace openfab::lower {

namespace {

using Halide::Expr;
using ir::Type;

constexpr int32_t kMaxChannel = 255;

/// Returns the vars of a Func with `field` inserted after the lane.
std::vector<Halide::Var> with_field(const LoweringContext& context, const Halide::Var& field) {
    std::vector<Halide::Var> out = context.vars;
    out.insert(out.begin() + 1, field);
    return out;
}

/// Makes the Func of sample requests: their numbers in order along `field` (texture/sample.h).
Halide::Func make_requests(LoweringContext* context, const std::string& name,
                           const std::vector<Value>& args) {
    std::vector<Value> fields = {select(args[0], constant(1.0f), constant(0.0f))};
    fields.insert(fields.end(), args.begin() + 1, args.end());
    const Halide::Var field("field");
    Expr value = fields[0].expr;
    for (size_t k = 1; k < fields.size(); ++k)
        value = Halide::select(field == static_cast<int>(k), fields[k].expr, value);
    const std::vector<Halide::Var> vars = with_field(*context, field);
    Halide::Func requests = new_func(context, name, vars).func;
    requests(vars) = value;
    requests.bound(context->vars[0], 0, kLanes).bound(field, 0, static_cast<int>(fields.size()));
    return requests;
}

}  // namespace

std::vector<Value> lower_sample(LoweringContext* context, int32_t texture_index,
                                const std::vector<int32_t>& channels,
                                const std::vector<Value>& args) {
    if (is_volume_sample(args.size()))
        return lower_volume_sample(context, texture_index, channels, args);
    const int32_t number = context->sample_count++;
    Halide::Func requests = make_requests(context, fmt::format("requests_{}", number), args);
    const bool footprint = args.size() > texture::kSampleFields;
    const int32_t fields = footprint ? texture::kSampleFieldsWithFootprint : texture::kSampleFields;
    int32_t asked = 0;
    for (size_t k = 0; k < channels.size(); ++k)
        asked |= std::min(channels[k], kMaxChannel) << 8 * k;

    const Halide::Var result("result");
    const std::vector<Halide::Var> vars = with_field(*context, result);
    NamedFunc& named = new_func(context, fmt::format("samples_{}", number), vars);
    named.func.define_extern(
        fmt::format("openfab_sample_{}",
                    abi::isa_name(std::min(context->isa, OPENFAB_ISA_AVX2))),  // the best there is
        {requests, context->textures.at({texture_index, OPENFAB_TEXTURE_TEXELS}),
         context->textures.at({texture_index, OPENFAB_TEXTURE_INFO}), Expr(fields), Expr(asked)},
        Halide::Float(32), vars, Halide::NameMangling::C);
    named.func.bound(result, 0, static_cast<int>(channels.size()));
    // All lanes at once, whatever part of them a schedule asks for (texture/sample.h).
    named.func.bound(context->vars[0], 0, kLanes);
    // An extern stage and what it reads cannot be inlined: unless a schedule places them, they are
    // computed at root.
    named.func.compute_root();
    requests.compute_root();
    std::vector<Value> out;
    for (size_t k = 0; k < channels.size(); ++k) {
        std::vector<Expr> at = exprs(context->vars);
        at.insert(at.begin() + 1, static_cast<int>(k));
        out.push_back({Type::kFloat, named.func(at)});
    }
    return out;
}

}  // namespace openfab::lower

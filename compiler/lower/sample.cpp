// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Look-ups in pictures: places are computed by generated code, what is there by an extern stage
// (texture/look_up.h), for all places that the schedule takes at once. Both are defined in
// compiler/interp/sample.h.

#include <fmt/format.h>

#include <algorithm>

#include "compiler/lower/compile.h"
#include "compiler/lower/sample_parts.h"
#include "texture/look_up.h"

namespace openfab::lower {

namespace {

using Halide::Expr;
using ir::Type;

constexpr int32_t kMostChannel = 255;

/// Vars of a Func with one more behind the lane.
std::vector<Halide::Var> with_field(const Site& site, const Halide::Var& field) {
    std::vector<Halide::Var> out = site.vars;
    out.insert(out.begin() + 1, field);
    return out;
}

/// The numbers of an openfab_look_up place, one after the other along `field`.
Halide::Func make_places(Site* site, const std::string& name, const std::vector<Value>& args) {
    std::vector<Value> fields = {select(args[0], constant(1.0f), constant(0.0f))};
    fields.insert(fields.end(), args.begin() + 1, args.end());
    const Halide::Var field("field");
    Expr value = fields[0].expr;
    for (size_t k = 1; k < fields.size(); ++k)
        value = Halide::select(field == static_cast<int>(k), fields[k].expr, value);
    const std::vector<Halide::Var> vars = with_field(*site, field);
    Halide::Func places = new_func(site, name, vars).func;
    places(vars) = value;
    places.bound(site->vars[0], 0, kLanes).bound(field, 0, static_cast<int>(fields.size()));
    return places;
}

}  // namespace

std::vector<Value> lower_sample(Site* site, int32_t texture_index,
                                const std::vector<int32_t>& channels,
                                const std::vector<Value>& args) {
    if (is_volume_sample(args.size()))
        return lower_volume_sample(site, texture_index, channels, args);
    const int32_t number = site->lookups++;
    Halide::Func places = make_places(site, fmt::format("places_{}", number), args);
    const bool footprint = args.size() > texture::kPlaceFields;
    const int32_t fields = footprint ? texture::kPlaceFieldsWithFootprint : texture::kPlaceFields;
    int32_t asked = 0;
    for (size_t k = 0; k < channels.size(); ++k)
        asked |= std::min(channels[k], kMostChannel) << 8 * k;

    const Halide::Var result("result");
    const std::vector<Halide::Var> vars = with_field(*site, result);
    NamedFunc& named = new_func(site, fmt::format("picture_{}", number), vars);
    named.func.define_extern(
        fmt::format("openfab_look_up_{}", isa_name(site->isa)),
        {places, site->textures.at({texture_index, OPENFAB_TEXTURE_TEXELS}),
         site->textures.at({texture_index, OPENFAB_TEXTURE_INFO}), Expr(fields), Expr(asked)},
        Halide::Float(32), vars, Halide::NameMangling::C);
    named.func.bound(result, 0, static_cast<int>(channels.size()));
    // An extern stage and what it reads cannot be inlined: where no schedule places them, they come
    // first of all.
    named.func.compute_root();
    places.compute_root();
    std::vector<Value> out;
    for (size_t k = 0; k < channels.size(); ++k) {
        std::vector<Expr> at = exprs(site->vars);
        at.insert(at.begin() + 1, static_cast<int>(k));
        out.push_back({Type::kFloat, named.func(at)});
    }
    return out;
}

}  // namespace openfab::lower

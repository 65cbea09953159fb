// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/queries.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "abi/shape_distance.h"
#include "compiler/ir/arithmetic.h"

namespace openfab::translate {

using ir::Op;
using ir::ValueId;

namespace {

constexpr int32_t kOwnSurface = -1;
constexpr int32_t kMaxChannel = 63;  // no supported image format has more

/// Returns the indices that a texture, material or object value may have, ascending; 0 to `all` - 1
/// if unknown.
std::vector<int32_t> possible_indices(const Emitter& emit, ValueId value, int32_t all) {
    std::vector<int32_t> out;
    std::vector<ValueId> open = {value};
    std::set<ValueId> seen;
    while (!open.empty()) {
        const ValueId id = open.back();
        open.pop_back();
        if (!seen.insert(id).second) continue;
        const ir::Instr& instr = emit.instr(id);
        if (instr.op == Op::kConst) {
            out.push_back(ir::as_int(instr.bits));
        } else if (instr.op == Op::kSelect) {
            open.push_back(instr.args[1]);
            open.push_back(instr.args[2]);
        } else if (instr.op == Op::kPick) {
            open.insert(open.end(), instr.args.begin() + 1, instr.args.end());
        } else {
            out.resize(static_cast<size_t>(all));
            std::iota(out.begin(), out.end(), 0);
            return out;
        }
    }
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
}

}  // namespace

/// Returns a point in part space as a query takes it: relative to the part's centre. For the
/// voxel's centre it is, to the bit, what the runtime's own query uses.
Value Queries::local_point(const Value& point) {
    const bool shape = place_.kind == ir::StageKind::kShape;
    if (point == (shape ? inputs_.shape_point() : inputs_.voxel_center())) {
        Value local;
        for (const ValueId coordinate : point)
            local.push_back(emit_.instr(coordinate).args[0]);
        return local;
    }
    return formulas_.binary(Op::kSub, point, inputs_.frame_vector(OPENFAB_FRAME_CENTER));
}

ValueId Queries::query(int32_t object, ValueId guard, const Value& point) {
    const Value local = local_point(point);
    return emit_.query(object, guard, {local[0], local[1], local[2]});
}

Value Queries::distance(const check::Expr& expr) {
    const Value point = expressions_.expression(*expr.args[0]);
    if (!rules_.asks_in_volume(expr, "distance") || budget_.gave_up) return layout_.zero(expr.type);
    emit_.set_span(expr.span);
    if (point == inputs_.voxel_center())
        return {emit_.input(ir::Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0)};
    if (emit_.is_false(paths_.live)) return layout_.zero(expr.type);
    return {emit_.query_result(query(kOwnSurface, paths_.live, point), ir::Type::kFloat,
                               OPENFAB_QUERY_DISTANCE, 0, 0)};
}

Value Queries::nearest_point(const check::Expr& expr) {
    const Value point = expressions_.expression(*expr.args[0]);
    if (!rules_.asks_in_volume(expr, "nearest") || budget_.gave_up || emit_.is_false(paths_.live))
        return layout_.zero(expr.type);
    emit_.set_span(expr.span);
    const bool at_centre = point == inputs_.voxel_center();
    const ValueId asked = query(kOwnSurface, paths_.live, point);
    const auto result = [&](ir::Type type, openfab_query_result kind, int32_t a, int32_t b) {
        return emit_.query_result(asked, type, kind, a, b);
    };
    Value out;
    for (int32_t axis = 0; axis < 3; ++axis)
        out.push_back(result(ir::Type::kFloat, OPENFAB_QUERY_POSITION, 0, axis));
    out = formulas_.binary(Op::kAdd, out, inputs_.frame_vector(OPENFAB_FRAME_CENTER));
    for (int32_t axis = 0; axis < 3; ++axis)
        out.push_back(result(ir::Type::kFloat, OPENFAB_QUERY_NORMAL, 0, axis));
    out.push_back(at_centre ? emit_.input(ir::Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0)
                            : result(ir::Type::kFloat, OPENFAB_QUERY_DISTANCE, 0, 0));
    for (size_t k = 0; k < place_.fablet.ir.nearest.size(); ++k) {
        const ir::Varying& varying = place_.fablet.ir.nearest[k];
        const auto input = static_cast<int32_t>(k);
        for (int32_t c = 0; c < varying.components; ++c) {
            out.push_back(at_centre ? emit_.input(varying.type, OPENFAB_ARG_NEAREST, input, c)
                                    : result(varying.type, OPENFAB_QUERY_ATTRIBUTE, input, c));
        }
    }
    return out;
}

/// If the object varies, each candidate is asked under the condition that it is selected.
Value Queries::of_selected(const check::Expr& expr, ValueId object,
                           const std::function<Value(int32_t index, ValueId guard)>& ask) {
    const std::vector<int32_t> objects =
        possible_indices(emit_, object, place_.fablet.ir.object_count);
    Value out = layout_.zero(expr.type);
    for (const int32_t index : objects) {
        const ValueId here =
            objects.size() == 1
                ? emit_.constant(true)
                : emit_.binary(Op::kEq, object,
                               emit_.constant(ir::Type::kInt, static_cast<uint32_t>(index)));
        const ValueId guard = emit_.logical_and(paths_.live, here);
        if (emit_.is_false(guard)) continue;
        const Value answer = ask(index, guard);
        for (size_t k = 0; k < out.size(); ++k)
            out[k] = emit_.select(here, answer[k], out[k]);
    }
    return out;
}

/// At a shape's own point it is an input, of which bounds over boxes are known.
Value Queries::distance_to(const check::Expr& expr) {
    const ValueId object = expressions_.scalar(*expr.args[0]);
    const Value point = expressions_.expression(*expr.args[1]);
    if (!rules_.asks_of_object(expr) || budget_.gave_up) return layout_.zero(expr.type);
    emit_.set_span(expr.span);
    return of_selected(expr, object, [&](int32_t index, ValueId guard) -> Value {
        if (place_.kind == ir::StageKind::kShape && point == inputs_.shape_point())
            return {emit_.input(ir::Type::kFloat, abi::kShapeDistance, index, 0)};
        return {emit_.query_result(query(index, guard, point), ir::Type::kFloat,
                                   OPENFAB_QUERY_DISTANCE, 0, 0)};
    });
}

Value Queries::walk_end(const check::Expr& expr) {
    const size_t first = expr.args.size() - 3;
    const ValueId object =
        first == 0 ? emit_.constant(kOwnSurface) : expressions_.scalar(*expr.args[0]);
    const Value point = expressions_.expression(*expr.args[first]);
    const ValueId stop = expressions_.scalar(*expr.args[first + 1]);
    const ValueId seed = expressions_.scalar(*expr.args[first + 2]);
    if (!rules_.asks_in_volume(expr, "walk_end") || budget_.gave_up || emit_.is_false(paths_.live))
        return layout_.zero(expr.type);
    emit_.set_span(expr.span);
    const Value local = local_point(point);
    return of_selected(expr, object, [&](int32_t index, ValueId guard) {
        const ValueId walk = emit_.walk(index, guard, {local[0], local[1], local[2]}, stop, seed);
        Value end;
        for (int32_t axis = 0; axis < 3; ++axis)
            end.push_back(emit_.query_result(walk, ir::Type::kFloat, OPENFAB_QUERY_END, 0, axis));
        end = formulas_.binary(Op::kAdd, end, inputs_.frame_vector(OPENFAB_FRAME_CENTER));
        end.push_back(index < 0 ? emit_.constant(0.0f)
                                : emit_.convert(emit_.query_result(walk, ir::Type::kInt,
                                                                   OPENFAB_QUERY_END_ON, 0, 0),
                                                ir::Type::kFloat));
        return end;
    });
}

Value Queries::sample(const check::Expr& expr) {
    const ValueId texture = expressions_.scalar(*expr.args[0]);
    const ValueId channel = expressions_.scalar(*expr.args[1]);
    const ValueId width = expressions_.scalar(*expr.args[2]);
    Value at;
    for (size_t i = 3; i < expr.args.size(); ++i) {
        const Value part = expressions_.expression(*expr.args[i]);
        at.insert(at.end(), part.begin(), part.end());
    }
    if (budget_.gave_up || rules_.refuse_in_dither(expr, fmt::format("Sample{}", expr.type.size)))
        return layout_.zero(expr.type);
    emit_.set_span(expr.span);
    if (!emit_.is_constant(channel)) {
        sink_->report(expr.args[1]->span, diag::kNotConstant, "the channel of a lookup");
        return layout_.zero(expr.type);
    }
    const int32_t first = ir::as_int(emit_.instr(channel).bits);
    if (first < 0 || first > kMaxChannel) {
        sink_->report(expr.args[1]->span, diag::kOutOfRange, "channel", first, 0, kMaxChannel);
        return layout_.zero(expr.type);
    }
    // Who reads alpha, too, puts the colour itself where it says.
    const bool picture = at.size() == 2;
    const bool with_alpha = picture && first + expr.type.size > ir::kAlphaChannel;
    // If the texture varies, each candidate is sampled under the condition that it is selected.
    const std::vector<int32_t> textures =
        possible_indices(emit_, texture, place_.fablet.ir.texture_count);
    Value out = layout_.zero(expr.type);
    if (textures.size() > check::kMaxTextures) {
        sink_
            ->report(expr.span, diag::kTooComplex,
                     fmt::format("a varying index that may pick one of {} textures; at most {} "
                                 "are supported",
                                 textures.size(), check::kMaxTextures))
            .help("each of them is sampled separately: pack them into one texture");
        return out;
    }
    for (int32_t index : textures) {
        const ValueId here =
            textures.size() == 1
                ? emit_.constant(true)
                : emit_.binary(Op::kEq, texture,
                               emit_.constant(ir::Type::kInt, static_cast<uint32_t>(index)));
        const ValueId guard = emit_.logical_and(paths_.live, here);
        Value args = {guard};
        args.insert(args.end(), at.begin(), at.end());
        args.push_back(width);
        for (int32_t i = 0; i < expr.type.size; ++i) {
            const bool own = with_alpha && first + i < ir::kAlphaChannel;
            const int32_t number = first + i + (own ? ir::kOwnColor : 0);
            const ValueId value = emit_.sample(index, number, args);
            out[i] = emit_.select(here, value, out[i]);
        }
    }
    return out;
}

/// Reads the one of a rule's `count` inputs of a kind that the argument names. A number beyond them
/// is the nearest, as of an array.
Value Queries::numbered(const check::Expr& expr, int32_t kind, int32_t count) {
    const ValueId number = expressions_.scalar(*expr.args[0]);
    if (budget_.gave_up) return layout_.zero(expr.type);
    emit_.set_span(expr.span);
    ValueId out = emit_.input(ir::Type::kInt, kind, 0, 0);
    for (int32_t k = 1; k < count; ++k) {
        const ValueId from_here = emit_.binary(Op::kGe, number, emit_.constant(k));
        if (emit_.is_false(from_here)) break;
        out = emit_.select(from_here, emit_.input(ir::Type::kInt, kind, k, 0), out);
    }
    return {out};
}

}  // namespace openfab::translate

// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Queries of surfaces. A query of the part's own surface at the voxel's centre becomes inputs,
// which the runtime computes for whole blocks; any other is a Query under the condition that the
// call is reached.

#include "abi/shape_distance.h"
#include "compiler/translate/stage_translator.h"

namespace openfab::translate {

using ir::Op;
using ir::ValueId;

namespace {

constexpr int32_t kOwnSurface = -1;

}  // namespace

/// Returns true after a message if the function was called from a dither stage.
bool StageTranslator::refuse_in_dither(const check::Expr& expr, std::string_view what) {
    if (kind_ != ir::StageKind::kDither) return false;
    sink_->report(expr.span, diag::kStageMismatch, what, "called in a dither stage")
        .note(fablet_.dither.span, "stage declared `@Dither` here, which calls this function")
        .help("a dither rule looks at the voxel's fractions and its index");
    return true;
}

/// Returns true after a message if the function was called from a shape stage.
bool StageTranslator::refuse_in_shape(const check::Expr& expr, std::string_view what,
                                      const char* help) {
    if (kind_ != ir::StageKind::kShape && !grows()) return false;
    sink_
        ->report(expr.span, diag::kStageMismatch, what,
                 grows() ? "called in a grow stage" : "called in a shape stage")
        .note(fablet_.shape.span, grows()
                                      ? "stage declared `@Grow` here, which calls this function"
                                      : "stage declared `@Shape` here, which calls this function")
        .help(grows() ? check::kNoQueriesInGrow : help);
    return true;
}

/// Returns false after a message if the function was called from another stage.
bool StageTranslator::asks_in_volume(const check::Expr& expr, const char* name) {
    if (refuse_in_dither(expr, name) || refuse_in_shape(expr, name, check::shape_query_help(name)))
        return false;
    if (kind_ != ir::StageKind::kSurface) return true;
    sink_->report(expr.span, diag::kStageMismatch, name, "called in a surface stage")
        .note(fablet_.surface.span, "stage declared `@Surface` here, which calls this function");
    return false;
}

/// As asks_in_volume, of what a shape may ask, too.
bool StageTranslator::asks_of_object(const check::Expr& expr) {
    return kind_ == ir::StageKind::kShape || asks_in_volume(expr, "distance_to");
}

/// Returns a point in part space as a query takes it: relative to the part's centre. For the
/// voxel's centre it is, to the bit, what the runtime's own query uses.
Value StageTranslator::local_point(const Value& point) {
    const bool shape = kind_ == ir::StageKind::kShape;
    if (point == (shape ? shape_point() : voxel_center())) {
        Value local;
        for (const ValueId coordinate : point)
            local.push_back(emit_.instr(coordinate).args[0]);
        return local;
    }
    return formulas_.binary(Op::kSub, point, frame_vector(OPENFAB_FRAME_CENTER));
}

ValueId StageTranslator::query(int32_t object, ValueId guard, const Value& point) {
    const Value local = local_point(point);
    return emit_.query(object, guard, {local[0], local[1], local[2]});
}

Value StageTranslator::distance(const check::Expr& expr) {
    const Value point = expression(*expr.args[0]);
    if (!asks_in_volume(expr, "distance") || gave_up_) return zero(expr.type);
    emit_.set_span(expr.span);
    if (point == voxel_center()) return {emit_.input(ir::Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0)};
    if (emit_.is_false(live_)) return zero(expr.type);
    return {emit_.query_result(query(kOwnSurface, live_, point), ir::Type::kFloat,
                               OPENFAB_QUERY_DISTANCE, 0, 0)};
}

Value StageTranslator::nearest_point(const check::Expr& expr) {
    const Value point = expression(*expr.args[0]);
    if (!asks_in_volume(expr, "nearest") || gave_up_ || emit_.is_false(live_))
        return zero(expr.type);
    emit_.set_span(expr.span);
    const bool at_centre = point == voxel_center();
    const ValueId asked = query(kOwnSurface, live_, point);
    const auto result = [&](ir::Type type, openfab_query_result kind, int32_t a, int32_t b) {
        return emit_.query_result(asked, type, kind, a, b);
    };
    Value out;
    for (int32_t axis = 0; axis < 3; ++axis)
        out.push_back(result(ir::Type::kFloat, OPENFAB_QUERY_POSITION, 0, axis));
    out = formulas_.binary(Op::kAdd, out, frame_vector(OPENFAB_FRAME_CENTER));
    for (int32_t axis = 0; axis < 3; ++axis)
        out.push_back(result(ir::Type::kFloat, OPENFAB_QUERY_NORMAL, 0, axis));
    out.push_back(at_centre ? emit_.input(ir::Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0)
                            : result(ir::Type::kFloat, OPENFAB_QUERY_DISTANCE, 0, 0));
    for (size_t k = 0; k < fablet_.ir.nearest.size(); ++k) {
        const ir::Varying& varying = fablet_.ir.nearest[k];
        const auto input = static_cast<int32_t>(k);
        for (int32_t c = 0; c < varying.components; ++c) {
            out.push_back(at_centre ? emit_.input(varying.type, OPENFAB_ARG_NEAREST, input, c)
                                    : result(varying.type, OPENFAB_QUERY_ATTRIBUTE, input, c));
        }
    }
    return out;
}

/// If the object varies, each candidate is queried under the condition that it is selected. At a
/// shape's own point it is an input, of which bounds over boxes are known.
Value StageTranslator::distance_to(const check::Expr& expr) {
    const ValueId object = scalar(*expr.args[0]);
    const Value point = expression(*expr.args[1]);
    if (!asks_of_object(expr) || gave_up_) return zero(expr.type);
    emit_.set_span(expr.span);
    const std::vector<int32_t> objects = possible_indices(object, fablet_.ir.object_count);
    Value out = zero(expr.type);
    for (const int32_t index : objects) {
        const ValueId here =
            objects.size() == 1
                ? emit_.constant(true)
                : emit_.binary(Op::kEq, object,
                               emit_.constant(ir::Type::kInt, static_cast<uint32_t>(index)));
        const ValueId guard = emit_.logical_and(live_, here);
        if (emit_.is_false(guard)) continue;
        const ValueId value = kind_ == ir::StageKind::kShape && point == shape_point()
                                  ? emit_.input(ir::Type::kFloat, abi::kShapeDistance, index, 0)
                                  : emit_.query_result(query(index, guard, point), ir::Type::kFloat,
                                                       OPENFAB_QUERY_DISTANCE, 0, 0);
        out[0] = emit_.select(here, value, out[0]);
    }
    return out;
}

}  // namespace openfab::translate
